"""Large models with a known answer: 40,000 to 1,000,000 nodes, 10 to 45 faults of 45 degrees.

All lie in one field of 30 by 52.8 km, cut into 11 rows of 6 cells. One fault of 10, two of 20 and three of 45
leave the field at both ends, as in the replica of Chesapeake: each takes a row, and they part the field into
2, 3 or 4 subdomains of about equal area. Each cell of the other rows holds one fault, two that cross, or
none. The faults are those of the replicas (:mod:`graben.replica_models`) and do not depend on the step,
so that models of one number of faults differ in their nodes alone.

`python -m tests.bench.large_models 1M 45 FOLDER` writes one.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray, floats
from graben.demo import HORIZON
from graben.formats.irap import write_irap_ascii
from graben.formats.tsurf_writer import write_tsurf
from graben.model import GridGeometry, Model
from graben.replica_list import Replica
from graben.replica_models import Cluster, Draft, Field, triangulated
from graben.synthetic import REACH, SMEAR

#: Step of the grid by number of nodes, m: 40,015, 248,536 and 992,071 nodes.
STEPS = {"40k": 200.0, "250k": 80.0, "1M": 40.0}
#: Faults that cross another by number of faults.
CROSSINGS = {10: 1, 20: 2, 45: 4}
#: Rows that dividing faults take by number of faults: what they part differs by about a fifth in area.
DIVIDED = {10: (5,), 20: (3, 7), 45: (2, 5, 8)}
#: Half-width of the zones: what smear and heave ask for, and one with which they fill more than half, m.
USUAL, WIDE = 450.0, 1900.0
_ROWS, _ACROSS = 11, 6
_CELL = (5000.0, 4800.0)  # whole steps of each grid; a fault that crosses another is up to 4.6 km long, m
_DIP = 45.0  # degrees
_SLOPE = 0.04  # of the undisplaced horizon: steeper ones rise by more than the relief of a basin
_SEED = 0
_DIGITS = 4  # decimals of the elevations, as files of grids have them
_FAR = 5.0 * REACH  # displacement is below a nanometre there, m across strike
_BESIDE = 6.0 * SMEAR  # and what a fault's bends add to the way across, m


@dataclass(frozen=True)
class Sheet(Replica):
    """A replica whose cells are as many whatever its faults; ``divided``: rows of the dividing ones."""

    divided: tuple[int, ...] = ()

    @property
    def rows(self) -> int:
        """Rows of cells."""
        return _ROWS


class _Drawn(Draft):
    """The faults of a sheet: those that divide it in rows that are given, all others drawn."""

    def __init__(self, sheet: Sheet, random: np.random.Generator) -> None:
        super().__init__(sheet, random)
        self._divided = sheet.divided

    def clusters(self) -> list[Cluster]:
        """Return the clusters: faults that cross, faults that divide the field, and faults alone."""
        r = self._replica
        rows = [row for row in range(r.rows) if row not in self._divided]
        cells = [(column, row) for row in rows for column in range(r.across)]
        middles = self._random.permutation(cells)[: r.crossings + r.alone].tolist()
        made = [self._crossing(self._middle(*cell)) for cell in middles[: r.crossings]]
        made += [self._dividing(float(row), 0) for row in self._divided]
        return made + [self._alone(self._middle(*cell)) for cell in middles[r.crossings :]]


def large(nodes: str, faults: int, gamma: float = USUAL) -> Model:
    """Return a model; ``nodes`` one of STEPS, ``faults`` one of CROSSINGS, ``gamma`` of all faults, m."""
    return large_field(nodes, faults, gamma).model()


def large_field(nodes: str, faults: int, gamma: float = USUAL) -> Field:
    """Return a model with what is true of it; parameters as of :func:`large`."""
    step, sheet = STEPS[nodes], _sheet(nodes, faults)
    made = [triangulated(c) for c in _Drawn(sheet, np.random.default_rng(_SEED)).clusters()]
    clusters = tuple(c for c, _ in made)
    columns, rows = (round(extent / step) + 1 for extent in sheet.size)
    grid = GridGeometry(columns, rows, step, step, (0.0, 0.0))
    gammas = tuple(tuple(gamma for _ in cluster.faults) for cluster in clusters)
    return Field(sheet, clusters, tuple(s for _, s in made), gammas, grid, _seismic(clusters, grid))


def write_large(folder: Path, model: Model) -> Path:
    """Write a model (one grid; all faults with one gamma) into a folder; return its model.toml."""
    folder.mkdir(parents=True, exist_ok=True)
    horizon = model.horizons[0]
    if horizon.grid is None:
        raise ValueError("A large model has a grid.")
    values = horizon.surface.vertices[:, 2].reshape(horizon.grid.columns, horizon.grid.rows)
    write_irap_ascii(folder / "top.irap", horizon.grid, floats(values))
    for fault in model.faults:
        write_tsurf(folder / f"{fault.name}.ts", [fault.surface])
    head = f'[model]\nname = "{model.name}"\nz = "elevation"\nunit = "m"\n\n'
    top = f'[[horizons]]\nname = "{HORIZON}"\nfile = "top.irap"\n\n'
    parts = "".join(f'[[faults]]\nname = "{f.name}"\nfile = "{f.name}.ts"\n\n' for f in model.faults)
    file = folder / "model.toml"
    text = f"{head}{top}{parts}[parameters]\ngamma = {model.faults[0].gamma}\n"
    file.write_text(text, encoding="utf-8")
    return file


def _sheet(nodes: str, faults: int) -> Sheet:
    return Sheet(
        name=f"{nodes} nodes, {faults} faults",
        step=STEPS[nodes],
        faults=faults,
        intersections=CROSSINGS[faults],
        least_dip=_DIP,
        mean_dip=_DIP,
        across=_ACROSS,
        cell=_CELL,
        crossed=(0,) * len(DIVIDED[faults]),
        crossings=CROSSINGS[faults],
        slope=_SLOPE,
        divided=DIVIDED[faults],
    )


def _seismic(clusters: Sequence[Cluster], grid: GridGeometry) -> FloatArray:
    """Return what seismic shows, (columns, rows); each cluster is added only where it displaces at all."""
    nodes = grid.nodes()
    values = clusters[0].regional(nodes)
    for cluster in clusters:
        near = _window(cluster, grid)
        values[near] += cluster.added(nodes[near])
    return floats(np.round(values, _DIGITS))


def _window(cluster: Cluster, grid: GridGeometry) -> tuple[slice, slice]:
    """Return the columns and rows between which a cluster displaces the horizon."""
    corners = []
    for fault, trace in zip(cluster.faults, cluster.traces, strict=True):
        s = fault.half_length * np.array([-1.0, 1.0])
        q = trace(np.linspace(-fault.half_length, fault.half_length, 100))
        across = np.array([q.min() - _FAR - _BESIDE, q.max() + _FAR + _BESIDE])
        corners.append(fault.position(*(a.ravel() for a in np.meshgrid(s, across))))
    points = np.concatenate(corners) / grid.dx
    counts = (grid.columns, grid.rows)
    low = np.clip(np.floor(points.min(axis=0)).astype(int), 0, counts)
    high = np.clip(np.ceil(points.max(axis=0)).astype(int) + 1, 0, counts)
    return slice(low[0], high[0]), slice(low[1], high[1])


if __name__ == "__main__":
    print(write_large(Path(sys.argv[3]), large(sys.argv[1], int(sys.argv[2]))))
