"""A model written as a folder that is a valid input again."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.errors import OutputError
from graben.formats.irap import grid_surface, write_irap_ascii
from graben.formats.names import file_names
from graben.formats.numbers import rows_of_text
from graben.formats.tsurf_writer import Feature, in_convention, write_tsurf
from graben.model import Fault, GridGeometry, Horizon, Model
from graben.surface import Surface

_TRUTH = "truth"
_LISTS = ("horizons", "faults", "contacts")


def write_model(model: Model, folder: Path) -> Path:
    """Write a model: model.toml and a file for each surface, which read back to the bit.

    Faults become TSurf files. A horizon that is still the surface of its grid becomes an Irap ASCII grid,
    one fitted to points is written as its points, which say more than the surface; any other becomes a TSurf.
    The step is stated for both. The truth of a demo model is copied.

    Parameters
    ----------
    model : Model
        The model.
    folder : Path
        Made where it is missing; files of the same names are replaced.

    Returns
    -------
    Path
        The model.toml.
    """
    folder.mkdir(parents=True, exist_ok=True)
    stems = file_names(["model", *(s.name for s in model.surfaces)])[1:]
    count = len(model.horizons)
    horizons = [written_horizon(model, h, folder, s) for h, s in zip(model.horizons, stems, strict=False)]
    faults = [written_fault(model, f, folder, s) for f, s in zip(model.faults, stems[count:], strict=True)]
    return write_model_file(model, horizons, faults, folder)


def write_model_file(
    model: Model, horizons: Iterable[dict[str, Any]], faults: Iterable[dict[str, Any]], folder: Path
) -> Path:
    """Write model.toml with the settings of a model, and copy its truth where there is one.

    Parameters
    ----------
    model : Model
        The model.
    horizons, faults : iterable of dict
        The keys of each [[horizons]] and [[faults]]; those that are None are left out.
    folder : Path
        Where; their files are written there already.

    Raises
    ------
    OutputError
        When the folder lies inside the truth, which would then be copied into itself without end.
    """
    import tomli_w

    truth = None
    if model.truth is not None:
        truth = _TRUTH
        if folder.resolve().is_relative_to(model.truth.resolve()):
            raise OutputError(
                f"The output would lie inside {model.truth}, the truth of the model, which is copied along: "
                "choose another -o."
            )
        if model.truth.resolve() != (folder / _TRUTH).resolve():
            shutil.copytree(model.truth, folder / _TRUTH, dirs_exist_ok=True)
    head = {"name": model.name, "z": model.z, "unit": model.unit, "crs": model.crs, "truth": truth}
    tables = {
        "model": [_without_none(head)],
        "horizons": [_without_none(keys) for keys in horizons],
        "faults": [_without_none(keys) for keys in faults],
        "parameters": [model.parameters.model_dump(exclude_defaults=True)],
        "repair": [model.repair.model_dump(exclude_defaults=True)],
        "contacts": [{"faults": list(c.faults), "rule": c.rule} for c in model.contacts],
        "checks": [dict(model.checks)],
    }
    # Table by table: left to itself, tomli_w puts short lists of tables on one line.
    parts = [
        (f"[[{key}]]\n" if key in _LISTS else f"[{key}]\n") + tomli_w.dumps(entry)
        for key, entries in tables.items()
        for entry in entries
        if entry
    ]
    path = folder / "model.toml"
    path.write_text("\n".join(parts), encoding="utf-8", newline="\n")
    return path


def written_fault(model: Model, fault: Fault, folder: Path, stem: str) -> dict[str, Any]:
    """Write a fault as a TSurf file of its own and return the keys of its [[faults]]."""
    _write_surface(model, fault.surface, folder / f"{stem}.ts", "fault")
    return {"name": fault.name, "file": f"{stem}.ts", "gamma": fault.gamma}


def written_horizon(model: Model, horizon: Horizon, folder: Path, stem: str) -> dict[str, Any]:
    """Write the file of a horizon, as of :func:`write_model`, and return the keys of its [[horizons]]."""
    keys: dict[str, Any] = {"name": horizon.name}
    values = None if len(horizon.picks) else _grid_values(horizon)
    if horizon.grid is not None and values is not None:
        keys["file"] = f"{stem}.irap"
        write_irap_ascii(folder / keys["file"], horizon.grid, floats(values * model.z_factor))
    elif len(horizon.picks):
        keys["file"] = f"{stem}.csv"
        keys["step"] = horizon.step
        rows = rows_of_text(in_convention(horizon.picks, model.z))
        text = b"\n".join([b"X,Y,Z", *(row.replace(b" ", b",") for row in rows), b""])
        (folder / keys["file"]).write_bytes(text)
    else:
        keys["file"] = f"{stem}.ts"
        keys["step"] = horizon.step
        _write_surface(model, horizon.surface, folder / keys["file"], "top")
    if horizon.noise is not None:
        keys["noise"] = horizon.noise
    return keys


def _write_surface(model: Model, surface: Surface, path: Path, feature: Feature) -> None:
    write_tsurf(path, [surface], z=model.z, feature=feature, unit=model.unit, crs=model.crs)


def _grid_values(horizon: Horizon) -> FloatArray | None:
    """Return the elevations at the nodes of the horizon's grid, if its surface is that of the grid."""
    grid, surface = horizon.grid, horizon.surface
    if grid is None or grid.step != horizon.step or not np.isfinite(surface.vertices).all():
        return None
    place = _nearest_nodes(grid, surface.vertices)
    if place is None:
        return None
    values = np.full((grid.columns, grid.rows), np.nan)
    values[place[:, 0], place[:, 1]] = surface.vertices[:, 2]
    again = grid_surface(surface.name, grid, floats(values))
    same = np.array_equal(again.vertices, surface.vertices) and np.array_equal(
        again.triangles, surface.triangles
    )
    return floats(values) if same else None


def _nearest_nodes(grid: GridGeometry, vertices: FloatArray) -> IntArray | None:
    """Return the grid node next to each vertex, shape (n, 2); None if a vertex lies beside the grid."""
    a = np.radians(grid.rotation)
    x, y = vertices[:, 0] - grid.origin[0], vertices[:, 1] - grid.origin[1]
    i = np.rint((x * np.cos(a) + y * np.sin(a)) / grid.dx)
    j = np.rint((y * np.cos(a) - x * np.sin(a)) / grid.dy)
    if ((i < 0) | (i >= grid.columns) | (j < 0) | (j >= grid.rows)).any():
        return None
    return ints(np.stack([i, j], axis=1))


def _without_none(keys: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in keys.items() if value is not None}
