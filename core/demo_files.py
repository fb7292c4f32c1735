"""The files of a synthetic model: its input, and beside it what is true of it.

- ``truth/truth.json``: {"schema": 1, "faults": {name: file}, "horizons": {name: {"cutoffs": file,
  "blocks": [{"sides": {fault: 1 | -1 | 0}, "file": file}]}}}. A side is 1 where the block hangs on the
  fault, -1 where it is the foot, 0 where the fault does not reach the block. Files are relative to truth/.
- ``truth/cutoffs/<horizon>.csv``: fault, side, block (its place in the list), s, x, y, z, throw. Every
  10 m along strike and at the ends; s is the straight distance along strike from the fault's end, throw the
  elevation of foot minus hanging at the same s.
- ``truth/blocks/<horizon>-<block>.irap``: the true horizon of a block over the whole domain, beyond its
  faults too, at half the model's step.
- ``truth/faults/<fault>.irap``: the elevation of the fault on the same grid, extended beyond its ends.

A field of several clusters of faults (:mod:`graben.replica_models`) has one such truth as well. There a block
names the faults of its own cluster only, and its grids and those of the faults cover the cluster's window.

z is elevation throughout.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray
from graben.demo_model import HORIZON, SyntheticModel
from graben.formats.irap import write_irap_ascii
from graben.formats.tsurf_writer import write_tsurf
from graben.model import Fault, GridGeometry


def write_input(
    folder: Path,
    name: str,
    grid: GridGeometry,
    values: FloatArray,
    faults: Sequence[Fault],
    *,
    noise: float,
    gamma: float | None = None,
) -> None:
    """Write model.toml, its horizon (elevations with ``noise``, m) and its faults into a folder.

    The folder is made where missing. ``gamma``: of the faults that have none of their own, m.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_irap_ascii(folder / "top.irap", grid, values)
    text = f'[model]\nname = "{name}"\nz = "elevation"\nunit = "m"\ntruth = "truth"\n\n'
    text += f'[[horizons]]\nname = "{HORIZON}"\nfile = "top.irap"\n'
    text += f"noise = {noise}\n\n" if noise else "\n"
    for fault in faults:
        write_tsurf(folder / f"{fault.name}.ts", [fault.surface])
        text += f'[[faults]]\nname = "{fault.name}"\nfile = "{fault.name}.ts"\n'
        text += f"gamma = {fault.gamma}\n\n" if fault.gamma else "\n"
    text += f"[parameters]\ngamma = {gamma}\n" if gamma else ""
    (folder / "model.toml").write_text(text, encoding="utf-8")


def write_truth(folder: Path, parts: Iterable[SyntheticModel]) -> None:
    """Write what is true of a model, cluster of faults by cluster, each on the grids of its own frame."""
    for kind in ("cutoffs", "blocks", "faults"):
        (folder / kind).mkdir(parents=True, exist_ok=True)
    rows = ["fault,side,block,s,x,y,z,throw"]
    faults: dict[str, str] = {}
    blocks: list[dict[str, object]] = []
    for part in parts:
        rows += _cutoff_rows(part, len(blocks))
        grid = part.frame.grid(0.5 * part.grid.step)
        xy = part.frame.inward(grid.nodes())
        for f in part.geology.faults:
            faults[f.name] = f"faults/{f.name}.irap"
            write_irap_ascii(folder / faults[f.name], grid, f.elevation_at(*f.coordinates(xy)))
        for signs in part.geology.blocks:
            file = f"blocks/{HORIZON}-{len(blocks)}.irap"
            write_irap_ascii(folder / file, grid, part.geology.horizon(signs, xy))
            sides = {f.name: sign for f, sign in zip(part.geology.faults, signs, strict=True)}
            blocks.append({"sides": sides, "file": file})
    cutoffs = f"cutoffs/{HORIZON}.csv"
    (folder / cutoffs).write_text("\n".join(rows) + "\n", encoding="utf-8")
    horizons = {HORIZON: {"cutoffs": cutoffs, "blocks": blocks}}
    index = {"schema": 1, "faults": faults, "horizons": horizons}
    (folder / "truth.json").write_text(json.dumps(index, indent=1) + "\n", encoding="utf-8")


def _cutoff_rows(part: SyntheticModel, first: int) -> list[str]:
    """Return the rows of the true cutoffs; the blocks of the part are counted from ``first``."""
    rows = []
    for c in part.cutoffs:
        name = part.geology.faults[c.fault].name
        label = f"{name},{'hanging' if c.side > 0 else 'foot'},{first + c.block}"
        table = np.column_stack([c.s, c.points, c.throw]).tolist()
        rows += [f"{label},{s:.6f},{x:.6f},{y:.6f},{z:.6f},{t:.6f}" for s, x, y, z, t in table]
    return rows
