//! Dam and waters, coupled, as an FMI library.

cofferdam_unit::export_fmi!(cofferdam_assembly::packing::Coupled);
