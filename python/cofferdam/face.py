"""The wet face as a line, and the mapping between its points and the boundary of a solver of one's own."""

import numpy as np

_OFF_THE_FACE = 0.01
"""Distance of a place from the face that is taken for rounding or for a slightly different outline; of the length of the face."""


class Face:
    """The wet face: hat functions φ of its points over the length s along it, from the heel up, in m.

    Two points in one place, the two sides of a crack, share no panel: a hat function ends there.
    """

    def __init__(self, points):
        self._places = np.column_stack([points.x, points.y])
        panels = np.diff(self._places, axis=0)
        self._lengths = np.hypot(*panels.T)
        if len(self._places) < 2 or not self._lengths.any():
            raise ValueError("a wet face needs two points in different places")
        self.position = np.append(0.0, np.cumsum(self._lengths))
        """s of the points, m."""
        self.mass = self.integrals(lambda hats, s: hats)
        """M = ∫ φ φᵀ ds, m, points × points. Forces of the pressure on the points are M p, N/m."""

    def positions(self, x, y):
        """s of the places (x, y), m: negative below the heel, beyond `position[-1]` above the water.

        **Errors**: a place is farther from the face, or from its straight continuation, than 1 % of the length of the face.
        """
        places = np.column_stack([np.ravel(x), np.ravel(y)])
        wet = np.flatnonzero(self._lengths > 0)
        nearest, found = np.full(len(places), np.inf), np.empty(len(places))
        for panel in wet:
            start, length = self._places[panel], self._lengths[panel]
            along = (places - start) @ (self._places[panel + 1] - start) / length
            low = -np.inf if panel == wet[0] else 0.0
            high = np.inf if panel == wet[-1] else length
            along = np.clip(along, low, high)
            foot = start + np.outer(along / length, self._places[panel + 1] - start)
            distance = np.hypot(*(places - foot).T)
            closer = distance < nearest
            nearest[closer], found[closer] = distance[closer], self.position[panel] + along[closer]
        worst = int(np.argmax(nearest))
        if nearest[worst] > _OFF_THE_FACE * self.position[-1]:
            at = f"({places[worst, 0]:g}, {places[worst, 1]:g})"
            raise ValueError(f"{at} lies {nearest[worst]:.3g} m off the wet face; give places on the face")
        return found

    def hats(self, x, y):
        """φ at the places (x, y), one row for each: `face.hats(x, y) @ pressure` is the pressure there, linear between the points.

        Rows sum to 1 on the face and are 0 beyond its ends, where there is no water. On a crack the value is that of its lower side.
        """
        return self._hats_at(self.positions(x, y))

    def _hats_at(self, s):
        ends, inside = self.position[-1], 1e-9 * self.position[-1]
        panel = np.clip(np.searchsorted(self.position, s, side="left") - 1, 0, len(self._lengths) - 1)
        # The first and the last panel may have no length.
        panel = np.clip(panel, *np.flatnonzero(self._lengths)[[0, -1]])
        share = np.clip((s - self.position[panel]) / self._lengths[panel], 0.0, 1.0)
        values, rows = np.zeros((len(s), len(self.position))), np.arange(len(s))
        values[rows, panel], values[rows, panel + 1] = 1.0 - share, share
        values[(s < -inside) | (s > ends + inside)] = 0.0
        return values

    def integrals(self, own, breaks=()):
        """∫ ψ φᵀ ds over the face for functions ψ of a solver's own, one row for each.

        `own(hats, s)` returns ψ, one row for each place s. It is exact if ψ is at most quadratic between the `breaks` (s, m).
        """
        cuts = np.unique(np.clip(np.append(self.position, breaks), 0.0, self.position[-1]))
        nodes, weights = np.polynomial.legendre.leggauss(2)
        half = np.diff(cuts) / 2
        s = (cuts[:-1] + half)[:, None] + half[:, None] * nodes
        ds = (half[:, None] * weights).ravel()
        hats = self._hats_at(s.ravel())
        return (own(hats, s.ravel()) * ds[:, None]).T @ hats

    def mapping(self, x, y):
        """The mapping between the points and a solver's own nodes at (x, y), ordered from the heel up, above the water or not.

        Two own nodes in one place are the two sides of a joint. For a solver that gives its shape functions at quadrature points,
        `Mapping(face, C)` takes C = ∫ N φᵀ ds from `hats`.
        """
        own = self.positions(x, y)
        if len(own) < 2 or (np.diff(own) < 0).any():
            raise ValueError("own nodes must be at least two, ordered from the heel up")
        if own[0] > 1e-6 * self.position[-1] or own[-1] < (1 - 1e-6) * self.position[-1]:
            raise ValueError(f"own nodes lie from {own[0]:g} to {own[-1]:g} m along the face of {self.position[-1]:g} m; cover all of it")

        def linear(_, s):
            panel = np.clip(np.searchsorted(own, s, side="left") - 1, 0, len(own) - 2)
            share = (s - own[panel]) / (own[panel + 1] - own[panel])
            values, rows = np.zeros((len(s), len(own))), np.arange(len(s))
            values[rows, panel], values[rows, panel + 1] = 1.0 - share, share
            return values

        return Mapping(self, self.integrals(linear, own))


class Mapping:
    """Conservative for forces and consistent for constant motion: one matrix C = ∫ ψ φᵀ ds, ψ those of a solver's own boundary.

    Force and work are the same on both sides, 1ᵀ C p = ∫ p ds and Uᵀ (C p) = uᵀ M p, because both directions use C
    (docs/theory/theory.md, 24).
    """

    def __init__(self, face, coupling):
        self.coupling = np.asarray(coupling)
        """C, m, own × points."""
        self._to_points = np.linalg.solve(face.mass, self.coupling.T)

    def to_own(self, values):
        """∫ ψ (Σ φ values) ds: forces C p on the solver's own nodes, N/m, of a pressure; or its flux C a of a motion of the face."""
        return self.coupling @ values

    def to_points(self, values):
        """M⁻¹ Cᵀ values: a field of the solver's own boundary, motion along n or pressure, at the points."""
        return self._to_points @ values

    def added_mass(self, added_mass):
        """C A M⁻¹ Cᵀ, kg/m: the mass matrix of water with p = −A a for the solver's own unknowns along n; symmetric if M A is."""
        return self.coupling @ added_mass @ self._to_points


def westergaard(points, depth, density):
    """Westergaard's added mass A of p = −A a, kg/m²: M A = ρ ∫ w φ φᵀ ds with w = ⅞ √(h (h − y)).

    Gauss quadrature in u = √(h − y), in which all integrands are polynomials.
    """
    below, n = depth - points.y, len(points.y)
    mass, moved = np.zeros((n, n)), np.zeros((n, n))
    position, weight = np.polynomial.legendre.leggauss(8)
    for i in range(n - 1):
        length = np.hypot(points.x[i + 1] - points.x[i], points.y[i + 1] - points.y[i])
        if length == 0:  # The two sides of a crack.
            continue
        lower, upper = np.sqrt(below[i]), np.sqrt(max(below[i + 1], 0))
        u = (lower + upper) / 2 + (lower - upper) / 2 * position
        along = (below[i] - u**2) / (below[i] - below[i + 1])
        ds = 2 * u * (lower - upper) / 2 * weight * length / (below[i] - below[i + 1])
        hats = np.array([1 - along, along])
        panel = slice(i, i + 2)
        mass[panel, panel] += (hats * ds) @ hats.T
        moved[panel, panel] += density * (hats * ds * 7 / 8 * np.sqrt(depth) * u) @ hats.T
    return np.linalg.solve(mass, moved)
