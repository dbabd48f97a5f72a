//! The reservoir's tests, in one program: each file is a module, `cargo test --release -p cofferdam-reservoir methods::` runs one.

mod bustamante_1963;
mod chopra_1967;
mod chwang_1978;
mod co_simulation;
mod convergence;
mod explicit_coupling;
mod extremes;
mod face_response;
mod far_end_conditions;
mod fenves_chopra_1984;
mod finite_elements;
mod geometry;
mod ground_motion;
mod incompressible;
mod invariants;
mod methods;
mod pressure_field;
mod rectangular;
mod shipped;
mod sommerfeld;
mod static_pressure;
mod tailwater;
mod trefftz_1926;
mod westergaard_1933;
mod whole_record;
