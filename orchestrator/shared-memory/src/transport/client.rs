use super::wait::Wait;
use super::{
    ATTRIBUTE_LAYOUT, ATTRIBUTE_PROTOCOL, Folder, Header, PROTOCOL_VERSION, PrivateFiles, ServiceKind,
    TransportError, Usual, node, service_name, shared_memory_error,
};
use iceoryx2::port::client::Client as Port;
use iceoryx2::prelude::{AllocationStrategy, AttributeSet, ServiceName};
use iceoryx2::service::Service;
use iceoryx2::service::attribute::AttributeKey;
use iceoryx2::service::builder::request_response::RequestResponseOpenError;
use iceoryx2::service::port_factory::PortFactory;
use std::fmt::Debug;
use std::time::Duration;

/// The orchestrator's side of a unit's service.
pub struct Client(Kind);

enum Kind {
    PrivateFiles(Connection<PrivateFiles>),
    Ipc(Connection<Usual>),
}

/// Waiting time after which the caller checks between sleeps whether to go on waiting.
const LATE: Duration = Duration::from_millis(10);

impl Client {
    /// Opens the service of `unit` in the run of `folder`, whose requests have up to `values` values.
    ///
    /// **Errors**: no such service; another protocol version; a `layout` other than the
    /// service carries; no shared memory.
    pub fn open(
        folder: &Folder,
        kind: &ServiceKind,
        unit: &str,
        layout: &str,
        values: usize,
    ) -> Result<Self, TransportError> {
        Ok(Self(match kind {
            ServiceKind::PrivateFiles => {
                Kind::PrivateFiles(Connection::open(folder, kind, unit, layout, values)?)
            }
            ServiceKind::Ipc { .. } => Kind::Ipc(Connection::open(folder, kind, unit, layout, values)?),
        }))
    }

    /// Allocates memory for a request of `values` values and frees it.
    pub(super) fn reserve(&mut self, values: usize) -> Result<(), TransportError> {
        match &self.0 {
            Kind::PrivateFiles(connection) => connection.reserve(values),
            Kind::Ipc(connection) => connection.reserve(values),
        }
    }

    /// Sends a request and waits for its answer, which it hands to `take`; returns the answer's header.
    ///
    /// When the answer is late (10 ms), `look` is called after every sleep; its error ends the wait.
    ///
    /// **Errors**: the unit is not connected; the answer does not echo the header; whatever `look` returns.
    pub fn call<E: From<TransportError>>(
        &mut self,
        header: Header,
        values: &[f64],
        take: impl FnOnce(&Header, &[f64]) -> Result<(), TransportError>,
        look: impl FnMut() -> Result<(), E>,
    ) -> Result<Header, E> {
        match &mut self.0 {
            Kind::PrivateFiles(connection) => connection.call(header, values, take, look),
            Kind::Ipc(connection) => connection.call(header, values, take, look),
        }
    }
}

/// The client's port at a service of the kind `S`.
struct Connection<S: Service> {
    unit: String,
    port: Port<S, [f64], Header, [f64], Header>,
    wait: Wait,
}

impl<S: Service> Connection<S> {
    fn open(
        folder: &Folder,
        kind: &ServiceKind,
        unit: &str,
        layout: &str,
        values: usize,
    ) -> Result<Self, TransportError> {
        let failed = |e: &dyn Debug| shared_memory_error("opening the service of a unit", &e);
        let node = node::<S>(folder, kind)?;
        let service = service_name(folder.run(), unit);
        let name = ServiceName::new(&service).map_err(|e| failed(&e))?;
        let builder = node.service_builder(&name).request_response::<[f64], [f64]>();
        let builder = builder.request_user_header::<Header>().response_user_header::<Header>();
        let factory = builder.open().map_err(|e| match e {
            RequestResponseOpenError::DoesNotExist => {
                TransportError::NotConnected { unit: unit.to_owned(), service: service.clone() }
            }
            e => failed(&e),
        })?;
        let attributes = factory.attributes();
        let found = attribute(attributes, ATTRIBUTE_PROTOCOL).parse().unwrap_or(0);
        if found != PROTOCOL_VERSION {
            let expected = PROTOCOL_VERSION;
            return Err(TransportError::Protocol { unit: unit.to_owned(), expected, found });
        }
        let found = attribute(attributes, ATTRIBUTE_LAYOUT);
        if found != layout {
            let expected = layout.to_owned();
            return Err(TransportError::Layout { unit: unit.to_owned(), expected, found });
        }
        let port = factory
            .client_builder()
            .initial_max_slice_len(values.max(1))
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .create()
            .map_err(|e| failed(&e))?;
        Ok(Self { unit: unit.to_owned(), port, wait: Wait::new() })
    }

    fn reserve(&self, values: usize) -> Result<(), TransportError> {
        let request = self.port.loan_slice(values);
        request.map(drop).map_err(|e| shared_memory_error("taking memory", &e))
    }

    fn call<E: From<TransportError>>(
        &mut self,
        header: Header,
        values: &[f64],
        take: impl FnOnce(&Header, &[f64]) -> Result<(), TransportError>,
        mut look: impl FnMut() -> Result<(), E>,
    ) -> Result<Header, E> {
        let failed = |e: &dyn Debug| shared_memory_error("sending a request", &e);
        let mut request = self.port.loan_slice_uninit(values.len()).map_err(|e| failed(&e))?;
        *request.user_header_mut() = header;
        let pending = request.write_from_slice(values).send().map_err(|e| failed(&e))?;
        if pending.number_of_server_connections() == 0 {
            let service = service_name(header.run, &self.unit);
            return Err(TransportError::NotConnected { unit: self.unit.clone(), service }.into());
        }
        self.wait.begin();
        loop {
            let answer = pending.receive().map_err(|e| shared_memory_error("receiving an answer", &e))?;
            if let Some(answer) = answer {
                self.wait.end();
                let found = *answer.user_header();
                if let Some((field, sent, found)) = header.difference(&found) {
                    return Err(TransportError::Echo { unit: self.unit.clone(), field, sent, found }.into());
                }
                take(&found, answer.payload())?;
                return Ok(found);
            }
            let waited = self.wait.pause();
            if waited > LATE {
                look()?;
            }
        }
    }
}

fn attribute(attributes: &AttributeSet, key: &str) -> String {
    let key = AttributeKey::try_from(key).ok();
    let value = key.and_then(|key| attributes.key_value(&key, 0).map(ToString::to_string));
    value.unwrap_or_default()
}
