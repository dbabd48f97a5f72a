use iceoryx2::prelude::{ZeroCopySend, ipc_threadsafe};
use iceoryx2::service::Service;
use iceoryx2::service::internal::ServiceInternal;
use iceoryx2_bb_elementary_traits::testing::abandonable::Abandonable;
use iceoryx2_cal::shm_allocator::bump_allocator::BumpAllocator;
use iceoryx2_cal::shm_allocator::pool_allocator::PoolAllocator;
use iceoryx2_cal::{dynamic_storage, resizable_shared_memory, shared_memory, zero_copy_connection};
use serde::{Deserialize, Serialize};
use std::fmt::Debug;

/// The kind of iceoryx2 service by which a unit is reached, and what is needed to find it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "service", rename_all = "kebab-case")]
pub enum ServiceKind {
    /// Files in the folder of the run, which other users cannot enter: for the built-in units.
    PrivateFiles,
    /// iceoryx2's usual service between processes, which its bindings for other languages offer.
    Ipc {
        /// Configured prefix of all its names; it is random, so that they cannot be taken beforehand.
        prefix: String,
    },
}

/// iceoryx2's service between processes, with memory in files below the root path in place of POSIX shared memory. The names
/// of the latter all lie in one folder of the machine, where every user sees them and can take the next one; and the counter
/// of nodes there can be written by all. In a folder of `/dev/shm` files are the same memory.
#[derive(Clone, Debug)]
pub struct PrivateFiles {}

impl ServiceInternal<Self> for PrivateFiles {}

/// iceoryx2's usual service between processes.
pub type Usual = ipc_threadsafe::Service;
type Memory<Allocator> = shared_memory::file::Memory<Allocator>;
type Storage<T> = dynamic_storage::file::Storage<T>;

impl Service for PrivateFiles {
    type PersistentDynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> = Storage<T>;
    type DynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> = Storage<T>;
    type SharedMemory = Memory<PoolAllocator>;
    type ResizableSharedMemory =
        resizable_shared_memory::dynamic::DynamicMemory<PoolAllocator, Self::SharedMemory>;
    type Connection = zero_copy_connection::file::Connection;
    type BlackboardMgmt<T: Send + Sync + Debug + ZeroCopySend + 'static> = Storage<T>;
    type BlackboardPayload = Memory<BumpAllocator>;

    type ServiceNameHasher = <Usual as Service>::ServiceNameHasher;
    type StaticStorage = <Usual as Service>::StaticStorage;
    type ConfigSerializer = <Usual as Service>::ConfigSerializer;
    type Bag = <Usual as Service>::Bag;
    type Event = <Usual as Service>::Event;
    type Monitoring = <Usual as Service>::Monitoring;
    type Reactor = <Usual as Service>::Reactor;
    type ArcThreadSafetyPolicy<T: Send + Debug + Abandonable> = <Usual as Service>::ArcThreadSafetyPolicy<T>;
    type UniqueId = <Usual as Service>::UniqueId;
}
