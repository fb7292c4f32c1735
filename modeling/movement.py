"""How each copy of a cut node may move: its guide on its fault (paper Sect. 6, formula 6, Table 1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.complexes import Complex
from graben.cutgraph import CutGraph
from graben.modeling.courses import courses
from graben.modeling.cutting import CutMesh
from graben.modeling.fictitious import wall_edges
from graben.modeling.guides import Guides, branch, sections
from graben.modeling.snapping import NEAR, near_boundary
from graben.proximity import nearest
from graben.surface import Surface, boundary_edges, chained

_Near = Callable[[FloatArray], BoolArray]


class Role(IntEnum):
    """What a copy of a cut node is tied to."""

    FREE = 0  #: inside a sub-edge: moves on its fault along v(t)
    TIP = 1  #: moves along the rim of its fault
    EXIT = 2  #: moves along W_i ∩ W_fict
    JUNCTION = 3  #: moves along W_i ∩ W_j


@dataclass(frozen=True, eq=False)
class Lips:
    """The copies on the cut and what bounds the sector of each.

    Parameters
    ----------
    copies : (c,) array
        Copies of the nodes of the cut.
    roles : (c,) array
        :class:`Role` of each.
    faults : (c, 2) array
        The faults of the two cut edges that bound its sector; equal where there is one.
    sides : (c,) array
        1 on the hanging wall, -1 on the footwall, 2 at a junction, 0 at a tip.
    chains : list of (int, int, array)
        Fault, side and copies of each lip from guided end to guided end, in the direction of its edges.
    """

    copies: IntArray
    roles: IntArray
    faults: IntArray
    sides: IntArray
    chains: list[tuple[int, int, IntArray]]


def lips(graph: CutGraph, cut: CutMesh) -> Lips:
    """Return the lips of a cut mesh: each side of each fault between guided ends.

    A sector bounded by one fault twice continues its lip: inside a sub-edge, and on the far side of a T.
    """
    e = len(graph.edges)
    # Half-edges with the triangulation on their left: the left lips forward, the right lips backward.
    start = np.concatenate([cut.left[:, 0], cut.right[:, 1]])
    end = np.concatenate([cut.left[:, 1], cut.right[:, 0]])
    fault = np.tile(graph.faults, 2)
    side = np.repeat([-1, 1], e)
    into = np.full(len(cut.origin), -1)
    out = np.full(len(cut.origin), -1)
    into[end], out[start] = np.arange(2 * e), np.arange(2 * e)
    copies = np.flatnonzero((into >= 0) | (out >= 0))
    i, o = into[copies], out[copies]
    both = (i >= 0) & (o >= 0)
    same_edge = both & (i % max(e, 1) == o % max(e, 1))
    same_fault = both & (fault[i] == fault[o])
    roles = np.where(
        ~both, Role.EXIT, np.where(same_edge, Role.TIP, np.where(same_fault, Role.FREE, Role.JUNCTION))
    )
    first, last = np.where(i >= 0, i, o), np.where(o >= 0, o, i)
    faults = np.stack([fault[first], fault[last]], axis=1)
    sides = np.select([roles == Role.JUNCTION, roles == Role.TIP], [2, 0], side[first])
    free = np.zeros(len(cut.origin), dtype=bool)
    free[copies[roles == Role.FREE]] = True
    chains = _chains(start, end, out, free, fault, side, e)
    return Lips(ints(copies), ints(roles), ints(faults), ints(sides), chains)


def _chains(
    start: IntArray, end: IntArray, out: IntArray, free: np.ndarray, fault: IntArray, side: IntArray, e: int
) -> list[tuple[int, int, IntArray]]:
    """Return the lips as runs of half-edges through free copies, each in the direction of its cut edges."""
    chains: list[tuple[int, int, IntArray]] = []
    done = np.zeros(2 * e, dtype=bool)
    for h0 in [*np.flatnonzero(~free[start]).tolist(), *range(2 * e)]:
        if done[h0]:
            continue
        path, h = [int(start[h0])], h0
        while h >= 0 and not done[h]:
            done[h] = True
            path.append(int(end[h]))
            h = int(out[end[h]]) if free[end[h]] else -1
        forward = side[h0] == -1
        chains.append((int(fault[h0]), int(side[h0]), ints(path if forward else path[::-1])))
    return chains


def guides_of(
    graph: CutGraph,
    cut: CutMesh,
    lip: Lips,
    faults: Sequence[Surface],
    horizon: Surface,
    network: Complex,
    reach: float,
) -> Guides:
    """Return the guide of every copy in ``lip.copies``.

    Parameters
    ----------
    graph, cut, lip
        The cut graph, the cut mesh and its lips.
    faults : sequence of Surface
        The model's faults.
    horizon : Surface
        The input horizon, for W_fict.
    network : Complex
        The common refinement of the faults.
    reach : float
        Distance along a lip over which the normals are smoothed, model units: those of a kinked trace
        cross close by, and nodes that follow them would fold the lip.
    """
    lines: list[FloatArray] = [np.zeros((0, 3))] * len(lip.copies)
    nodes = graph.nodes[cut.origin[lip.copies]]
    way = np.diff(graph.nodes[graph.edges], axis=1)[:, 0]
    near = NEAR * float(np.median(np.hypot(way[:, 0], way[:, 1]))) if len(way) else 0.0
    _tips(lines, lip, nodes, faults)
    _junctions(lines, lip, nodes, faults, network, near)
    if (lip.roles == Role.EXIT).any():
        _exits(lines, lip, nodes, faults, horizon, network, near)
    held = np.flatnonzero(lip.roles != Role.FREE)
    ends = Guides.of([lines[k] for k in held])
    toward = np.zeros((len(cut.origin), 2))
    toward[lip.copies[held]] = ends.rates(nodes[held, 2])
    _free(lines, graph, cut, lip, faults, toward, reach)
    return Guides.of(lines)


def _nearest_branch(chains: list[FloatArray], point: FloatArray) -> FloatArray:
    """Return the rising branch around a point of the chain that passes nearest to it."""
    if not chains:
        return point[None]
    chain = chains[int(np.argmin([_gap(c, point) for c in chains]))]
    return branch(chain, point, float(np.ptp(chain, axis=0).max()))


def _beside(rims: list[FloatArray], point: FloatArray, reach: float, near: _Near) -> FloatArray:
    """Return the branch of a fault's rim around a point as far as it is near to another surface.

    Where a fault ends at another, or at the boundary, to the digits of its file only, they meet in fragments
    or not at all: then the rim is the line in which they meet. The point alone if no rim is within reach.
    """
    if not rims or min(_gap(rim, point) for rim in rims) > reach**2:
        return point[None]
    line = _nearest_branch(rims, point)
    at = int(np.argmin(np.linalg.norm(line - point, axis=1)))
    lost = np.flatnonzero(~near(line))
    first = int(lost[lost < at].max(initial=-1)) + 1
    last = int(lost[lost > at].min(initial=len(line)))
    return line[first:last] if last > first else point[None]


def _longest(lines: list[FloatArray]) -> FloatArray:
    """Return the guide that reaches over the widest range of elevations, the first of equals."""
    return max(lines, key=lambda line: float(line[-1, 2] - line[0, 2]))


def _rims(surface: Surface) -> list[FloatArray]:
    return [surface.vertices[c] for c in chained(boundary_edges(surface.triangles))]


def _near_surface(surface: Surface, reach: float) -> _Near:
    """Return what says which points, (k, 3), lie within ``reach`` of a surface."""

    def near(points: FloatArray) -> BoolArray:
        return np.asarray(nearest(points, surface.vertices, surface.triangles).distance <= reach, dtype=bool)

    return near


def _gap(line: FloatArray, point: FloatArray) -> float:
    a, way = line[:-1], np.diff(line, axis=0)
    share = ((point - a) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), np.finfo(float).tiny)
    near = a + np.clip(share, 0.0, 1.0)[:, None] * way
    return float(((near - point) ** 2).sum(axis=1).min())


def _tips(lines: list[FloatArray], lip: Lips, nodes: FloatArray, faults: Sequence[Surface]) -> None:
    for f in np.unique(lip.faults[lip.roles == Role.TIP, 0]):
        rims = _rims(faults[f])
        for k in np.flatnonzero((lip.roles == Role.TIP) & (lip.faults[:, 0] == f)):
            lines[k] = _nearest_branch(rims, nodes[k])


def _junctions(
    lines: list[FloatArray],
    lip: Lips,
    nodes: FloatArray,
    faults: Sequence[Surface],
    network: Complex,
    reach: float,
) -> None:
    at = np.flatnonzero(lip.roles == Role.JUNCTION)
    if len(at) == 0:
        return
    edges, sides = network.edges()
    owners = [np.unique(sides[network.owner == f]) for f in range(int(network.owner.max()) + 1)]
    for pair in np.unique(np.sort(lip.faults[at], axis=1), axis=0):
        shared = np.intersect1d(owners[pair[0]], owners[pair[1]])
        chains = [network.vertices[c] for c in chained(edges[shared])]
        both = [(_rims(faults[f]), _near_surface(faults[g], reach)) for f, g in (pair, pair[::-1])]
        for k in at[(np.sort(lip.faults[at], axis=1) == pair).all(axis=1)]:
            rims = [_beside(rim, nodes[k], reach, near) for rim, near in both]
            lines[k] = _longest([_nearest_branch(chains, nodes[k]), *rims])


def _exits(
    lines: list[FloatArray],
    lip: Lips,
    nodes: FloatArray,
    faults: Sequence[Surface],
    horizon: Surface,
    network: Complex,
    reach: float,
) -> None:
    both, edges, owner = wall_edges(horizon, network)
    at = np.flatnonzero(lip.roles == Role.EXIT)

    def near(points: FloatArray) -> BoolArray:
        return near_boundary(points[:, :2], horizon, reach)

    for f in np.unique(lip.faults[at, 0]):
        chains = [both.vertices[c] for c in chained(edges[owner == f])]
        rims = _rims(faults[f])
        for k in at[lip.faults[at, 0] == f]:
            rim = _beside(rims, nodes[k], reach, near)
            lines[k] = _longest([_nearest_branch(chains, nodes[k]), rim])


def _free(
    lines: list[FloatArray],
    graph: CutGraph,
    cut: CutMesh,
    lip: Lips,
    faults: Sequence[Surface],
    toward: FloatArray,
    reach: float,
) -> None:
    """Set the guides of free copies: sections of their fault along v(t), formula (6)."""
    position = np.full(len(cut.origin), -1)
    position[lip.copies] = np.arange(len(lip.copies))
    ways, slants = np.zeros((len(lip.copies), 2)), np.zeros(len(lip.copies))
    for _, _, path in lip.chains:
        points = graph.nodes[cut.origin[path]][:, :2]
        closed, at = bool(path[0] == path[-1]), position[path]
        ways[at], slants[at] = courses(points, closed, toward[path[0]], toward[path[-1]], reach)
    for f in np.unique(lip.faults[lip.roles == Role.FREE, 0]):
        mine = np.flatnonzero((lip.roles == Role.FREE) & (lip.faults[:, 0] == f))
        made = sections(faults[f], graph.nodes[cut.origin[lip.copies[mine]]], ways[mine], slants[mine])
        for k, line in zip(mine, made, strict=True):
            lines[k] = line
