"""Large models with a known answer: 40,000 to 1,000,000 nodes, 10 to 45 faults of 45 degrees.

All lie in one square of 35 km, cut into cells of 5 km; a cell holds one fault, two that cross, or none. The
faults are those of the replicas (:mod:`tests.bench.replica_models`) and do not depend on the step, so that
models of one number of faults differ in their nodes alone, and in one of more faults the cells fill up.

`python -m tests.bench.large_models 1M 45 FOLDER` writes one.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray, floats
from graben.demo import HORIZON
from graben.formats.irap import write_irap_ascii
from graben.formats.tsurf_writer import write_tsurf
from graben.model import GridGeometry, Model
from graben.synthetic import REACH, SMEAR
from tests.bench.replica_list import REPLICAS, Replica
from tests.bench.replica_models import Cluster, Field, field

#: Step of the grid by number of nodes, m: 201, 501 and 1001 nodes along each side.
STEPS = {"40k": 175.0, "250k": 70.0, "1M": 35.0}
#: Faults that cross another by number of faults.
CROSSINGS = {10: 1, 20: 2, 45: 4}
#: Half-width of the zones: what smear and heave ask for, and one with which they fill more than half, m.
USUAL, WIDE = 450.0, 1900.0
_ACROSS = 7
_CELL = 5000.0  # m
_DIP = 45.0  # degrees
_SLOPE = 0.04  # of the undisplaced horizon: steeper ones rise by more than the relief of a basin
_SEED = 0
_DRAFT_STEP = 500.0  # the faults are drawn with a grid that is thrown away, m
_DIGITS = 4  # decimals of the elevations, as files of grids have them
_FAR = 5.0 * REACH  # displacement is below a nanometre there, m across strike
_BESIDE = 6.0 * SMEAR  # and what a fault's bends add to the way across, m


@dataclass(frozen=True)
class Sheet(Replica):
    """A replica whose cells are as many whatever its faults."""

    @property
    def rows(self) -> int:
        """Rows of cells."""
        return self.across


def large(nodes: str, faults: int, gamma: float = USUAL) -> Model:
    """Return a model; ``nodes`` one of STEPS, ``faults`` one of CROSSINGS, ``gamma`` of all faults, m."""
    return replace(large_field(nodes, faults, gamma).model(), name=f"{nodes} nodes, {faults} faults")


def large_field(nodes: str, faults: int, gamma: float = USUAL) -> Field:
    """Return a model with what is true of it; parameters as of :func:`large`."""
    step, side = STEPS[nodes], _ACROSS * _CELL
    count = round(side / step) + 1
    draft = field(_sheet(faults), _SEED)
    grid = GridGeometry(count, count, step, step, (0.0, 0.0))
    gammas = tuple(tuple(gamma for _ in cluster.faults) for cluster in draft.clusters)
    return replace(
        draft,
        replica=replace(draft.replica, step=step),
        gammas=gammas,
        grid=grid,
        values=_seismic(draft.clusters, grid),
    )


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


def _sheet(faults: int) -> Sheet:
    return Sheet(
        name=f"sheet of {faults}",
        step=_DRAFT_STEP,
        faults=faults,
        intersections=CROSSINGS[faults],
        least_dip=_DIP,
        mean_dip=_DIP,
        reported=REPLICAS["Chesapeake"].reported,
        across=_ACROSS,
        cell=(_CELL, _CELL),
        crossed=(),
        crossings=CROSSINGS[faults],
        slope=_SLOPE,
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
    low = np.clip(np.floor(points.min(axis=0)).astype(int), 0, grid.columns)
    high = np.clip(np.ceil(points.max(axis=0)).astype(int) + 1, 0, grid.columns)
    return slice(low[0], high[0]), slice(low[1], high[1])


if __name__ == "__main__":
    print(write_large(Path(sys.argv[3]), large(sys.argv[1], int(sys.argv[2]))))
