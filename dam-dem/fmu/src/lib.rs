//! The dam as an FMI library.

cofferdam_unit::export_fmi!(cofferdam_dam::Dam);
