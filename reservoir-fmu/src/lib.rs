//! reservoir
