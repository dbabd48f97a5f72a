//! The cache of this process, and the context of the library.

use crate::terminal::Terminal;
use cofferdam_analysis::context::Context;
use cofferdam_assembly::Making;
use cofferdam_assembly::cache::Cache;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::OnceLock;

/// The cache of this process; none without [`use_cache`].
static CACHE: OnceLock<Option<Cache>> = OnceLock::new();

/// Uses the cache in this `folder`, or that of the user; none if it is not `wanted`.
pub fn use_cache(folder: Option<PathBuf>, wanted: bool) {
    let folder = folder.filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.map(|folder| std::path::absolute(&folder).unwrap_or(folder));
    CACHE.get_or_init(|| folder.map(Cache::at).or_else(Cache::of_user).filter(|_| wanted));
}

/// The cache in use.
pub fn used_cache() -> Option<&'static Cache> {
    CACHE.get().and_then(Option::as_ref)
}

/// Making units on these threads, with the cache in use.
pub fn making(threads: NonZeroUsize) -> Making<'static> {
    Making { threads, cache: used_cache() }
}

/// The context of the library: the cache in use, and the terminal.
pub fn context() -> Context<'static> {
    Context { cache: used_cache(), program: None, reporter: &Terminal }
}
