//! Mass damping that lets blocks slide and rock freely.
//!
//! `C = α M` is a drag against the ground. It damps the vibration of a dam whose cracks are closed, and would also slow
//! down a block that slides or rocks, which no material does. Mass damping therefore acts on the motion without the
//! rigid motion R j that the jumps of the cracks give to the blocks beyond them ([`Parting`], [`Carried`]):
//!
//! ```text
//! C = α Pᵀ M P,   P v = v − R j,   j = J v
//! −C v = −α M v + q,   q = α (M R j + Jᵀ Rᵀ M P v)
//! ```
//!
//! C is symmetric and positive semidefinite in every state of the contacts: it never gives energy. With closed cracks
//! j = 0 and C = α M. A block that slides, or rocks with gaps that count wholly, without deformation feels nothing: P v = 0.
//!
//! **Source**: the error of C = α M, J.F. Hall, *Problems encountered from the use (or misuse) of Rayleigh damping*,
//! Earthquake Engineering and Structural Dynamics 35 (2006), who bounds stiffness damping and omits mass damping instead;
//! tested in `structure.rs` and `tests/sliding_damping.rs`.

use crate::Mesh;
use crate::contact::Parting;

/// Which block is carried by which body: a tree whose roots are the ground and the blocks that it holds.
///
/// The rigid motion of a block is that of its carrier plus the jump of the seam between them. Where blocks could be carried
/// in several ways, the longest seams count: in a motion of rigid blocks all ways give the same.
#[derive(Clone, Debug, Default)]
pub(crate) struct Carried {
    /// One for each block that is not held, carriers first.
    pub links: Vec<Link>,
    blocks: usize,
}

/// A block and what carries it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Link {
    pub block: usize,
    /// The link of its carrier's block; none for what is held.
    carrier_link: Option<usize>,
    /// The carrying block; none for what is held.
    pub carrier: Option<usize>,
    pub seam: usize,
    /// 1 if the block is the upper side of the seam, −1 if it is the lower one.
    pub sign: f64,
}

impl Carried {
    /// What carries the blocks of `mesh` across its first `seams`; the ground holds some of its nodes. Blocks that hang
    /// together without ground are carried by the first of them.
    pub fn of(mesh: &Mesh, seams: usize, is_held: impl Fn(usize) -> bool) -> Self {
        let length = |seam: usize| mesh.length(&mesh.seams[seam].upper);
        let mut longest: Vec<usize> = (0..seams).collect();
        longest.sort_by(|&a, &b| length(b).total_cmp(&length(a)));
        let held = |block: usize| mesh.blocks[block].nodes.clone().any(&is_held);
        // of each body that is in the tree, its link; none for its roots
        let mut places: Vec<Option<Option<usize>>> = (0..=mesh.blocks.len())
            .map(|body| (mesh.is_ground(body) || held(body)).then_some(None))
            .collect();
        let mut links = Vec::new();
        loop {
            let grows = longest.iter().copied().find_map(|seam| {
                let (below, above) = (mesh.seams[seam].below, mesh.seams[seam].above);
                match (places[below], places[above]) {
                    (Some(carrier), None) => Some((seam, above, below, carrier, 1.0)),
                    (None, Some(carrier)) => Some((seam, below, above, carrier, -1.0)),
                    _ => None,
                }
            });
            match grows {
                Some((seam, block, carrier, carrier_link, sign)) => {
                    places[block] = Some(Some(links.len()));
                    links.push(Link {
                        block,
                        carrier_link,
                        carrier: carrier_link.map(|_| carrier),
                        seam,
                        sign,
                    });
                }
                None => match places.iter().position(Option::is_none) {
                    Some(first) => places[first] = Some(None),
                    None => return Self { links, blocks: mesh.blocks.len() },
                },
            }
        }
    }

    /// A release by this number of `seams`, for evaluations that are a `time_step` (s) apart.
    pub fn release(&self, seams: usize, time_step: f64) -> Release {
        Release {
            partings: vec![Parting::every(time_step); seams],
            rates: vec![[0.0; 3]; self.links.len()],
            momenta: vec![[0.0; 3]; self.blocks],
        }
    }
}

/// The force q that releases blocks from mass damping.
#[derive(Debug, Default)]
pub(crate) struct Release {
    /// How the sides of each seam part; none if there is no mass damping, or if it also drags blocks.
    pub partings: Vec<Parting>,
    /// Rigid motion of the block of each link.
    pub rates: Vec<[f64; 3]>,
    /// Momentum of each block and all that it carries.
    pub momenta: Vec<[f64; 3]>,
}

impl Release {
    /// Computes the rigid motions; returns whether a crack parts.
    pub fn find_rates(&mut self, carried: &Carried) -> bool {
        if self.partings.iter().all(Parting::is_closed) {
            self.rates.fill([0.0; 3]);
            return false;
        }
        self.momenta.fill([0.0; 3]);
        for (index, link) in carried.links.iter().enumerate() {
            let carrier = link.carrier_link.map_or([0.0; 3], |link| self.rates[link]);
            let jump = self.partings[link.seam].rate();
            self.rates[index] = plus(carrier, jump.map(|rate| link.sign * rate));
        }
        true
    }
}

pub(crate) fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
