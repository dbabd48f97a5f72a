//! dam_dem
