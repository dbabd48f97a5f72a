use super::super::ContactLaw;
use super::super::search::{Chain, Projection, find_segment};
use super::position::{MovedPoint, Position, Segment, normal};
use super::side::{Contact, Point, Side};
use super::{Crack, parting};

/// Current position of a contact.
pub(super) struct Place {
    /// Its point.
    pub point: Point,
    /// Segment of the other side that it is opposite to.
    pub segment: usize,
    /// The segment's nodes.
    pub nodes: [usize; 2],
    /// Position relative to this segment.
    pub at: Position,
    /// The segment along which it slides: its nodes, and its unloaded length, m.
    pub slides_on: [usize; 2],
    pub at_rest: f64,
    /// Share of the part of the contact that lies opposite the other side.
    pub coverage: f64,
}

impl Place {
    /// The nodes around its point, and those of the segment opposite.
    pub fn nodes_of_both(&self) -> [usize; 4] {
        let ([first, second], [third, fourth]) = (self.point.nodes, self.nodes);
        [first, second, third, fourth]
    }

    /// Their weights in the relative displacement.
    pub fn shares(&self) -> [f64; 4] {
        let (share, position) = (self.point.share, self.at.position);
        [1.0 - share, share, position - 1.0, -position]
    }
}

/// Depth, as a share of its length, below which a lost contact is found again; deeper, its block has fallen beside the other one.
const SHALLOW: f64 = 0.01;

/// A point beside the other side, with its displacement, and the displacements of nodes.
struct Beside<'a, U> {
    other: &'a Side,
    rest: [f64; 2],
    displacement: [f64; 2],
    u: U,
}

impl<U: Fn(usize) -> [f64; 2]> Chain for Beside<'_, U> {
    type Segment = Segment<f64>;

    #[inline(always)]
    fn project(&self, segment: usize) -> (Projection, Segment<f64>) {
        #[cfg(test)]
        super::super::effort::spend(|effort| effort.segments += 1);
        let displacements = [segment, segment + 1].map(|node| (self.u)(self.other.nodes[node]));
        let moved = self.other.segment(segment, self.rest).moved(self.displacement, displacements);
        (moved.projection(), moved)
    }
}

impl Contact {
    /// How the motion of the upper side relative to the lower one follows from the nodes'.
    pub fn stencil(&self, place: &Place) -> parting::Stencil {
        parting::Stencil {
            nodes: place.nodes_of_both(),
            shares: place.shares().map(|share| self.downstream() * share),
            length: self.weight * place.coverage,
        }
    }
}

impl<L: ContactLaw> Crack<L> {
    /// Current position of a contact. Its point is moved along its part if the other side does not lie opposite.
    #[inline(always)]
    pub(super) fn place(&self, contact: &Contact, start: usize, u: impl Fn(usize) -> [f64; 2]) -> Place {
        let place = self.opposite(contact, start, &u);
        if place.at.is_inside(contact.part, self.sides[1 - contact.side].length()) {
            return place;
        }
        self.near_an_end(contact, place, u)
    }

    /// Whether a lost contact is not to be found again: it lies deep beside the other side, or its block has turned over, so
    /// that both sides no longer run the same way.
    #[cold]
    #[inline(never)]
    pub(super) fn has_fallen(
        &self,
        contact: &Contact,
        place: &Place,
        penetration: f64,
        u: &[[f64; 2]],
    ) -> bool {
        let own = self.sides[contact.side].edge(contact.after, |node| u[node]);
        let along = own[0] * place.at.tangent[0] + own[1] * place.at.tangent[1];
        penetration > SHALLOW * contact.weight || along <= 0.0
    }

    /// From and to which abscissa the part of a contact lies opposite the other side, m.
    #[inline(always)]
    fn facing(&self, contact: &Contact, u: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
        let [from, to] = contact.part;
        let end = self.sides[1 - contact.side].nodes.len() - 1;
        [from.max(self.opposite_to(0, contact, &u)), to.min(self.opposite_to(end, contact, &u))]
    }

    /// The abscissa opposite a corner of the other side, on the segment before or after the contact's point, m.
    #[inline(always)]
    fn opposite_to(&self, corner: usize, contact: &Contact, u: impl Fn(usize) -> [f64; 2]) -> f64 {
        let (own, other) = (&self.sides[contact.side], &self.sides[1 - contact.side]);
        let foot = own.foot(contact.before, other, corner, &u);
        let middle = contact.point.abscissa;
        if foot <= middle { foot } else { own.foot(contact.after, other, corner, &u).max(middle) }
    }

    /// Whether the part of a contact lies wholly opposite the other side.
    pub(super) fn is_whole(&self, contact: &Contact, u: &[[f64; 2]]) -> bool {
        let ([first, last], [from, to]) = (self.facing(contact, |node| u[node]), contact.part);
        last - first >= to - from
    }

    /// The position of a contact that is `opposite` the other side, but may be near an end of it.
    #[inline(always)]
    fn near_an_end(&self, contact: &Contact, opposite: Place, u: impl Fn(usize) -> [f64; 2]) -> Place {
        let (own, other) = (&self.sides[contact.side], &self.sides[1 - contact.side]);
        let [from, to] = contact.part;
        let end = other.nodes.len() - 1;
        let [first, last] = self.facing(contact, &u);
        if last - first >= to - from {
            return opposite;
        }
        let coverage = (last - first).max(0.0) / (to - from);
        let abscissa = contact.point.abscissa.max(first).min(last);
        if coverage == 0.0 || abscissa == contact.point.abscissa {
            return Place { coverage, ..opposite };
        }
        let (segment, corner) =
            if abscissa < contact.point.abscissa { (contact.before, end) } else { (contact.after, 0) };
        // the other side's corner against this side, whose direction it slides along
        let point = own.point(segment, abscissa);
        let edge = own.edge(segment, &u);
        let length = (edge[0] * edge[0] + edge[1] * edge[1]).sqrt();
        let at_rest = own.abscissas[segment + 1] - own.abscissas[segment];
        let tangent = edge.map(|component| component / length);
        let normal = normal(contact.downstream(), tangent);
        let ([rest, moved], [first, second]) =
            ([other.rest[corner], u(other.nodes[corner])], point.nodes.map(&u));
        let [x, y] = [0, 1]
            .map(|d| point.rest[d] - rest[d] + (first[d] + point.share * (second[d] - first[d]) - moved[d]));
        Place {
            point,
            segment: opposite.segment,
            nodes: [other.nodes[corner]; 2],
            at: Position {
                position: 0.0,
                tangent,
                normal,
                gap: x * normal[0] + y * normal[1],
                slip: other.abscissas[corner] - abscissa,
                shortening: at_rest / length,
            },
            slides_on: point.nodes,
            at_rest,
            coverage,
        }
    }

    /// Projection of a contact's point onto the other side, or onto the line of its end segment.
    #[inline(always)]
    fn opposite(&self, contact: &Contact, start: usize, u: impl Fn(usize) -> [f64; 2]) -> Place {
        let (other, point) = (&self.sides[1 - contact.side], contact.point);
        let displacement = MovedPoint::new(point.rest, point.share, point.nodes.map(&u)).displacement();
        let beside = Beside { other, rest: point.rest, displacement, u: &u };
        let (segment, projection, moved) = find_segment(start, other.nodes.len() - 1, &beside);
        let abscissas = [segment, segment + 1].map(|node| other.abscissas[node] - point.abscissa);
        let at_rest = other.abscissas[segment + 1] - other.abscissas[segment];
        let nodes = [other.nodes[segment], other.nodes[segment + 1]];
        let at = Position::new(contact.downstream(), &moved, projection, abscissas, at_rest);
        Place { point, segment, nodes, at, slides_on: nodes, at_rest, coverage: 1.0 }
    }
}

/// `Σ share × value` of the nodes.
#[inline(always)]
pub(super) fn weighted(nodes: [usize; 4], shares: [f64; 4], values: &[[f64; 2]]) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for (node, share) in nodes.into_iter().zip(shares) {
        (0..2).for_each(|d| sum[d] += share * values[node][d]);
    }
    sum
}
