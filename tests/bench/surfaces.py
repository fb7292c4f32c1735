"""The gate on one surface of 100,000 triangles, in turn with OpenGeode-Inspector on the same surface.

One process; a figure is the median of several rounds, a ratio the median of the ratios round by round. Time
is on the clock, of all checks: of the gate with the refinement and all that its further checks ask for, of
the inspector without making its mesh.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray
from graben.demo import HORIZON
from graben.formats.irap import grid_surface
from graben.formats.tsurf import read_tsurf
from graben.formats.tsurf_writer import write_tsurf
from graben.model import Fault, GridGeometry, Horizon, Model
from graben.pipeline import check
from graben.surface import Surface
from tests.bench.tables import Table, seconds_table
from tests.models import grid_triangles
from tests.validators.inspector import mesh_of, seconds

ROUNDS = 7
SIDE, STEP = 224, 50.0


def sheet(place: Callable[[FloatArray, FloatArray], tuple[FloatArray, ...]], name: str = "F") -> Surface:
    """A sheet of 99,458 triangles whose vertices lie at ``place(s, t)``, s and t in metres."""
    s, t = (a.ravel() for a in np.meshgrid(*2 * [STEP * np.arange(SIDE)], indexing="ij"))
    return Surface(name, np.stack(np.broadcast_arrays(*place(s, t)), axis=1), grid_triangles(SIDE, SIDE))


def surfaces() -> dict[str, Surface]:
    wavy = sheet(lambda s, t: (s, t, 200 * np.sin(s / 1000) * np.cos(t / 1500) - 1.2 * t))
    with tempfile.TemporaryDirectory() as folder:
        write_tsurf(Path(folder) / "wavy.ts", [wavy])
        read = read_tsurf(Path(folder) / "wavy.ts")[0].surface
    order = np.random.default_rng(0).permutation(len(wavy.vertices))
    new = np.argsort(order)
    mixed = np.random.default_rng(1).permutation(new[wavy.triangles])
    return {
        "wavy fault": wavy,
        "plane fault": sheet(lambda s, t: (s, t, -1.2 * t)),
        "wavy fault of a .ts file": read,
        "wavy fault, order mixed": Surface("F", wavy.vertices[order], mixed),
        "upright corrugated fault": sheet(
            lambda s, t: (s, 300 * np.sin(s / 2000) + 30 * np.sin(t / 700), -t)
        ),
        "horizon of a grid": sheet(lambda s, t: (s, t, 40 * np.sin(s / 900) + 0.02 * t), HORIZON),
    }


def model_of(name: str, surface: Surface) -> Model:
    if not name.startswith("horizon"):
        return Model(name, (), (Fault(surface),))
    grid = GridGeometry(SIDE, SIDE, STEP, STEP, (0.0, 0.0))
    values = surface.vertices[:, 2].reshape(SIDE, SIDE)
    return Model(name, (Horizon(HORIZON, grid_surface(HORIZON, grid, values), STEP, grid),))


def figures() -> Table:
    table: Table = {}
    for name, surface in surfaces().items():
        model, mesh = model_of(name, surface), mesh_of(surface.vertices, surface.triangles)
        gate, inspector = [], []
        for _ in range(ROUNDS):
            start = time.perf_counter()
            check(model)
            gate.append(time.perf_counter() - start)
            inspector.append(seconds(mesh[0]))
        table[name] = {
            "triangles": len(surface.triangles),
            "gate": statistics.median(gate),
            "inspector": statistics.median(inspector),
            "ratio": statistics.median(np.divide(gate, inspector).tolist()),
        }
    seconds_table(f"one surface: seconds, median of {ROUNDS}", table)
    return table
