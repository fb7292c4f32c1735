"""Scores of a rebuilt horizon against a known answer; the layout of the answer is told in ``graben.demo``.

A cut node is compared with the true lip at the same place along the fault's mean strike, a throw with the
difference of the two true lips at the places of its two nodes; so pairs need not be made as the truth makes
them. A zone node is compared with the true horizon of its own block at the same place in plan; it is left out
where it lies in a true gap, unless it is a cut node, which is a lip wherever it lies.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas
from pydantic import BaseModel, ValidationError
from scipy.interpolate import RectBivariateSpline

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.errors import InputError
from graben.formats.irap import read_irap
from graben.formats.text import load_text
from graben.model import Fault, GridGeometry
from graben.modeling.results import Cutoff, Error, HorizonResult, Score
from graben.surface import mean_dip_direction

LEAST_SHARE = 0.2  #: cut nodes count where the true throw exceeds this share of the largest
_COLUMNS = ("fault", "side", "block", "x", "y", "z", "throw")
_SIDES = {"hanging": 1, "foot": -1}


class _Block(BaseModel):
    sides: dict[str, int]
    file: str


class _Horizon(BaseModel):
    cutoffs: str
    blocks: list[_Block]


class _Index(BaseModel):
    """truth.json."""

    faults: dict[str, str]
    horizons: dict[str, _Horizon]


@dataclass(frozen=True, eq=False)
class _Grid:
    """A smooth function of plan position, bicubic between the nodes of a regular grid."""

    geometry: GridGeometry
    spline: RectBivariateSpline

    def __call__(self, xy: FloatArray) -> FloatArray:
        g = self.geometry
        a = np.radians(g.rotation)
        x, y = xy[:, 0] - g.origin[0], xy[:, 1] - g.origin[1]
        i, j = (x * np.cos(a) + y * np.sin(a)) / g.dx, (y * np.cos(a) - x * np.sin(a)) / g.dy
        return np.asarray(self.spline.ev(i, j), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class _Lip:
    """A true cutoff line: its side (1 hanging, -1 foot), its block and its points (k, 3)."""

    side: int
    block: int
    points: FloatArray


@dataclass(frozen=True, eq=False)
class _Truth:
    """The known answer for one horizon; ``sides`` has a row for each block, a column for each fault."""

    faults: tuple[str, ...]
    surfaces: tuple[_Grid, ...]
    sides: IntArray
    blocks: tuple[_Grid, ...]
    lips: dict[str, list[_Lip]]
    largest: float


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
    truth = _read(truth_folder, result.name)
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
    truth = _read(truth_folder, result.name)
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


def _compared(cutoff: Cutoff, truth: _Truth, strike: FloatArray) -> _Compared:
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


def _facing(truth: _Truth, fault: str) -> list[tuple[_Lip, _Lip]]:
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
    truth: _Truth,
    strikes: dict[str, FloatArray],
    vertices: FloatArray,
    always: BoolArray,
) -> FloatArray:
    """Return u - u_true at the nodes within gamma, without those in a gap that are not to count always."""
    zone = ~result.fixed
    signs = _signs(result, truth)[zone]
    points = vertices[zone]
    fits = (signs[:, None, :] * truth.sides[None, :, :] >= 0).all(axis=2)
    block = np.argmax(fits, axis=1)
    true = np.full(len(points), np.nan)
    for b, grid in enumerate(truth.blocks):
        true[block == b] = grid(points[block == b, :2])
    kept = np.ones(len(points), dtype=bool)
    for f, name in enumerate(truth.faults):
        if not truth.lips[name]:
            continue
        place = points[:, :2] @ strikes[name]
        ends = np.concatenate([lip.points[:, :2] @ strikes[name] for lip in truth.lips[name]])
        beside = (place >= ends.min()) & (place <= ends.max())
        across = truth.sides[block, f] * (true - truth.surfaces[f](points[:, :2])) < 0.0
        kept &= ~(beside & across)
    kept |= always[zone]
    return floats((points[:, 2] - true)[kept])


def _signs(result: HorizonResult, truth: _Truth) -> IntArray:
    """Return the side of each node of each true fault: as cut where it was, else as it first lay."""
    columns = []
    for name, surface in zip(truth.faults, truth.surfaces, strict=True):
        lay = np.where(result.first[:, 2] >= surface(result.first[:, :2]), 1, -1)
        if name in result.graph_faults:
            cut = result.block[:, result.graph_faults.index(name)]
            lay = np.where(cut != 0, cut, lay)
        columns.append(lay)
    return ints(np.stack(columns, axis=1))


def _read(folder: Path, horizon: str) -> _Truth:
    path = folder / "truth.json"
    try:
        index = _Index.model_validate(json.loads(load_text(path)))
    except (json.JSONDecodeError, ValidationError) as error:
        reason = str(error).splitlines()[0].rstrip(".")
        raise InputError(f"{path} is no index of a known answer ({reason}); write the demo again.") from None
    if horizon not in index.horizons:
        raise InputError(f"{path} knows no horizon {horizon!r}; correct the names or leave out `truth`.")
    entry = index.horizons[horizon]
    names = tuple(index.faults)
    sides = ints([[block.sides.get(name, 0) for name in names] for block in entry.blocks], -1, len(names))
    lips, largest = _read_cutoffs(folder / entry.cutoffs, names, len(entry.blocks))
    return _Truth(
        faults=names,
        surfaces=tuple(_read_grid(folder / file) for file in index.faults.values()),
        sides=sides,
        blocks=tuple(_read_grid(folder / block.file) for block in entry.blocks),
        lips=lips,
        largest=largest,
    )


def _read_grid(path: Path) -> _Grid:
    geometry, values = read_irap(path)
    if not np.isfinite(values).all():
        raise InputError(f"{path}: a known answer has no undefined node; write the demo again.")
    spline = RectBivariateSpline(np.arange(geometry.columns), np.arange(geometry.rows), values)
    return _Grid(geometry, spline)


def _read_cutoffs(path: Path, names: tuple[str, ...], blocks: int) -> tuple[dict[str, list[_Lip]], float]:
    load_text(path)
    try:
        table = pandas.read_csv(path)
        numbers = table[["x", "y", "z", "throw"]].to_numpy(dtype=np.float64)
        sides = table["side"].map(_SIDES).to_numpy(dtype=np.int64)
        members = table["block"].to_numpy(dtype=np.int64)
        owners = table["fault"].astype(str).to_numpy()
    except (KeyError, ValueError) as error:
        reason = str(error).splitlines()[0].rstrip(".")
        raise InputError(
            f"{path} holds no cutoffs ({reason}); it needs the columns {', '.join(_COLUMNS)}."
        ) from None
    if not np.isfinite(numbers).all() or members.min() < 0 or members.max() >= blocks:
        raise InputError(
            f"{path}: a number is missing or a block is not in truth.json; write the demo again."
        )
    lips: dict[str, list[_Lip]] = {name: [] for name in names}
    for name in names:
        for side in _SIDES.values():
            for block in range(blocks):
                rows = (owners == name) & (sides == side) & (members == block)
                if rows.any():
                    lips[name].append(_Lip(side, block, floats(numbers[rows, :3])))
    return lips, float(np.abs(numbers[:, 3]).max())
