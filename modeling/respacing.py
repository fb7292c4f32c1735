"""Lips whose nodes have run past each other, spaced evenly again.

Where two flat faults cross, the smeared horizon is nearly as steep as they are, and both first traces run
along the line in which the faults meet. The junction moves along this line, far past the nodes next to it,
which follow formula (6) from where they first lay: the two lips of the sector cross, and no mesh can follow
them. That says nothing of the horizon, only of where the nodes were put: beyond the corner of its block a lip
goes on as a solution of its own, but not of the model. So the nodes beyond the corner are left out, all are
spaced evenly along what remains of the lip, and new guides start there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.modeling.courses import courses
from graben.modeling.guides import Guides, sections
from graben.modeling.movement import Lips, Role
from graben.modeling.remeshing import near_pieces, straddled
from graben.proximity import nearest
from graben.surface import Surface

#: Length of an edge of a lip over their mean below which its nodes have run together: triangles there have no
#: height left to lose.
_TOGETHER = 0.05
#: Cosine of the turn in plan from which on a node is no place of a lip: 60 degrees, as for first traces.
_KINK = 0.5


@dataclass(frozen=True, eq=False)
class Arm:
    """A lip of a subdomain from guided end to guided end.

    ``path`` (k,) are its nodes by their place among the nodes of the cut, ``surface`` is its fault.
    """

    path: IntArray
    surface: Surface


@dataclass(frozen=True, eq=False)
class Arms:
    """The lips of a subdomain, and where two of them bound one sector of a junction.

    Parameters
    ----------
    arms : tuple of Arm
        The lips.
    corners : tuple of (int, int)
        Pairs of arms that both start at a junction, the one before and the one after it. Arms are given
        here as index + 1, negative where the arm ends at the junction.
    reach : float
        As of :func:`graben.modeling.movement.guides_of`.
    """

    arms: tuple[Arm, ...]
    corners: tuple[tuple[int, int], ...]
    reach: float

    @staticmethod
    def of(lips: Lips, mine: IntArray, faults: Sequence[Surface], reach: float) -> Arms:
        """Return the lips of the nodes ``lips.copies[mine]`` (c,); ``faults`` are the model's."""
        position = np.full(int(lips.copies.max(initial=-1)) + 1, -1)
        position[lips.copies[mine]] = np.arange(len(mine))
        chains = [(f, position[path]) for f, _, path in lips.chains if (position[path] >= 0).all()]
        arms = tuple(Arm(ints(path), faults[fault]) for fault, path in chains if path[0] != path[-1])
        ends: dict[int, list[int]] = {}
        for k, arm in enumerate(arms):
            for node, name in ((arm.path[0], k + 1), (arm.path[-1], -k - 1)):
                if lips.roles[mine[node]] == Role.JUNCTION:
                    ends.setdefault(int(node), []).append(name)
        return Arms(arms, tuple((e[0], e[1]) for e in ends.values() if len(e) == 2), reach)

    def folded(self, guides: Guides, z: FloatArray) -> bool:
        """Return whether a lip crosses itself or the other lip of its sector at elevations ``z`` (c,)."""
        places = guides.places(z)
        paths = [arm.path for arm in self.arms]
        paths += [np.concatenate([self._from_end(a)[::-1], self._from_end(b)[1:]]) for a, b in self.corners]
        # Lines that touch themselves are looked at once more: only what crosses is folded.
        if shapely.is_simple([shapely.linestrings(places[path]) for path in paths]).all():
            return False
        return any(not stay.all() for stay in self._staying(places))

    def crowded(self, guides: Guides, z: FloatArray) -> bool:
        """Return whether nodes of a lip have run together at elevations ``z`` (c,)."""
        places = guides.places(z)
        return any(_crowded(places[arm.path]) for arm in self.arms)

    def spaced(self, guides: Guides, z: FloatArray) -> tuple[Guides, FloatArray]:
        """Return guides that start from evenly spaced nodes, and their elevations (c,).

        Parameters
        ----------
        guides : Guides
            Of all nodes of the cut, c.
        z : (c,) array
            Their elevations: the lips as they are known. A lip stays as it is where its nodes have not run
            together, it does not fold, and does not turn back.
        """
        z = guides.clipped(z)
        places = np.column_stack([guides.places(z), z])
        rates = guides.rates(z)
        lines, levels = list(guides.lines), z.copy()
        for arm, beyond in zip(self.arms, self._staying(places[:, :2]), strict=True):
            line = places[arm.path]
            stay = _unkinked(line[:, :2], beyond)
            if stay.all() and not _crowded(line[:, :2]):
                continue
            spaced = _even(line[stay], len(line))
            surface = arm.surface
            inner = nearest(spaced[1:-1], surface.vertices, surface.triangles).place
            spaced[1:-1] = inner
            first, last = rates[arm.path[0]], rates[arm.path[-1]]
            ways, slants = courses(spaced[:, :2], False, first, last, self.reach)
            made = sections(surface, inner, ways[1:-1], slants[1:-1])
            for k, guide, point in zip(arm.path[1:-1], made, inner, strict=True):
                lines[k], levels[k] = guide, point[2]
        return Guides.of(lines), levels

    def _from_end(self, name: int) -> IntArray:
        """Return the path of a corner's arm from the junction on; ``name`` as in ``corners``."""
        path = self.arms[abs(name) - 1].path
        return path if name > 0 else path[::-1]

    def _staying(self, places: FloatArray) -> list[BoolArray]:
        """Return for each arm which of its nodes do not lie beyond a crossing; ``places`` (c, 2)."""
        stay = [np.ones(len(arm.path), dtype=bool) for arm in self.arms]
        crossed = _crossings([places[arm.path] for arm in self.arms])
        for k, _, i, j in crossed[crossed[:, 0] == crossed[:, 1]]:
            stay[k][min(i, j) + 1 : max(i, j) + 1] = False
        for a, b in self.corners if len(crossed) else ():
            mine = (crossed[:, :2] == (abs(a) - 1, abs(b) - 1)).all(axis=1)
            for _, _, i, j in crossed[mine]:
                # from the junction on, which is the end of an arm with a negative name
                for name, piece in ((a, i), (b, j)):
                    flags = stay[abs(name) - 1]
                    flags[slice(1, piece + 1) if name > 0 else slice(piece + 1, -1)] = False
        for flags in stay:
            flags[[0, -1]] = True
        return stay


def _crowded(line: FloatArray) -> bool:
    """Return whether an edge of a plan line (k, 2) is far shorter than the others."""
    length = np.hypot(*np.diff(line, axis=0).T)
    return bool(length.min() < _TOGETHER * length.mean())


def _crossings(lines: Sequence[FloatArray]) -> IntArray:
    """Return which pieces of plan lines (k, 2) cross inside both, (p, 4): two lines, then a piece of each."""
    pieces = np.concatenate([np.zeros((0, 2, 2)), *(np.stack([a[:-1], a[1:]], axis=1) for a in lines)])
    pairs = near_pieces(pieces, pieces)
    pairs = pairs[straddled(pieces[pairs[:, 0]], pieces[pairs[:, 1]]) < 0]
    pairs = pairs[straddled(pieces[pairs[:, 1]], pieces[pairs[:, 0]]) < 0]
    count = [len(line) - 1 for line in lines]
    line = np.repeat(np.arange(len(lines)), count)[pairs]
    start = np.cumsum([0, *count])[line]
    return ints(np.concatenate([line, pairs - start], axis=1))


def _unkinked(line: FloatArray, stay: BoolArray) -> BoolArray:
    """Return which of the points that ``stay`` on a plan line (k, 2) do so when turns back are left out.

    The sharpest turn first; both ends stay.
    """
    chosen = np.flatnonzero(stay)
    while len(chosen) > 2:
        way = np.diff(line[chosen], axis=0)
        way /= np.maximum(np.hypot(*way.T), np.finfo(float).tiny)[:, None]
        bend = (way[1:] * way[:-1]).sum(axis=1)
        sharpest = int(np.argmin(bend))
        if bend[sharpest] > _KINK:
            break
        chosen = np.delete(chosen, sharpest + 1)
    return np.isin(np.arange(len(line)), chosen)


def _even(line: FloatArray, count: int) -> FloatArray:
    """Return so many points at equal shares of the plan length of a line (k, 3), its ends among them."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])
    at = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(at, along, line[:, k]) for k in range(3)], axis=1)
