"""What the pieces of a fault's rim do: they lie free, on another fault, just short of it or past it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.proximity import Nearest, Simplices, nearest
from graben.surface import Surface
from graben.validators.measuring.branch_lines import BranchLines, OnBranch
from graben.validators.measuring.hits import TriangleTree
from graben.validators.measuring.rim_lines import RimLine, RimPieces, unit

#: How far to either side of the way a fault would go on another still lies ahead of it, degrees.
AHEAD = 30.0
#: How far from square to a branch line the part of a fault that it cuts off may end, degrees.
BEYOND = 60.0
#: Angle below which a rim or a way is level, degrees, and that off the way at which a fault that ends in the
#: same level plane is no longer ahead: all faults of a model may be cut off at one depth.
_LEVEL, _PLANE = 5.0, 10.0
#: Where two faults cross within this many times the gap between a rim and the other fault, the rim runs
#: through the crossing and has no gap.
_CROSSING = 2.0
#: Angle to the branch line up to which a rim is parallel to it, degrees. At a larger angle, as far as AHEAD,
#: there is a stub unless the other fault's own rim is within this many times its length: there both faults
#: end alike, and the rim runs through.
_PARALLEL, _BOTH_END = 10.0, 6.0


class RimLabel(StrEnum):
    """What a stretch of a rim does."""

    FREE = "free"  #: nothing ahead within the limit, and no horizon across it
    TIP = "tip"  #: free, but a horizon passes: the fault ends inside it, and the throw vanishes there
    ON = "on another surface"  #: within the contact distance of another fault
    GAP = "gap"  #: ends short of another fault
    STUB = "stub"  #: ends shortly after passing another fault


#: The labels as arrays number them.
LABELS = tuple(RimLabel)
_FREE, _TIP, _ON, _GAP, _STUB = range(len(LABELS))


@dataclass(frozen=True, eq=False)
class Labels:
    """Label, other surface (-1 for none) and width or length (infinite for none) of each piece of a rim."""

    label: IntArray
    other: IntArray
    size: FloatArray


@dataclass(frozen=True, eq=False)
class Scene:
    """The faults of a model, as each sees the others.

    Parameters
    ----------
    faults : sequence of Surface
        The faults.
    lines : sequence of RimLine
        Their rims.
    branches : BranchLines
        Where they meet.
    tree : TriangleTree
        Their triangles.
    nearby : sequence of Simplices
        The triangles of each.
    contact : float
        Distance at which two surfaces touch, model units.
    """

    faults: Sequence[Surface]
    lines: Sequence[RimLine]
    branches: BranchLines
    tree: TriangleTree
    nearby: Sequence[Simplices]
    contact: float

    def labelled(self, pieces: RimPieces, own: int, limit: float) -> Labels:
        """Return what the pieces of the rim of fault ``own`` do, tips not told apart from free ones.

        On another fault goes before all else; of gaps and stubs the smallest counts.
        """
        points = pieces.middles
        label, other = np.full(len(points), _FREE), np.full(len(points), -1)
        size = np.full(len(points), np.inf)
        hits = self.tree.first(points, limit * pieces.outward, own)
        for b, rows in self._beside(pieces, own, limit):
            near = self.nearby[b].nearest(points[rows])
            branch = self.branches.nearest(points[rows], own, b)
            way = np.full(len(rows), np.inf)
            way[hits.owner[rows] == b] = limit * hits.distance[rows][hits.owner[rows] == b]
            gap = _gaps(pieces, rows, near, way, limit)
            gap[gap * _CROSSING >= self._apart(pieces, rows, branch, b)] = np.inf
            stub = self._stubs(pieces, rows, branch, own, b, limit)
            # what is no further than the contact distance lies on the other, on whichever side
            gap[gap <= self.contact] = stub[stub <= self.contact] = np.inf
            on = np.where(near.distance <= self.contact, 0.0, np.inf)
            for kind, value in ((_ON, on), (_GAP, gap), (_STUB, stub)):
                better = rows[value < size[rows]]
                label[better], other[better] = kind, b
                size[rows] = np.minimum(size[rows], value)
        return Labels(ints(label), ints(other), floats(size))

    def _apart(self, pieces: RimPieces, rows: IntArray, branch: OnBranch, b: int) -> FloatArray:
        """Return how far pieces of a rim are from where their fault meets fault ``b``, model units.

        That is their branch line, or a place at which the rim touches the other: whether rounding made
        that a crossing decides nothing.
        """
        ends = pieces.ends[rows].reshape(-1, 3)
        touching = self.nearby[b].nearest(ends).distance <= self.contact
        if not touching.any():
            return branch.distance
        away = cKDTree(ends[touching]).query(pieces.middles[rows])[0]
        return np.asarray(np.minimum(branch.distance, away))

    def _beside(self, pieces: RimPieces, own: int, limit: float) -> Iterator[tuple[int, IntArray]]:
        """Return the other faults with the pieces that are within reach of a triangle's bounding box."""
        reach = max(limit, self.contact)
        near = self.tree.near(pieces.ends.min(axis=1) - reach, pieces.ends.max(axis=1) + reach, own)
        for b in np.flatnonzero(near.any(axis=0)).tolist():
            yield b, ints(np.flatnonzero(near[:, b]))

    def _stubs(
        self, pieces: RimPieces, rows: IntArray, branch: OnBranch, own: int, b: int, limit: float
    ) -> FloatArray:
        """Return how long fault ``own`` is beyond fault ``b`` at pieces of its rim; infinite without a stub.

        A stub is a part of the fault that the branch line cuts off, when all its rim lies within the limit
        of that line; and any stretch of rim within the limit and about parallel to it, but for the ends of
        a crossing, where both faults end.
        """
        length = np.full(len(rows), np.inf)
        within = branch.distance <= limit
        if not within.any():
            return length
        turn = _angle(pieces.middles[rows] - branch.place, pieces.outward[rows])
        part = self.branches.parts(own, b)[pieces.triangle]
        far = np.ones(len(part), dtype=bool)
        far[rows[within]] = False
        short = ~np.isin(part[rows], part[far])
        # beside the ends of the branch line lie the sides of a stub, and rims that run through
        within &= ~branch.end
        stub = within & (turn <= np.where(short, BEYOND, _PARALLEL))
        rest = np.flatnonzero(within & (turn <= AHEAD) & ~stub)
        if len(rest) and len(ends := self.lines[b].ends):
            rim = np.arange(2 * len(ends)).reshape(-1, 2)
            apart = nearest(branch.place[rest], ends.reshape(-1, 3), rim).distance
            stub[rest] = apart > _BOTH_END * branch.distance[rest]
        length[stub] = branch.distance[stub]
        return length


def _gaps(pieces: RimPieces, rows: IntArray, near: Nearest, way: FloatArray, limit: float) -> FloatArray:
    """Return how far ahead of pieces of a rim another fault lies, model units; infinite where it does not.

    Along the way the rim's fault would go on where that meets it, after ``way``; else to its nearest point,
    where that lies ahead.
    """
    step = near.place - pieces.middles[rows]
    turn = _angle(step, pieces.outward[rows])
    level = np.sin(np.radians(_LEVEL))
    plane = (np.abs(unit(step)[:, 2]) < level) & (np.abs(pieces.along[rows, 2]) < level) & (turn > _PLANE)
    ahead = (near.distance <= limit) & (turn <= AHEAD) & ~plane
    return np.asarray(np.where(ahead & np.isinf(way), near.distance, way), dtype=np.float64)


def _angle(step: FloatArray, way: FloatArray) -> FloatArray:
    """Return the angles between vectors (n, 3), degrees; 180 where one is 0."""
    void = ~(np.any(step, axis=1) & np.any(way, axis=1))
    across = np.linalg.norm(np.cross(step, way), axis=1)
    angle = np.degrees(np.arctan2(across, np.einsum("ij,ij->i", step, way)))
    return np.asarray(np.where(void, 180.0, angle), dtype=np.float64)


def with_tips(labels: Labels, pieces: RimPieces, horizons: TriangleTree) -> Labels:
    """Return labels in which free pieces that a horizon crosses are tips."""
    free = np.flatnonzero(labels.label == _FREE)
    ends = pieces.ends[free]
    label = labels.label.copy()
    label[free[horizons.first(ends[:, 0], ends[:, 1] - ends[:, 0], -1).owner >= 0]] = _TIP
    return Labels(ints(label), labels.other, labels.size)
