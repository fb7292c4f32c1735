"""Picks inside the modeling zone: which of them can be trusted, and what they say of the nodes.

A zone is rebuilt because seismic smears a horizon across its faults. Picks that jump at a fault as those
further out ask for were made on its two sides, not tracked over it: to leave them out would be to guess what
is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, SignArray
from graben.cutgraph import CutGraph
from graben.modeling.distance import distances
from graben.proximity import nearest
from graben.surface import Surface, triangle_normals

#: Share of the jump that the surface further out asks for, which planes through the picks next to the fault
#: must show.
_SHARP = 0.5
#: The share of it which the very nearest picks must keep, but for the standard error with which the relief
#: lets it be known. Of horizons smeared over no more than the spacing of their picks some pass the first
#: test; these left 0.5 to 0.87 here. Sharp ones left 0.95 and more.
_KEPT = 0.9
#: The surface further out lies between these distances, in gammas: smear reaches seldom further than the
#: nearer one, and the slope of a narrower strip is chance where picks are few.
_FURTHER = (0.5, 1.5)
#: It is asked at no more places along a fault than this: they tell as much as all.
_PLACES = 400
#: Planes whose normal equations are worse conditioned than this hang on picks in one line.
_CONDITION = 1e6
#: Picks for a local plane. Held out behind gaps of 80 to 150 m in the real horizons at hand, 10 to 16 did
#: equally well and fewer or more did worse: the most local of the good.
_NEIGHBOURS = 10


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
    block: SignArray,
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
    """
    if len(picks) == 0:
        return no_data()
    sides, trusted = _sides(picks, graph, faults, gammas)
    found: list[NodeData] = []
    for kind in np.unique(block[(block != 0).any(axis=1)], axis=0):
        if not trusted[kind != 0].all():
            continue
        own = picks[((sides == kind) | (kind == 0)).all(axis=1)]
        if len(own) < _NEIGHBOURS:
            continue
        mine = np.flatnonzero((block == kind).all(axis=1))
        planes = _local_planes(own, nodes[mine], 2 * gammas.max())
        held = np.isfinite(planes[:, 0])
        found.append(NodeData(mine[held], planes[held, 0], planes[held, 1:]))
    if not found:
        return no_data()
    return NodeData(*(np.concatenate([getattr(d, key) for d in found]) for key in ("nodes", "z", "gradient")))


def _sides(
    picks: FloatArray, graph: CutGraph, faults: Sequence[Surface], gammas: FloatArray
) -> tuple[IntArray, BoolArray]:
    """Return the side of each pick for each fault, (p, f), and around which faults picks are trusted.

    The side is 0 further than two gamma from the cut.
    """
    sides = np.zeros((len(picks), len(faults)), dtype=np.int64)
    trusted = np.zeros(len(faults), dtype=bool)
    for k, f in enumerate(np.unique(graph.faults)):
        edges = graph.faults == f
        away = distances(picks[:, :2], graph, edges)[0]
        near = np.flatnonzero(away < 2 * gammas[k])
        sides[near, k] = _above(picks[near], faults[k])
        places = graph.nodes[graph.edges[edges]].mean(axis=1)[:, :2]
        trusted[k] = _sharp(picks[near], sides[near, k], away[near], places, float(gammas[k]))
    return sides, trusted


def _above(points: FloatArray, fault: Surface) -> IntArray:
    """Return 1 for points above a fault, on its hanging wall, and -1 for those below."""
    near = nearest(points, fault.vertices, fault.triangles)
    normal = triangle_normals(fault.vertices, fault.triangles)[near.simplex]
    normal = normal * np.where(normal[:, 2:] < 0, -1.0, 1.0)
    return np.where(((points - near.place) * normal).sum(axis=1) > 0, 1, -1)


def _sharp(picks: FloatArray, sides: IntArray, away: FloatArray, places: FloatArray, gamma: float) -> bool:
    """Return whether the jump between the picks next to a fault is the one that those further out ask for.

    At places (m, 2) along the cut: the jump between planes of each side, through the nearest picks and
    through those further out. Seismic that is smeared has hardly any jump near the fault. Planes through
    picks no denser than the smear is wide still have some; so the nearest pick of each side must also lie
    where the planes further out have it. Without enough picks on both sides nothing is sharp.
    """
    places = places[:: -(-len(places) // _PLACES)]
    further = (away > _FURTHER[0] * gamma) & (away < _FURTHER[1] * gamma)
    near, far, kept = (np.zeros(len(places)) for _ in range(3))
    for side in (-1, 1):
        own, beyond = picks[(sides == side) & (away < gamma)], picks[further & (sides == side)]
        if len(own) < _NEIGHBOURS or len(beyond) < _NEIGHBOURS:
            return False
        planes = _wide_planes(beyond, places, _FURTHER[1] * gamma)
        next_to = own[cKDTree(own[:, :2]).query(places)[1]]
        there = (planes[:, 1:] * (next_to[:, :2] - places)).sum(axis=1)
        near -= side * _local_planes(own, places, 2 * gamma)[:, 0]
        far -= side * planes[:, 0]
        kept -= side * (next_to[:, 2] - there)
    known = np.isfinite(near) & np.isfinite(far) & np.isfinite(kept)
    near, far, kept = near[known], far[known], kept[known]
    least = float((far**2).sum())
    if least == 0:
        return False
    share = float((kept * far).sum()) / least
    error = float(np.sqrt((((kept - share * far) * far) ** 2).sum())) / least
    return bool((near * far).sum() >= _SHARP * least and share + error >= _KEPT)


def _wide_planes(picks: FloatArray, places: FloatArray, reach: float) -> FloatArray:
    """Return elevation and slope (n, 3) at places (n, 2) by regression on all picks in reach.

    Weights are tricube in the distance over the reach. NaN where fewer than ten picks, or none but some in
    one line, tell it: what lies to one side of a place is continued to it, which few picks do by chance.
    """
    pairs = cKDTree(places).sparse_distance_matrix(cKDTree(picks[:, :2]), reach, output_type="coo_matrix")
    place, pick = pairs.row, pairs.col
    rel = (picks[pick, :2] - places[place]) / reach
    weight = (1.0 - np.hypot(rel[:, 0], rel[:, 1]).clip(max=1.0) ** 3) ** 3
    basis = np.column_stack([np.ones(len(rel)), rel])

    def summed(values: FloatArray) -> FloatArray:
        return np.bincount(place, weight**2 * values, minlength=len(places)).astype(np.float64)

    normal = np.stack([[summed(basis[:, a] * basis[:, b]) for b in range(3)] for a in range(3)])
    load = np.stack([summed(basis[:, a] * picks[pick, 2]) for a in range(3)])
    normal, load = np.moveaxis(normal, 2, 0), load.T
    many = np.bincount(place, minlength=len(places)) >= _NEIGHBOURS
    held = many & (np.linalg.cond(np.where(many[:, None, None], normal, np.eye(3))) < _CONDITION)
    fit = np.full((len(places), 3), np.nan)
    fit[held] = np.linalg.solve(normal[held], load[held, :, None])[:, :, 0]
    fit[:, 1:] /= reach
    return fit


def _local_planes(picks: FloatArray, places: FloatArray, reach: float) -> FloatArray:
    """Return elevation and slope (n, 3) at places (n, 2) by local regression; NaN without picks in reach.

    Weights are tricube in the distance over that of the furthest of the neighbours: W. S. Cleveland,
    Robust locally weighted regression, J. Am. Stat. Assoc. 74 (1979).
    """
    away, near = cKDTree(picks[:, :2]).query(places, k=_NEIGHBOURS)
    width = away[:, -1:]
    weight = (1.0 - (away / np.nextafter(width, np.inf)) ** 3) ** 3
    rel = (picks[near, :2] - places[:, None]) / width[:, :, None]
    basis = np.concatenate([np.ones((*rel.shape[:2], 1)), rel], axis=2) * weight[:, :, None]
    fit = (np.linalg.pinv(basis, rcond=1e-2) @ (picks[near, 2] * weight)[:, :, None])[:, :, 0]
    fit[:, 1:] /= width
    fit[width[:, 0] > reach] = np.nan
    return np.asarray(fit)
