//! The reservoir as an FMI library.

cofferdam_unit::export_fmi3!(cofferdam_reservoir::Reservoir);
