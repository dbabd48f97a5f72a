/// What holds on a part of the boundary; n points out of the water.
///
/// The free surface (`p = 0`) is no part of the mesh: the kernel's image source satisfies it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundaryCondition {
    /// The far end: `∂p/∂n = −T p`, waves travel away from the dam.
    Radiation,
    /// The bed: `∂p/∂n = −q s p` with `q = (1 − α)/((1 + α) c)`.
    AbsorbingBed,
    /// The dam: `∂p/∂n = −ρ s v` with the velocity v along n.
    WetFace,
}
