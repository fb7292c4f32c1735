"""z-monotone: no stationary point inside a fault (paper Sect. 3.1, requirement 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.finding import Element, Part
from graben.surface import Surface, triangle_areas, triangle_dips
from graben.validators.context import Check, CheckContext, Defect, Severity, Tolerance
from graben.validators.measuring.measures import (
    centroids,
    components,
    remembered,
    smallest_angles,
    with_three_corners,
)
from graben.words import plural

#: Dip below which a triangle or an edge is level, degrees: 1.7 m in 10 km. Far below any dip that moves a
#: cut, above what coordinates written to a centimetre make of a level edge of 60 m.
LEVEL = 0.01
#: Smallest angle of a triangle whose dip is trusted, degrees: the height of a sliver is of the size of the
#: rounding of its corners, which can turn it over. `degenerate` names it, and its corners are judged later.
SLIVER = 0.5

#: Kinds of critical points, as `Critical.kind` numbers them.
KINDS = ("summit", "pit", "saddle")


@dataclass(frozen=True, eq=False)
class Critical:
    """The stationary points inside a surface.

    Parameters
    ----------
    vertices : (k,) array
        The critical vertices.
    kind : (k,) array
        Position in :data:`KINDS`.
    plateau : (k,) array
        Critical vertices of one kind joined by level edges are one point, and have one number here.
    excess : (k,) array
        The least change of the vertex's own elevation that makes it regular, model units.
    level : (l,) array
        The level triangles.
    """

    vertices: IntArray
    kind: IntArray
    plateau: IntArray
    excess: FloatArray
    level: IntArray


@remembered
def critical_points(surface: Surface, level: float = LEVEL) -> Critical:
    """Return the stationary points inside a surface: level triangles and critical inner vertices.

    Walk the link of a vertex v and drop the vertices level with it: v is regular exactly when the sign of
    z - z(v) changes twice on the way round. Without a change it is a summit or a pit, with four or more a
    saddle. Looked at are the vertices whose triangles form a disk around them, and that are a corner of no
    level triangle, which speaks for itself, and of no sliver, whose shape is a matter of rounding.

    Parameters
    ----------
    surface : Surface
        Finite coordinates and indices in range; oriented or not.
    level : float
        Dip below which an edge or a triangle is level, degrees.
    """
    kept = with_three_corners(surface)
    if not len(kept):
        return Critical(ints([]), ints([]), ints([]), floats([]), ints([]))
    thin = smallest_angles(surface.vertices, surface.triangles[kept]) < SLIVER
    flat = kept[~thin & (triangle_dips(surface.vertices, surface.triangles[kept]) < level)]
    link = _Link.of(surface, ints(surface.triangles[kept], -1, 3), level)
    changes, lone, height = link.walked()
    judged = link.disks() & (lone != 0)
    judged[surface.triangles[np.union1d(flat, kept[thin])]] = False
    vertices = np.flatnonzero(judged & (changes != 2))
    kind = np.where(changes[vertices] > 2, 2, np.where(lone[vertices] < 0, 0, 1))
    return Critical(
        ints(vertices), ints(kind), ints(link.plateaus(vertices, kind)), floats(height[vertices]), ints(flat)
    )


@dataclass(frozen=True, eq=False)
class _Link:
    """The links of all vertices of a surface at once.

    A node is a neighbour as seen from one vertex, and belongs to that vertex's link.

    Parameters
    ----------
    owner, neighbour : (n,) arrays
        The vertex whose link a node is in, and the vertex that it is.
    rise : (n,) array
        Elevation of the neighbour above the owner, model units; 0 where level.
    edges : (e, 2) array
        Nodes; one edge for each corner of a triangle.
    """

    owner: IntArray
    neighbour: IntArray
    rise: FloatArray
    edges: IntArray

    @classmethod
    def of(cls, surface: Surface, triangles: IntArray, level: float) -> _Link:
        """Return the links of a surface; ``triangles`` have three corners each."""
        points = surface.vertices
        count = max(len(points), 1)
        around = np.stack([np.roll(triangles, -1, axis=1), np.roll(triangles, -2, axis=1)], axis=2)
        keys, edges = np.unique(triangles[:, :, None] * count + around, return_inverse=True)
        owner, neighbour = keys // count, keys % count
        step = points[neighbour] - points[owner]
        limit = np.tan(np.radians(level)) * np.linalg.norm(step, axis=1)
        rise = np.where(np.abs(step[:, 2]) <= limit, 0.0, step[:, 2])
        return cls(ints(owner), ints(neighbour), floats(rise), ints(edges, -1, 2))

    def disks(self) -> BoolArray:
        """Return which vertices, up to the last of a link, have a link that is one closed way."""
        count = int(self.owner.max()) + 1
        closed = np.ones(count, dtype=bool)
        closed[self.owner[np.bincount(self.edges.ravel(), minlength=len(self.owner)) != 2]] = False
        label = components(len(self.owner), self.edges)
        first = np.unique(label, return_index=True)[1]
        once = np.bincount(self.owner[first], minlength=count) == 1
        return np.asarray(closed & once & (np.bincount(self.owner, minlength=count) > 2), dtype=np.bool_)

    def walked(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return for each vertex up to the last of a link what the way round it shows.

        Returns
        -------
        changes : (v,) array
            How often the sign changes, level nodes dropped.
        lone : (v,) array
            The sign met, where there is no change; 0 where all is level.
        height : (v,) array
            By how much the vertex must move at least until the sign changes twice: past its nearest
            neighbour in elevation where it never changes, else past the least of the runs of one sign.
        """
        count = int(self.owner.max()) + 1
        sign = np.sign(self.rise)
        pairs = self._consecutive(sign)
        owner = self.owner[pairs[:, 0]]
        differ = sign[pairs[:, 0]] != sign[pairs[:, 1]]
        changes = np.bincount(owner, differ, minlength=count).astype(int)
        lone = np.zeros(count)
        lone[self.owner[sign != 0]] = sign[sign != 0]
        run = components(len(self.owner), pairs[~differ])
        size = np.abs(self.rise)
        most = np.zeros(len(self.owner))
        np.maximum.at(most, run, size)
        alone = changes[self.owner] == 0
        height = np.full(count, np.inf)
        steep = sign != 0
        np.minimum.at(height, self.owner[steep], np.where(alone, size, most[run])[steep])
        return ints(changes), floats(lone), floats(height)

    def _consecutive(self, sign: FloatArray) -> IntArray:
        """Return the pairs of nodes that follow each other when the level ones are dropped, shape (p, 2)."""
        zero = sign == 0
        level = zero[self.edges]
        run = components(len(self.owner), self.edges[level.all(axis=1)])
        mixed = self.edges[level.any(axis=1) & ~level.all(axis=1)]
        inside = zero[mixed[:, 0]]
        end, at = np.where(inside, mixed[:, 1], mixed[:, 0]), run[np.where(inside, mixed[:, 0], mixed[:, 1])]
        order = np.argsort(at, kind="stable")
        # a run of level nodes on a closed way has two ends; others are on no disk and not looked at
        two = np.bincount(at, minlength=len(self.owner))[at[order]] == 2
        return np.concatenate([self.edges[~level.any(axis=1)], end[order][two].reshape(-1, 2)])

    def plateaus(self, vertices: IntArray, kind: IntArray) -> IntArray:
        """Return a number for each critical vertex: one for all of a kind that level edges join."""
        index = np.full(int(self.owner.max()) + 1, -1)
        index[vertices] = np.arange(len(vertices))
        joined = np.stack([index[self.owner], index[self.neighbour]], axis=1)[self.rise == 0]
        joined = joined[(joined >= 0).all(axis=1)]
        joined = joined[kind[joined[:, 0]] == kind[joined[:, 1]]]
        return components(len(vertices), joined)


def _run(context: CheckContext) -> list[Defect]:
    level = context.tolerance("z-monotone", LEVEL)
    found = [_fault(f.surface, critical_points(f.surface, level), context.unit) for f in context.faults]
    return [d for d in found if d is not None]


def _fault(surface: Surface, found: Critical, unit: str) -> Defect | None:
    """Return the stationary points inside a fault, a part for each kind; None without any."""
    points = surface.vertices[found.vertices]
    parts = [
        _part(name, points[mine], found.plateau[mine], found.excess[mine], unit)
        for k, name in enumerate(KINDS)
        if (mine := found.kind == k).any()
    ]
    middles = centroids(surface.vertices, surface.triangles[found.level])
    if len(found.level):
        parts.append(_level_part(surface, found.level, middles, unit))
    if not parts:
        return None
    worst = max((p for p in parts if p.kind in KINDS), key=lambda p: p.value or 0.0, default=parts[-1])
    star = np.flatnonzero(np.isin(surface.triangles, found.vertices).any(axis=1))
    kinds = [plural(p.count, p.kind) for p in parts]
    listed = kinds[0] if len(kinds) == 1 else f"{', '.join(kinds[:-1])} and {kinds[-1]}"
    return Defect(
        (surface.name,),
        f"{surface.name} does not rise one way from rim to rim: it has {listed} inside.",
        "Change its dip there so that it has a way up and a way down at every place, or cut the fault in two "
        "along the crest or trough.",
        count=sum(p.count for p in parts),
        value=worst.value,
        unit=worst.unit,
        place=floats(worst.place),
        elements=ints(np.union1d(star, found.level)) if len(found.level) else found.vertices,
        element=Element.TRIANGLE if len(found.level) else Element.VERTEX,
        places=floats(np.concatenate([points, middles]), -1, 3),
        parts=tuple(parts),
    )


def _part(kind: str, points: FloatArray, plateau: IntArray, excess: FloatArray, unit: str) -> Part:
    """Return the critical vertices of one kind; its value is the greatest least change of elevation."""
    worst = int(np.argmax(excess))
    return Part(kind, len(np.unique(plateau)), _place(points[worst]), float(excess[worst]), unit)


def _level_part(surface: Surface, level: IntArray, middles: FloatArray, unit: str) -> Part:
    """Return the level triangles; their value is their area."""
    areas = triangle_areas(surface.vertices, ints(surface.triangles[level]))
    place = _place(middles[int(np.argmax(areas))])
    return Part("level triangle", len(level), place, float(areas.sum()), f"{unit}²" if unit else "")


def _place(point: FloatArray) -> tuple[float, float, float]:
    return (float(point[0]), float(point[1]), float(point[2]))


CHECK = Check(
    "z-monotone",
    "3.1, requirement 2",
    "No stationary point lies inside a fault.",
    "Cut nodes slide along the fault to the elevation of the horizon: at a summit, a saddle or a level patch "
    "no direction leads up or down.",
    _run,
    faults_only=True,
    severity=Severity.RELAXED,
    tolerance=Tolerance(
        "dip below which a triangle or an edge is level", "degrees", f"{LEVEL:g}", lambda model: [LEVEL]
    ),
    repairable=True,
)
