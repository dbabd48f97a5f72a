use super::wait::Wait;
use super::{
    Folder, Header, PrivateFiles, ServiceKind, TransportError, Usual, attributes, node, service_name,
    shared_memory_error,
};
use iceoryx2::port::server::Server as Port;
use iceoryx2::prelude::{AllocationStrategy, ServiceName};
use iceoryx2::service::Service;
use std::fmt::Debug;
use std::sync::atomic::{AtomicBool, Ordering};

/// A unit's side of its service.
pub struct Server(Kind);

enum Kind {
    PrivateFiles(Connection<PrivateFiles>),
    Ipc(Connection<Usual>),
}

impl Server {
    /// Makes the service of `unit` in the run of `folder`, whose answers have up to `values` values.
    ///
    /// **Errors**: the service exists; no shared memory.
    pub fn create(
        folder: &Folder,
        kind: &ServiceKind,
        unit: &str,
        layout: &str,
        values: usize,
    ) -> Result<Self, TransportError> {
        Ok(Self(match kind {
            ServiceKind::PrivateFiles => {
                Kind::PrivateFiles(Connection::create(folder, kind, unit, layout, values)?)
            }
            ServiceKind::Ipc { .. } => Kind::Ipc(Connection::create(folder, kind, unit, layout, values)?),
        }))
    }

    /// Answers requests until `over`: `answer` gets header and values of each and fills header and values of the
    /// answer, which are the request's header and empty at first.
    ///
    /// **Errors**: the answer cannot be sent.
    pub fn serve(
        &self,
        over: &AtomicBool,
        answer: impl FnMut(&mut Header, &[f64], &mut Vec<f64>),
    ) -> Result<(), TransportError> {
        match &self.0 {
            Kind::PrivateFiles(connection) => connection.serve(over, answer),
            Kind::Ipc(connection) => connection.serve(over, answer),
        }
    }
}

/// The server's port at a service of the kind `S`.
struct Connection<S: Service> {
    port: Port<S, [f64], Header, [f64], Header>,
}

impl<S: Service> Connection<S> {
    fn create(
        folder: &Folder,
        kind: &ServiceKind,
        unit: &str,
        layout: &str,
        values: usize,
    ) -> Result<Self, TransportError> {
        let failed = |e: &dyn Debug| shared_memory_error("making the service of a unit", &e);
        let node = node::<S>(folder, kind)?;
        let name = ServiceName::new(&service_name(folder.run(), unit)).map_err(|e| failed(&e))?;
        let builder = node.service_builder(&name).request_response::<[f64], [f64]>();
        let builder = builder.request_user_header::<Header>().response_user_header::<Header>();
        let builder = builder.max_clients(1).max_servers(1).max_nodes(4);
        let factory = builder.create_with_attributes(&attributes(layout)?).map_err(|e| failed(&e))?;
        let port = factory
            .server_builder()
            .initial_max_slice_len(values.max(1))
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .create()
            .map_err(|e| failed(&e))?;
        Ok(Self { port })
    }

    fn serve(
        &self,
        over: &AtomicBool,
        mut answer: impl FnMut(&mut Header, &[f64], &mut Vec<f64>),
    ) -> Result<(), TransportError> {
        let failed = |e: &dyn Debug| shared_memory_error("sending an answer", &e);
        let mut values = Vec::new();
        let mut wait = Wait::new();
        while !over.load(Ordering::Acquire) {
            let request = self.port.receive().map_err(|e| shared_memory_error("receiving a request", &e))?;
            let Some(request) = request else {
                wait.pause();
                continue;
            };
            wait.end();
            let mut header = *request.user_header();
            values.clear();
            answer(&mut header, request.payload(), &mut values);
            let mut response = request.loan_slice_uninit(values.len()).map_err(|e| failed(&e))?;
            *response.user_header_mut() = header;
            response.write_from_slice(&values).send().map_err(|e| failed(&e))?;
            wait.begin();
        }
        Ok(())
    }
}
