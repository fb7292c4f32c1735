"""Picks inside the modeling zone: which of them can be trusted, and what they say of the nodes.

A zone is rebuilt because seismic smears a horizon across its faults. Where the picks themselves show the
jump, right up to the fault, they are not smeared, and to leave them out would be to guess what is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import igl
import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.cutgraph import CutGraph
from graben.modeling.distance import distances
from graben.surface import Surface, triangle_normals

#: Share of the jump that the surface further out asks for, which picks next to the fault must show.
_SHARP = 0.5
#: Picks next to the fault that are averaged on each side.
_NEAREST = 3
#: A node follows picks that lie within this many steps.
_REACH = 1.0
#: Picks from which the plane at a node is taken, and how far they may lie, in steps.
_AROUND, _WITHIN = 8, 2.5


@dataclass(frozen=True, eq=False)
class NodeData:
    """What picks say of nodes: elevation ``z`` (k,) and slope ``gradient`` (k, 2) at ``nodes`` (k,)."""

    nodes: IntArray
    z: FloatArray
    gradient: FloatArray


def no_data() -> NodeData:
    """Return the data of a horizon without picks in its zone."""
    return NodeData(np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros((0, 2)))


def node_data(
    picks: FloatArray,
    graph: CutGraph,
    faults: Sequence[Surface],
    gammas: FloatArray,
    nodes: FloatArray,
    block: IntArray,
    step: float,
) -> NodeData:
    """Return what the trusted picks say of nodes of the modeling zone, each from its own side.

    Parameters
    ----------
    picks : (p, 3) array
        Model units.
    graph : CutGraph
        The cut graph.
    faults : sequence of Surface
        The faults that cut the horizon, in the order of ``np.unique(graph.faults)``.
    gammas : (f,) array
        gamma of each.
    nodes : (n, 2) array
        Plan positions on the first mesh.
    block : (n, f) array
        Side of each node with regard to each fault, 0 outside its zone.
    step : float
        Model units.
    """
    if len(picks) == 0:
        return no_data()
    sides, trusted = _sides(picks, graph, faults, gammas)
    picks, sides = picks[trusted], sides[trusted]
    found: list[NodeData] = []
    for kind in np.unique(block[(block != 0).any(axis=1)], axis=0):
        mine = np.flatnonzero((block == kind).all(axis=1))
        own = picks[((sides == kind) | (sides == 0) | (kind == 0)).all(axis=1)]
        if len(own) >= _NEAREST:
            found.append(_planes(own, nodes, mine, step))
    if not found:
        return no_data()
    return NodeData(*(np.concatenate([getattr(d, key) for d in found]) for key in ("nodes", "z", "gradient")))


def _sides(
    picks: FloatArray, graph: CutGraph, faults: Sequence[Surface], gammas: FloatArray
) -> tuple[IntArray, BoolArray]:
    """Return the side of each pick with regard to each fault, (p, f), and which picks are trusted, (p,)."""
    sides = np.zeros((len(picks), len(faults)), dtype=np.int64)
    trusted = np.ones(len(picks), dtype=bool)
    for k, f in enumerate(np.unique(graph.faults)):
        edges = graph.faults == f
        away = distances(picks[:, :2], graph, edges)[0]
        near = np.flatnonzero(away < gammas[k])
        if len(near) == 0:
            continue
        sides[near, k] = _above(picks[near], faults[k])
        if not _sharp(picks[near], sides[near, k], away[near], graph.nodes[graph.edges[edges]].mean(axis=1)):
            trusted[near] = False
    return sides, trusted


def _above(points: FloatArray, fault: Surface) -> IntArray:
    """Return 1 for points above a fault, on its hanging wall, and -1 for those below."""
    _, face, near = igl.point_mesh_squared_distance(
        np.ascontiguousarray(points), np.ascontiguousarray(fault.vertices), np.ascontiguousarray(fault.triangles)
    )
    normal = triangle_normals(fault.vertices, fault.triangles)[face]
    normal = normal * np.where(normal[:, 2:] < 0, -1.0, 1.0)
    return np.where(((points - near) * normal).sum(axis=1) > 0, 1, -1)


def _sharp(picks: FloatArray, sides: IntArray, away: FloatArray, places: FloatArray) -> bool:
    """Return whether the jump between the picks next to a fault is the one that those further out ask for.

    At places (m, 3) along the cut, on each side: the mean of the nearest picks, and the line through the
    outer half of the zone extended to the fault. Without picks on both sides nothing is sharp.
    """
    reach = away.max()
    jump_near, jump_far = [], []
    trees = {s: cKDTree(picks[sides == s][:, :2]) for s in (-1, 1) if (sides == s).sum() > _NEAREST}
    if len(trees) < 2:
        return False
    for place in places[:, :2]:
        near, far = {}, {}
        for s, tree in trees.items():
            around = np.array(tree.query_ball_point(place, reach), dtype=np.int64)
            z, d = picks[sides == s][around, 2], away[sides == s][around]
            outer = d > reach / 2
            if outer.sum() < _NEAREST or np.ptp(d[outer]) == 0:
                break
            near[s] = z[np.argsort(d, kind="stable")[:_NEAREST]].mean()
            far[s] = np.polynomial.polynomial.polyfit(d[outer], z[outer], 1)[0]
        if len(far) == 2:
            jump_near.append(near[-1] - near[1])
            jump_far.append(far[-1] - far[1])
    near_all, far_all = np.array(jump_near), np.array(jump_far)
    return len(far_all) > 0 and bool((near_all * far_all).sum() >= _SHARP * (far_all**2).sum())


def _planes(picks: FloatArray, nodes: FloatArray, mine: IntArray, step: float) -> NodeData:
    """Return elevation and slope at nodes ``mine`` of planes through the picks around them."""
    tree = cKDTree(picks[:, :2])
    away, near = tree.query(nodes[mine], k=min(_AROUND, len(picks)), distance_upper_bound=_WITHIN * step)
    held = (away[:, 0] < _REACH * step) & (np.isfinite(away).sum(axis=1) >= _NEAREST)
    mine, away, near = mine[held], away[held], near[held]
    there = np.isfinite(away)
    near = np.where(there, near, 0)
    weight = np.where(there, np.exp(-((away / step) ** 2)), 0.0)
    rel = (picks[near, :2] - nodes[mine][:, None]) / step
    basis = np.concatenate([np.ones((*rel.shape[:2], 1)), rel], axis=2) * weight[:, :, None]
    fit = (np.linalg.pinv(basis, rcond=1e-2) @ (picks[near, 2] * weight)[:, :, None])[:, :, 0]
    return NodeData(mine, fit[:, 0], fit[:, 1:] / step)
