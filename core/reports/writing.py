"""Everything a run writes into its folder."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from graben.arrays import floats
from graben.formats.geojson import write_geojson
from graben.formats.irap import write_irap_ascii
from graben.formats.names import file_names
from graben.formats.tables import write_cutoffs
from graben.formats.tsurf_writer import write_tsurf
from graben.formats.vtp import write_vtp
from graben.formats.writing import write_model
from graben.modeling.products import fault_polygons, regular_grid
from graben.modeling.scoring import true_throws
from graben.reports.html import Truth, report_html
from graben.reports.json_report import as_text, run_report

if TYPE_CHECKING:
    from graben.model import Model
    from graben.modeling.results import HorizonResult
    from graben.pipeline import RunResult


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
    stems = file_names([h.name for h in result.horizons])
    files = {
        h.name: write_horizon(h, result.model, folder, stem)
        for h, stem in zip(result.horizons, stems, strict=True)
    }
    seconds = time.perf_counter() - begin
    total = result.timings.get("total", 0.0) + seconds
    timed = replace(result, timings={**result.timings, "write": seconds, "total": total})
    (folder / "report.html").write_text(
        report_html(timed, files, _truth(result)), encoding="utf-8", newline="\n"
    )
    (folder / "report.json").write_text(as_text(run_report(timed, files)), encoding="utf-8", newline="\n")
    return timed


def _truth(result: RunResult) -> Truth:
    """Return the true throws of the horizons that were scored."""
    folder = result.model.truth
    if folder is None:
        return {}
    scored = [h for h in result.horizons if h.score is not None]
    return {h.name: true_throws(folder, h, result.model.faults) for h in scored}


def write_horizon(result: HorizonResult, model: Model, folder: Path, stem: str) -> Mapping[str, str]:
    """Write the files of one horizon and return what each is -> its path relative to ``folder``.

    Parameters
    ----------
    result : HorizonResult
        The rebuilt horizon.
    model : Model
        For the convention of z, the unit and the coordinate system.
    folder : Path
        The run's folder; its subfolders are made where they are missing.
    stem : str
        The files' name without folder and ending.
    """
    files = {
        "surface": f"horizons/{stem}.ts",
        "vtp": f"horizons/{stem}.vtp",
        "grid": f"horizons/{stem}.irap",
        "cutoffs": f"cutoffs/{stem}.csv",
        "polygons": f"polygons/{stem}.geojson",
    }
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
    if result.horizon.grid is None:
        del files["grid"]
    else:
        values = floats(regular_grid(result) * model.z_factor)
        write_irap_ascii(folder / files["grid"], result.horizon.grid, values)
    write_cutoffs(folder / files["cutoffs"], result.cutoffs, z=model.z)
    polygons = [(shape, {"fault": name, "horizon": result.name}) for name, shape in fault_polygons(result)]
    write_geojson(folder / files["polygons"], polygons, z=model.z, crs=model.crs)
    return files
