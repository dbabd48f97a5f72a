"""The dam of a scene as arrays: section, zones of material, and a mesh of quadrilaterals."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, eq=False)
class Mesh:
    """Quadrilaterals in rows from upstream to downstream; two rows of nodes share each horizontal crack."""

    nodes: np.ndarray
    """Coordinates x and y, m; nodes × 2."""
    quadrilaterals: np.ndarray
    """Nodes of each element, counter-clockwise; elements × 4."""
    base: np.ndarray
    """Nodes of the base, from heel to toe."""
    upstream: np.ndarray
    """Nodes of the upstream face, from the heel up, also above the water."""
    joints: list = field(default_factory=list)
    """For each crack, from the lowest up, its nodes below and above, from upstream to downstream."""


class Section:
    """Outline and materials of `scene["dam"]`, and meshes of it.

    **Errors**: the scene has a mesh of its own, `[dam.mesh]`, so that there is no outline.
    """

    def __init__(self, scene):
        self._dam, self._depth = scene["dam"], scene.get("reservoir", {}).get("depth")
        if "section" not in self._dam:
            raise ValueError("the scene has a mesh, `dam.mesh.file`, and no `dam.section`; open that file with the solver's own reader")
        self.upstream, self.downstream = (np.array(self._dam["section"][side], float) for side in ("upstream", "downstream"))
        self.outline = np.concatenate([self.upstream, self.downstream[::-1]])
        """Corners, clockwise from the heel, m."""
        self.galleries = [np.array(outline, float) for outline in self._dam["section"].get("galleries", [])]
        self.zones = [np.array(zone["polygon"], float) for zone in self._dam.get("zones", [])]

    def material(self, name, x, y):
        """`young_modulus`, `poisson_ratio` or `density` at places: that of the last zone around each, or of `dam.material`."""
        values = np.full(np.shape(x), float(self._dam["material"][name]))
        for zone, outline in zip(self._dam.get("zones", []), self.zones):
            if name in zone:
                values[is_inside(outline, x, y)] = zone[name]
        return values

    def mesh(self, size=None, levels=(), with_cracks=False):
        """A mesh with elements of about `size` m, `dam.element_size` if it is not given.

        Rows of nodes follow the corners of both faces, horizontal cracks, the water level and the further elevations `levels`,
        such as `task.points.y`. Elements are as wide as the section requires, the same number in each row.

        **Errors**: the section has a gallery, a sloping base or crest, or a face that does not rise; `with_cracks` and a crack that
        is not horizontal.
        """
        size = float(size or self._dam["element_size"])
        (bottom, top), cracks = self._ends(), self._cracks(with_cracks)
        marks = [*self.upstream[:, 1], *self.downstream[:, 1], *cracks, *levels, *([self._depth] if self._depth else [])]
        marks = np.unique(np.round(marks, 9))
        marks = marks[(marks >= bottom) & (marks <= top)]
        parts = [np.linspace(a, b, max(round((b - a) / size), 1), endpoint=False) for a, b in zip(marks, marks[1:])]
        y = np.append(np.concatenate(parts), top)
        left, right = (np.interp(y, side[:, 1], side[:, 0]) for side in (self.upstream, self.downstream))
        widths = right - left
        area = (np.diff(y) * (widths[1:] + widths[:-1])).sum() / 2
        columns = max(round(area / (top - bottom) / size), 2)
        twice = np.flatnonzero(np.isin(np.round(y, 9), np.round(cracks, 9))) if with_cracks else []
        rows = np.sort(np.append(np.arange(len(y)), twice).astype(int))
        share = np.linspace(0, 1, columns + 1)
        x = left[rows, None] * (1 - share) + right[rows, None] * share
        nodes = np.column_stack([x.ravel(), np.repeat(y[rows], columns + 1)])
        tags = np.arange(len(nodes)).reshape(len(rows), -1)
        below = np.flatnonzero(np.diff(rows) > 0)
        corners = [tags[below, :-1], tags[below, 1:], tags[below + 1, 1:], tags[below + 1, :-1]]
        joints = [(tags[row], tags[row + 1]) for row in np.flatnonzero(np.diff(rows) == 0)]
        return Mesh(nodes, np.stack([c.ravel() for c in corners], axis=1), tags[0], tags[:, 0], joints)

    def _ends(self):
        for name, side in (("upstream", self.upstream), ("downstream", self.downstream)):
            if (np.diff(side[:, 1]) <= 0).any():
                raise ValueError(f"`dam.section.{name}` does not rise everywhere; mesh the outline with a mesh generator")
        if self.galleries:
            raise ValueError("`dam.section.galleries`: rows of quadrilaterals leave no holes; mesh the outline with a mesh generator")
        ends = [(a, b) for a, b in zip(self.upstream[[0, -1], 1], self.downstream[[0, -1], 1])]
        if any(a != b for a, b in ends):
            raise ValueError(f"base and crest must be horizontal; the ends of both sides are at {ends} m")
        return ends[0][0], ends[1][0]

    def _cracks(self, needed):
        cracks = self._dam.get("cracks", [])
        if needed and any("elevation" not in crack for crack in cracks):
            raise ValueError("`dam.cracks`: a crack with a `polyline` is not horizontal; give its `elevation`, or mesh it elsewhere")
        bottom = self.upstream[0, 1]
        return [crack["elevation"] for crack in cracks if crack.get("elevation", bottom) > bottom]


def is_inside(outline, x, y):
    """Whether places lie inside a polygon: a ray towards +x crosses its sides an odd number of times."""
    inside = np.zeros(np.shape(x), bool)
    for (x1, y1), (x2, y2) in zip(outline, np.roll(outline, -1, axis=0)):
        if y1 != y2:
            inside ^= ((y1 > y) != (y2 > y)) & (x < x1 + (y - y1) * (x2 - x1) / (y2 - y1))
    return inside


def rayleigh(damping, first):
    """Coefficients α and β of C = α M + β K, as `dam.damping` of the scene says; `first` is ω₁ of the intact empty dam, rad/s."""
    ratio, model = damping["ratio"], damping.get("model", "rayleigh")
    if model == "local":
        raise ValueError('`dam.damping.model = "local"` is not proportional damping; use "rayleigh", "mass" or "stiffness"')
    if ratio == 0:
        return 0.0, 0.0
    multiples = damping.get("multiples_of_first")
    low, high = sorted(damping["radians_per_second"] if multiples is None else [multiple * first for multiple in multiples])
    of_both = 2 * ratio / (low + high) * np.array([low * high, 1.0])
    return {"rayleigh": tuple(of_both), "mass": (2 * ratio * low, 0.0), "stiffness": (0.0, 2 * ratio / low)}[model]
