"""Everything a run writes into its folder."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from graben.arrays import FloatArray, floats
from graben.beside import beside
from graben.finding_table import findings_table
from graben.formats.geojson import write_geojson
from graben.formats.irap import write_irap_ascii
from graben.formats.names import file_names
from graben.formats.pol import write_pol
from graben.formats.tables import write_cutoffs
from graben.formats.tsurf_writer import write_tsurf
from graben.formats.vtp import write_vtp
from graben.formats.writing import write_model
from graben.modeling.products import parts, polygons_of, regular_grid
from graben.modeling.scoring import true_throws
from graben.modeling.throws import along
from graben.reports.html import Truth, report_html
from graben.reports.json_report import as_text, run_report
from graben.reports.model_files import write_model_files
from graben.tables import (
    along_columns,
    doubts_table,
    iterations_table,
    masked_table,
    misfit_table,
    throws_table,
)

if TYPE_CHECKING:
    import pandas

    from graben.model import Model
    from graben.modeling.results import HorizonResult
    from graben.pipeline import RunResult

#: Nodes of all horizons from which on two cores share the writing.
_WORTH = 200_000


def write_run(result: RunResult, folder: Path) -> RunResult:
    """Write report.html, report.json, the repaired model and the files of every horizon.

    Parameters
    ----------
    result : RunResult
        A finished run.
    folder : Path
        Where to write; made where it is missing, files of the same names are replaced.

    Returns
    -------
    RunResult
        The same with the seconds of writing in its timings, but for those of the two reports' last step.
    """
    begin = time.perf_counter()
    folder.mkdir(parents=True, exist_ok=True)
    write_model(result.repaired, folder / "model")
    tables: Callable[[], None] = partial(write_tables, result, folder)
    if sum(len(h.first) for h in result.horizons) > _WORTH:
        tables = beside(tables)
    stems = file_names([h.name for h in result.horizons])
    grids = {h.name: regular_grid(h) for h in result.horizons if h.horizon.grid is not None}
    files = {
        h.name: write_horizon(h, result.repaired, folder, stem, grids.get(h.name))
        for h, stem in zip(result.horizons, stems, strict=True)
    }
    whole = write_model_files(result, folder, grids)
    tables()
    seconds = time.perf_counter() - begin
    total = result.timings.get("total", 0.0) + seconds
    timed = replace(result, timings={**result.timings, "write": seconds, "total": total})
    (folder / "report.html").write_text(
        report_html(timed, files, _truth(result), whole, tuple(_TABLES)), encoding="utf-8", newline="\n"
    )
    (folder / "report.json").write_text(
        as_text(run_report(timed, files, whole)), encoding="utf-8", newline="\n"
    )
    return timed


def _truth(result: RunResult) -> Truth:
    """Return the true throws of the horizons that were scored."""
    folder = result.model.truth
    if folder is None:
        return {}
    scored = [h for h in result.horizons if h.score is not None]
    return {h.name: true_throws(folder, h, result.model.faults) for h in scored}


def write_tables(result: RunResult, folder: Path) -> None:
    """Write the tables of a run into ``folder``/tables, as CSV files with z in the model's convention."""
    (folder / "tables").mkdir(parents=True, exist_ok=True)
    for name, table in _TABLES.items():
        found = table(result)
        if "z" in found:
            found["z"] = found["z"] * result.model.z_factor
        text = found.to_csv(index=False, lineterminator="\n")
        (folder / "tables" / f"{name}.csv").write_text(text, encoding="utf-8", newline="\n")


_TABLES: dict[str, Callable[[RunResult], pandas.DataFrame]] = {
    "throws": throws_table,
    "doubts": doubts_table,
    "misfit": misfit_table,
    "input": masked_table,
    "iterations": iterations_table,
    "findings": lambda result: findings_table(result.after),
}


def write_horizon(
    result: HorizonResult, model: Model, folder: Path, stem: str, heights: FloatArray | None
) -> Mapping[str, str]:
    """Write the files of one horizon and return what each is -> its path relative to ``folder``.

    Parameters
    ----------
    result : HorizonResult
        The rebuilt horizon.
    model : Model
        The model it was rebuilt from: its faults, the sign of z, the unit and the coordinate system.
    folder : Path
        The run's folder; its subfolders are made where they are missing.
    stem : str
        The files' name without folder and ending.
    heights : (columns, rows) array or None
        Elevations on its regular grid; None for a horizon without one.
    """
    files = {
        "surface": f"horizons/{stem}.ts",
        "vtp": f"horizons/{stem}.vtp",
        "grid": f"horizons/{stem}.irap",
        "cutoffs": f"cutoffs/{stem}.csv",
        "polygons": f"polygons/{stem}.geojson",
        "pol": f"polygons/{stem}.pol",
    }
    divided = parts(result)
    if len(divided) > 1:
        files |= {f"part {label}": f"parts/{stem}-{label}.ts" for label, _ in divided}
    for path in files.values():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
    arrays = {
        "subdomain": result.subdomain,
        "fixed": result.fixed.astype(np.int64),
        "side": result.side,
    }
    write_tsurf(
        folder / files["surface"],
        [result.surface],
        z=model.z,
        feature="top",
        unit=model.unit,
        crs=model.crs,
        properties=arrays,
    )
    write_vtp(folder / files["vtp"], result.surface, z=model.z, arrays=arrays)
    if result.horizon.grid is None or heights is None:
        del files["grid"]
    else:
        write_irap_ascii(folder / files["grid"], result.horizon.grid, floats(heights * model.z_factor))
    for label, part in divided if len(divided) > 1 else ():
        place = folder / files[f"part {label}"]
        write_tsurf(place, [part], z=model.z, feature="top", unit=model.unit, crs=model.crs)
    lines = along(result, [f.surface for f in model.faults])
    more = along_columns(lines, model.tolerance)
    write_cutoffs(folder / files["cutoffs"], result.cutoffs, z=model.z, more=more)
    _write_polygons(result, model, folder, files)
    return files


def _write_polygons(result: HorizonResult, model: Model, folder: Path, files: Mapping[str, str]) -> None:
    """Write the fault polygons of a horizon, in the same order in both files."""
    found = polygons_of(result)
    features = [
        (p.shape, {"fault": p.fault, "horizon": result.name, "piece": p.piece, "kind": str(p.kind)})
        for p in found
    ]
    write_geojson(folder / files["polygons"], features, z=model.z, crs=model.crs)
    rings = [floats(ring.coords) for p in found for ring in (p.shape.exterior, *p.shape.interiors)]
    write_pol(folder / files["pol"], rings, z=model.z)
