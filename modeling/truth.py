"""The known answer of a model, laid out as ``graben.demo_files`` tells: grids and true cutoffs.

Faults that bound a block together meet, and make up a cluster. Of several clusters, each is known in a window
of its own.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas
from pydantic import BaseModel, ValidationError
from scipy.interpolate import RectBivariateSpline
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.errors import InputError
from graben.formats.irap import read_irap
from graben.formats.text import load_text
from graben.model import GridGeometry

_COLUMNS = ("fault", "side", "block", "x", "y", "z", "throw")
_SIDES = {"hanging": 1, "foot": -1}
_EDGE = 1e-3  # what rounding may put a node on the rim of a grid beyond it, steps


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
class Grid:
    """A smooth function of plan position, bicubic between the nodes of a regular grid."""

    geometry: GridGeometry
    spline: RectBivariateSpline

    def __call__(self, xy: FloatArray) -> FloatArray:
        """Return the values at plan positions (k, 2)."""
        return np.asarray(self.spline.ev(*self._places(xy)), dtype=np.float64)

    def covers(self, xy: FloatArray) -> BoolArray:
        """Return whether plan positions (k, 2) lie on the grid."""
        i, j = self._places(xy)
        last = self.geometry.columns - 1, self.geometry.rows - 1
        inside = (i >= -_EDGE) & (i <= last[0] + _EDGE) & (j >= -_EDGE) & (j <= last[1] + _EDGE)
        return np.asarray(inside, dtype=np.bool_)

    def _places(self, xy: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return plan positions in columns and rows of the grid."""
        g = self.geometry
        a = np.radians(g.rotation)
        x, y = xy[:, 0] - g.origin[0], xy[:, 1] - g.origin[1]
        return floats((x * np.cos(a) + y * np.sin(a)) / g.dx), floats((y * np.cos(a) - x * np.sin(a)) / g.dy)


@dataclass(frozen=True, eq=False)
class Lip:
    """A true cutoff line: its side (1 hanging, -1 foot), its block and its points (k, 3)."""

    side: int
    block: int
    points: FloatArray


@dataclass(frozen=True, eq=False)
class Cluster:
    """Faults that meet, and their blocks: indices of either, (f,) and (b,)."""

    faults: IntArray
    blocks: IntArray


@dataclass(frozen=True, eq=False)
class Truth:
    """The known answer for one horizon; ``sides`` has a row for each block, a column for each fault."""

    faults: tuple[str, ...]
    surfaces: tuple[Grid, ...]
    sides: IntArray
    blocks: tuple[Grid, ...]
    lips: dict[str, list[Lip]]
    largest: float

    @cached_property
    def clusters(self) -> tuple[Cluster, ...]:
        """The clusters of faults that meet."""
        bounds = self.sides != 0
        _, member = connected_components(bounds.T.astype(np.int64) @ bounds.astype(np.int64), directed=False)
        parts = [np.flatnonzero(member == c) for c in range(member.max(initial=-1) + 1)]
        found = [Cluster(ints(p), ints(np.flatnonzero(bounds[:, p].any(axis=1)))) for p in parts]
        return tuple(c for c in found if len(c.blocks))

    def nearest_cluster(self, xy: FloatArray) -> IntArray:
        """Return the cluster whose true lips lie nearest in plan to each position (k, 2)."""
        lines = [
            (c, lip.points[:, :2])
            for c, cluster in enumerate(self.clusters)
            for f in cluster.faults.tolist()
            for lip in self.lips[self.faults[f]]
        ]
        owners = np.repeat([c for c, _ in lines], [len(line) for _, line in lines])
        _, place = cKDTree(np.concatenate([line for _, line in lines])).query(xy)
        return ints(owners[place])


def read_truth(folder: Path, horizon: str) -> Truth:
    """Read the known answer for a horizon from the folder with truth.json; raises InputError."""
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
    return Truth(
        faults=names,
        surfaces=tuple(_read_grid(folder / file) for file in index.faults.values()),
        sides=sides,
        blocks=tuple(_read_grid(folder / block.file) for block in entry.blocks),
        lips=lips,
        largest=largest,
    )


def _read_grid(path: Path) -> Grid:
    geometry, values = read_irap(path)
    if not np.isfinite(values).all():
        raise InputError(f"{path}: a known answer has no undefined node; write the demo again.")
    spline = RectBivariateSpline(np.arange(geometry.columns), np.arange(geometry.rows), values)
    return Grid(geometry, spline)


def _read_cutoffs(path: Path, names: tuple[str, ...], blocks: int) -> tuple[dict[str, list[Lip]], float]:
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
    lips: dict[str, list[Lip]] = {name: [] for name in names}
    keys = pandas.DataFrame({"fault": owners, "lower": sides < 0, "block": members})
    for (owner, lower, block), rows in sorted(keys.groupby(list(keys)).indices.items()):
        if owner in lips:
            lips[owner].append(Lip(-1 if lower else 1, int(block), floats(numbers[rows, :3])))
    return lips, float(np.abs(numbers[:, 3]).max())
