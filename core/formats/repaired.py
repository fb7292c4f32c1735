"""A repaired model written as a folder in which every file that repair did not touch is the input's own."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from graben.errors import InputError
from graben.formats.grids import read_grid
from graben.formats.irap import grid_surface
from graben.formats.kinds import SURFACES, Kind, kind_of
from graben.formats.meshes import read_surfaces
from graben.formats.names import file_names
from graben.formats.points import read_table
from graben.formats.stick_surface import sticks_surface
from graben.formats.sticks import read_sticks
from graben.formats.tsurf import mirrored
from graben.formats.tsurf_writer import in_convention
from graben.formats.writing import write_model_file, written_fault, written_horizon
from graben.model import Horizon, Model
from graben.surface import Surface

#: Names that the folder itself needs.
_TAKEN = ("model", "report", "truth")
#: Endings that copies keep: short and plain, so that any system takes them.
_ENDING = re.compile(r"\.[A-Za-z0-9]{1,8}")


def write_repaired(given: Model, repaired: Model, folder: Path) -> Path:
    """Write a repaired model: a valid input that reads back to the bit.

    The file of a surface that did not change is copied byte for byte, horizons as well, so that everything
    read from it stays the same. A fault that changed, or shares its file with one that did, becomes a TSurf
    of its own. Surfaces without a file are written as :func:`graben.formats.writing.write_model` does.

    Parameters
    ----------
    given : Model
        The input of the repair.
    repaired : Model
        Its result.
    folder : Path
        Made where it is missing; files of the same names are replaced.

    Returns
    -------
    Path
        The model.toml.
    """
    folder.mkdir(parents=True, exist_ok=True)
    surfaces = repaired.surfaces
    kept = _kept(given, repaired)
    sources = [_source(s) if s.name in kept else None for s in surfaces]
    # A file is copied once, however many surfaces it holds.
    wanted = list(dict.fromkeys(source or s.name for source, s in zip(sources, surfaces, strict=True)))
    named = file_names([*_TAKEN, *(w.stem if isinstance(w, Path) else w for w in wanted)])[len(_TAKEN) :]
    stems = dict(zip(wanted, named, strict=True))
    copies = {w: stem + _ending(w) for w, stem in stems.items() if isinstance(w, Path)}
    for source, name in copies.items():
        shutil.copyfile(source, folder / name)
    horizons, faults = [], []
    for horizon, file in zip(repaired.horizons, sources, strict=False):
        if file is None:
            horizons.append(written_horizon(repaired, horizon, folder, stems[horizon.name]))
        else:
            horizons.append(_horizon_keys(horizon, file, copies[file]))
    for fault, file in zip(repaired.faults, sources[len(horizons) :], strict=True):
        if file is None:
            faults.append(written_fault(repaired, fault, folder, stems[fault.name]))
        else:
            faults.append({"name": fault.name, "file": copies[file], "gamma": fault.gamma})
    names = {f.name for f in repaired.faults}
    contacts = tuple(c for c in repaired.contacts if names.issuperset(c.faults))
    return write_model_file(replace(repaired, contacts=contacts), horizons, faults, folder)


def _kept(given: Model, repaired: Model) -> set[str]:
    """Return the names of the surfaces whose files hold nothing but what did not change."""
    now = {s.name: s for s in repaired.surfaces}
    files: dict[Path, list[Surface]] = {}
    for surface in given.surfaces:
        source = _source(surface)
        if source is not None:
            files.setdefault(source, []).append(surface)
    horizons = {h.name: h for h in given.horizons}
    kept: set[str] = set()
    for source, own in files.items():
        if not all(s.name in now and _same(s, now[s.name]) for s in own):
            continue
        if all(_as_read(source, s, horizons.get(s.name), given) for s in own):
            kept.update(s.name for s in own)
    return kept


def _source(surface: Surface) -> Path | None:
    return None if surface.file is None else surface.file.resolve()


def _same(one: Surface, other: Surface) -> bool:
    """Return whether two surfaces have the same vertices, to the bit, and the same triangles."""
    alike = one.vertices.shape == other.vertices.shape and one.triangles.shape == other.triangles.shape
    return (
        alike
        and np.array_equal(one.vertices, other.vertices, equal_nan=True)
        and np.array_equal(one.triangles, other.triangles)
    )


def _as_read(source: Path, surface: Surface, horizon: Horizon | None, model: Model) -> bool:
    """Return whether a file gives this very surface: in Python a model can be altered after it was read."""
    try:
        if horizon is None:
            return any(_same(surface, s) for s in _faults_in(source, surface.name, model))
        return _horizon_as_read(source, horizon, model)
    except (InputError, OSError):
        return False


def _faults_in(source: Path, name: str, model: Model) -> Iterable[Surface]:
    kind = kind_of(source)
    if kind in SURFACES:
        objects = read_surfaces(source, kind)
        # Of several, the name says which is meant.
        chosen = objects if len(objects) == 1 else [o for o in objects if o.surface.name == name]
        return [o.upward(model.z) for o in chosen]
    sticks = read_sticks(source)
    return [sticks_surface(name, [mirrored(s) for s in sticks] if model.z == "depth" else sticks)]


def _horizon_as_read(source: Path, horizon: Horizon, model: Model) -> bool:
    kind = kind_of(source)
    if kind is Kind.TSURF:
        return any(_same(horizon.surface, s) for s in _faults_in(source, horizon.name, model))
    if kind is Kind.TABLE:
        picks = in_convention(read_table(source, ("x", "y", "z"))[0], model.z)
        return np.array_equal(picks, horizon.picks, equal_nan=True)
    grid, values = read_grid(source, kind)
    surface = grid_surface(horizon.name, grid, values if model.z == "elevation" else -values)
    return grid == horizon.grid and _same(surface, horizon.surface)


def _horizon_keys(horizon: Horizon, source: Path, file: str) -> dict[str, Any]:
    """Return the keys of a horizon whose file was copied; a grid states its own step."""
    step = horizon.step if kind_of(source) in (Kind.TSURF, Kind.TABLE) else None
    return {"name": horizon.name, "file": file, "step": step, "noise": horizon.noise}


def _ending(source: Path) -> str:
    return source.suffix if _ENDING.fullmatch(source.suffix) else ""
