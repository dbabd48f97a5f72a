//! The dam as an FMI library.

interface::export_fmi3!(dam_dem::Dam);
