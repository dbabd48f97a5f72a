//! The reservoir as an FMI library.

cofferdam_unit::export_fmi!(cofferdam_reservoir::Reservoir);
