/// Boundary condition on a part of the boundary; n points out of the water.
///
/// Without gravity waves the surface (`p = 0`) is not meshed: the kernel's image source satisfies its condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundaryCondition {
    /// The far end: `∂p/∂n = −T p`; waves travel away from the dam.
    Radiation,
    /// The bed: `∂p/∂n = −ρ s v − q s p` with its velocity v along n and `q = (1 − α)/((1 + α) c)`.
    AbsorbingBed,
    /// The dam: `∂p/∂n = −ρ s v` with the velocity v along n.
    WetFace,
    /// The surface with gravity waves: `∂p/∂n = −(s²/g) p`.
    SurfaceWaves,
}

impl std::fmt::Display for BoundaryCondition {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Radiation => "far end",
            Self::AbsorbingBed => "bed",
            Self::WetFace => "wet face",
            Self::SurfaceWaves => "surface",
        })
    }
}

/// Condition at the far end; only the first is right for water that continues upstream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FarEndCondition {
    /// Waves travel away: `∂p/∂n = −T (p − p₁)`.
    #[default]
    Outgoing,
    /// None: the boundary integrals leave out the far end, as if the boundary were closed without it.
    LeftOut,
    /// `∂p/∂n = 0`: a wall.
    NoFlow,
    /// `p = 0`: the water ends at a free surface.
    NoPressure,
}
