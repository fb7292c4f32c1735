"""Scores of a rebuilt horizon against a known answer (:mod:`graben.modeling.truth`).

A cut node is compared with the true lip at the same place along the fault's mean strike, a throw with the
difference of the two true lips at the places of its two nodes; so pairs need not be made as the truth makes
them. A zone node is compared with the true horizon of its own block at the same place in plan; it is left out
where it lies in a true gap, unless it is a cut node, which is a lip wherever it lies. Of several clusters of
faults, it belongs to the one whose true lips lie nearest in plan; beyond that one's window it is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.errors import InputError
from graben.model import Fault
from graben.modeling.results import Cutoff, Error, HorizonResult, Score
from graben.modeling.truth import Cluster, Lip, Truth, read_truth
from graben.surface import mean_dip_direction

LEAST_SHARE = 0.2  #: cut nodes count where the true throw exceeds this share of the largest


@dataclass(frozen=True, eq=False)
class _Compared:
    """Cut nodes beside their truth: errors of the hanging lip, the foot and the throw, and the true throw."""

    hanging: FloatArray
    foot: FloatArray
    throw: FloatArray
    true_throw: FloatArray


def score(truth_folder: Path, result: HorizonResult, faults: tuple[Fault, ...]) -> Score | None:
    """Return the errors of a rebuilt horizon.

    Parameters
    ----------
    truth_folder : Path
        The folder with truth.json.
    result : HorizonResult
        In the model's own coordinates, elevations.
    faults : tuple of Fault
        The model's faults, whose mean strike says what "the same place along strike" is.

    Returns
    -------
    Score or None
        None where there is nothing to score: no cut node with a true throw above 20 % of the largest.

    Raises
    ------
    InputError
        When the truth cannot be read, or does not hold the horizon or one of its faults.
    """
    truth = read_truth(truth_folder, result.name)
    strikes = {name: _chord(lips[0].points) for name, lips in truth.lips.items() if lips}
    strikes |= {f.name: _strike(f) for f in faults}
    for name in result.graph_faults:
        if not truth.lips.get(name):
            raise InputError(f"{truth_folder}: no cutoffs of fault {name!r}; correct the names or the truth.")
    pieces = [_compared(c, truth, strikes[c.fault]) for c in result.cutoffs]
    if not pieces:
        return None
    hanging, foot, throw, true_throw = (
        np.concatenate([getattr(p, key) for p in pieces])
        for key in ("hanging", "foot", "throw", "true_throw")
    )
    counted = np.abs(true_throw) > LEAST_SHARE * truth.largest
    if not counted.any():
        return None
    zone = _zone_errors(result, truth, strikes, result.surface.vertices, result.side != 0)
    zone_input = _zone_errors(result, truth, strikes, result.first, np.zeros(len(result.first), dtype=bool))
    lips = np.concatenate([hanging[counted], foot[counted]])
    return Score(*(_error(e, truth.largest) for e in (lips, throw[counted], zone, zone_input)))


def true_throws(
    truth_folder: Path, result: HorizonResult, faults: tuple[Fault, ...]
) -> tuple[FloatArray, ...]:
    """Return the true throw at each row of each cutoff, (k,) each, model units; raises as :func:`score`."""
    truth = read_truth(truth_folder, result.name)
    strikes = {f.name: _strike(f) for f in faults}
    return tuple(_compared(c, truth, strikes[c.fault]).true_throw for c in result.cutoffs)


def _error(errors: FloatArray, largest: float) -> Error:
    value = float(np.sqrt(np.mean(errors**2))) if len(errors) else 0.0
    return Error(value, 100.0 * value / largest)


def _strike(fault: Fault) -> FloatArray:
    direction, _ = mean_dip_direction(fault.surface.vertices, fault.surface.triangles)
    return floats([-direction[1], direction[0]])


def _chord(line: FloatArray) -> FloatArray:
    """Return the plan direction between the ends of a line: strike, where the model lacks the fault."""
    way = line[-1, :2] - line[0, :2]
    return floats(way / np.linalg.norm(way))


def _compared(cutoff: Cutoff, truth: Truth, strike: FloatArray) -> _Compared:
    """Return the rows of a cutoff beside the truth.

    Of the pairs of true lips that face each other across the fault (one for each side of a fault that
    crosses it or ends on it), a row belongs to the pair it lies nearest to.
    """
    nearest = np.full(len(cutoff.s), np.inf)
    true_hanging, true_foot = np.full_like(nearest, np.nan), np.full_like(nearest, np.nan)
    for upper, lower in _facing(truth, cutoff.fault):
        away = _distance(cutoff.hanging, upper.points) + _distance(cutoff.foot, lower.points)
        closer = away < nearest
        true_hanging[closer] = _along(upper.points, strike, cutoff.hanging[closer])
        true_foot[closer] = _along(lower.points, strike, cutoff.foot[closer])
        nearest = np.minimum(nearest, away)
    true_throw = true_foot - true_hanging
    return _Compared(
        hanging=floats(cutoff.hanging[:, 2] - true_hanging),
        foot=floats(cutoff.foot[:, 2] - true_foot),
        throw=floats(cutoff.throw - true_throw),
        true_throw=floats(true_throw),
    )


def _facing(truth: Truth, fault: str) -> list[tuple[Lip, Lip]]:
    """Return the pairs of hanging and foot lips whose blocks lie on the same side of every other fault."""
    others = np.array([name != fault for name in truth.faults])
    lips = truth.lips[fault]
    return [
        (h, f)
        for h in lips
        for f in lips
        if h.side > 0 > f.side and (truth.sides[h.block] * truth.sides[f.block] >= 0)[others].all()
    ]


def _along(line: FloatArray, strike: FloatArray, points: FloatArray) -> FloatArray:
    """Return the elevation of a line at the places of points along strike."""
    place = line[:, :2] @ strike
    order = np.argsort(place)
    return np.asarray(np.interp(points[:, :2] @ strike, place[order], line[order, 2]), dtype=np.float64)


def _distance(points: FloatArray, line: FloatArray) -> FloatArray:
    """Return the distance in space of each point from a polyline."""
    start, way = line[:-1], np.diff(line, axis=0)
    length = np.maximum((way**2).sum(axis=1), np.finfo(np.float64).tiny)
    to = points[:, None, :] - start[None, :, :]
    share = np.clip((to * way).sum(axis=2) / length, 0.0, 1.0)
    return np.asarray(np.linalg.norm(to - share[..., None] * way, axis=2).min(axis=1), dtype=np.float64)


def _zone_errors(
    result: HorizonResult,
    truth: Truth,
    strikes: dict[str, FloatArray],
    vertices: FloatArray,
    always: BoolArray,
) -> FloatArray:
    """Return u - u_true at the nodes within gamma, without those in a gap that are not to count always."""
    nodes = np.flatnonzero(~result.fixed)
    nearest = truth.nearest_cluster(vertices[nodes, :2])
    errors = []
    for number, cluster in enumerate(truth.clusters):
        mine = nodes[nearest == number]
        mine = mine[truth.blocks[cluster.blocks[0]].covers(vertices[mine, :2])]
        points = vertices[mine]
        true, gap = _true_elevations(truth, cluster, strikes, points, _signs(result, truth, cluster, mine))
        errors.append((points[:, 2] - true)[~gap | always[mine]])
    return floats(np.concatenate(errors))


def _true_elevations(
    truth: Truth, cluster: Cluster, strikes: dict[str, FloatArray], points: FloatArray, signs: IntArray
) -> tuple[FloatArray, BoolArray]:
    """Return the true elevation of each point in its block of a cluster, and whether it lies in a gap."""
    sides = truth.sides[np.ix_(cluster.blocks, cluster.faults)]
    block = np.argmax((signs[:, None, :] * sides[None, :, :] >= 0).all(axis=2), axis=1)
    true = np.full(len(points), np.nan)
    for b, number in enumerate(cluster.blocks.tolist()):
        true[block == b] = truth.blocks[number](points[block == b, :2])
    gap = np.zeros(len(points), dtype=bool)
    for column, f in enumerate(cluster.faults.tolist()):
        name = truth.faults[f]
        if not truth.lips[name]:
            continue
        place = points[:, :2] @ strikes[name]
        ends = np.concatenate([lip.points[:, :2] @ strikes[name] for lip in truth.lips[name]])
        beside = (place >= ends.min()) & (place <= ends.max())
        beyond = sides[block, column] * (true - truth.surfaces[f](points[:, :2])) < 0.0
        gap |= beside & beyond
    return floats(true), gap


def _signs(result: HorizonResult, truth: Truth, cluster: Cluster, nodes: IntArray) -> IntArray:
    """Return the side of nodes of each fault of a cluster: as cut where it was, else as it first lay."""
    first = result.first[nodes]
    columns = []
    for f in cluster.faults.tolist():
        lay = np.where(first[:, 2] >= truth.surfaces[f](first[:, :2]), 1, -1)
        if truth.faults[f] in result.graph_faults:
            cut = result.block[nodes, result.graph_faults.index(truth.faults[f])]
            lay = np.where(cut != 0, cut, lay)
        columns.append(lay)
    return ints(np.stack(columns, axis=1))
