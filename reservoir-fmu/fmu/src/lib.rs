//! The reservoir as an FMI library.

interface::export_fmi3!(reservoir::Reservoir);
