"""The files of a run that hold the whole model at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from graben.arrays import FloatArray
from graben.formats.resqml import GriddedHorizon, obstacle, write_epc
from graben.formats.vtu import write_vtu
from graben.surface import Surface

if TYPE_CHECKING:
    from graben.pipeline import RunResult

_FAULTS = "model/faults.vtu"
_PACKAGE, _ARRAYS = "model.epc", "model.h5"


@dataclass(frozen=True)
class ModelFiles:
    """What was written for the whole model, and why the rest was not.

    Parameters
    ----------
    files : mapping of str to str
        What a file is -> its path relative to the folder of the run.
    not_written : mapping of str to str
        What it would be -> the reason, with the mend.
    """

    files: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    not_written: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))


def write_model_files(result: RunResult, folder: Path, grids: Mapping[str, FloatArray]) -> ModelFiles:
    """Write the repaired faults as one VTU, and faults and rebuilt horizons as a RESQML package.

    Parameters
    ----------
    result : RunResult
        A finished run.
    folder : Path
        Its folder, in which ``model`` is written already.
    grids : mapping of str to (columns, rows) array
        Elevations of the rebuilt horizons that have a regular grid, on its nodes, by their names.

    Returns
    -------
    ModelFiles
        What was written; the package is left out where resqpy is missing or the model has no unit.
    """
    model = result.repaired
    faults = [_fit(f.surface) for f in model.faults]
    files = {"model": "model/model.toml"}
    if faults:
        files["faults"] = _FAULTS
        write_vtu(folder / _FAULTS, faults, z=model.z, unit=model.unit, crs=model.crs)
    reason = obstacle(model.unit)
    if reason is not None:
        return ModelFiles(files, {"resqml": reason})
    horizons = [
        GriddedHorizon(h.surface, h.horizon.grid, grids.get(h.name), h.cutoffs) for h in result.horizons
    ]
    write_epc(
        folder / _PACKAGE,
        horizons,
        faults,
        origin=model.local_origin(),
        z=model.z,
        unit=model.unit,
        crs=model.crs,
    )
    return ModelFiles({**files, "resqml": _PACKAGE, "resqml_arrays": _ARRAYS}, {})


def _fit(surface: Surface) -> Surface:
    """Return a surface without the triangles that name no vertex, which the formats cannot hold."""
    there = ((surface.triangles >= 0) & (surface.triangles < len(surface.vertices))).all(axis=1)
    return surface if there.all() else Surface(surface.name, surface.vertices, surface.triangles[there])
