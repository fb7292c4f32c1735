"""How nodes slide along the outer boundary when a fault's exit moves (paper Sect. 5, formula 3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray

#: Corners of the outline that turn by more than this stay at rest, degrees.
_CORNER = 30.0


@dataclass(frozen=True, eq=False)
class Run:
    """The stretch of the outer boundary from an exit to the next node at rest or the next exit.

    Parameters
    ----------
    nodes : (k,) array
        From the exit on; the last is at rest or another exit.
    arcs : (k,) array
        Distance of the nodes along the boundary from the exit, model units.
    line, line_arcs : (p, 2) and (p,) arrays
        The outline around the exit, also behind it, and the distance along it (negative behind).
    """

    nodes: IntArray
    arcs: FloatArray
    line: FloatArray
    line_arcs: FloatArray

    def arc_of(self, place: FloatArray) -> float:
        """Return the distance along the outline of the point of it nearest to ``place``, shape (2,)."""
        a, way = self.line[:-1], np.diff(self.line, axis=0)
        share = ((place - a) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), np.finfo(float).tiny)
        share = np.clip(share, 0.0, 1.0)
        k = int(np.argmin(((a + share[:, None] * way - place) ** 2).sum(axis=1)))
        return float(self.line_arcs[k] + share[k] * (self.line_arcs[k + 1] - self.line_arcs[k]))

    def slid(self, first: float, last: float) -> FloatArray:
        """Return where the inner nodes come to lie, (k - 2, 2), when the ends move by these distances."""
        share = self.arcs[1:-1] / self.arcs[-1]
        arcs = self.arcs[1:-1] + first * (1.0 - share) + last * share
        return np.stack([np.interp(arcs, self.line_arcs, self.line[:, c]) for c in (0, 1)], axis=1)


def runs(
    points: FloatArray, origin: IntArray, border: IntArray, unknown: BoolArray, exits: IntArray, reach: float
) -> list[Run]:
    """Return the runs of the outer boundary that start at exits.

    Parameters
    ----------
    points : (n, 2) array
        The first mesh, model units.
    origin : (n,) array
        The node that each copy is of.
    border : (b, 2) array
        Directed edges of the outer boundary, copies.
    unknown : (n,) bool array
        Nodes that may move.
    exits : (c,) array
        Copies at which the cut meets the outer boundary.
    reach : float
        Corners nearer to the exit than this slide with it, model units.
    """
    after = dict(border.tolist())
    before = {b: a for a, b in after.items()}
    is_exit = set(exits.tolist())
    walks: dict[int, list[int]] = {}
    for copy in exits.tolist():
        onward = after if copy in after else before
        walks[copy] = _walk(copy, onward, points, unknown, is_exit, reach)
    found: list[Run] = []
    for copy, nodes in walks.items():
        if len(nodes) < 2:
            continue
        twins = [c for c in walks if c != copy and origin[c] == origin[copy] and len(walks[c]) > 1]
        behind = points[walks[twins[0]]][:0:-1] if twins else np.zeros((0, 2))
        line = np.concatenate([behind, points[nodes]])
        arcs = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
        arcs -= arcs[len(behind)]
        found.append(Run(np.array(nodes), arcs[len(behind) :], line, arcs))
    return found


def _walk(
    copy: int, onward: dict[int, int], points: FloatArray, unknown: BoolArray, is_exit: set[int], reach: float
) -> list[int]:
    """Return the nodes from an exit to the first that rests: fixed, a far corner, or another exit."""
    nodes, way = [copy], 0.0
    while nodes[-1] in onward:
        node = onward[nodes[-1]]
        way += float(np.hypot(*(points[node] - points[nodes[-1]])))
        nodes.append(node)
        if not unknown[node] or node in is_exit or node == copy:
            break
        if way >= reach and node in onward and _turn(points, nodes[-2], node, onward[node]) > _CORNER:
            break
    return nodes


def _turn(points: FloatArray, a: int, b: int, c: int) -> float:
    """Return the angle by which the way turns at b, degrees."""
    first, second = points[b] - points[a], points[c] - points[b]
    cross = first[0] * second[1] - first[1] * second[0]
    return float(np.degrees(abs(np.arctan2(cross, first @ second))))
