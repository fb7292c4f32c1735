"""Everything a run writes into its folder."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from graben.arrays import FloatArray, floats
from graben.beside import shared
from graben.finding_table import findings_table
from graben.formats.geojson import write_geojson
from graben.formats.irap import write_irap_ascii
from graben.formats.names import file_names
from graben.formats.pol import write_pol
from graben.formats.tables import write_cutoffs
from graben.formats.tsurf_writer import write_tsurf
from graben.formats.vtp import write_vtp
from graben.formats.writing import write_model
from graben.modeling.products import FaultPolygon, Opening, parts, polygons_of, regular_grid
from graben.modeling.scoring import true_throws
from graben.modeling.throws import along
from graben.reports.html import Truth, report_html, run_seen
from graben.reports.json_report import as_text, run_report
from graben.reports.model_files import ModelFiles, write_model_files
from graben.stages import Progress, quiet
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

#: What the array ``side`` holds.
_SIDES = "1 hanging wall, -1 footwall, 2 junction, 0 off the cut"
#: Nodes of all horizons from which on two cores share the writing.
_WORTH = 200_000


def write_run(result: RunResult, folder: Path, progress: Progress = quiet) -> RunResult:
    """Write report.html, report.json, the repaired model and the files of every horizon.

    Parameters
    ----------
    result : RunResult
        A finished run.
    folder : Path
        Where to write; made where it is missing, files of the same names are replaced.
    progress : callable, optional
        Called with the stage and what it works on.

    Returns
    -------
    RunResult
        The same with the seconds of writing in its timings, but for those of report.json; report.html shows
        what was known before it.
    """
    begin = time.perf_counter()
    folder.mkdir(parents=True, exist_ok=True)
    stems = file_names([h.name for h in result.horizons])
    grids = {h.name: regular_grid(h) for h in result.horizons if h.horizon.grid is not None}
    # the longest first: two cores share them where that is worth it
    tasks: list[Callable[[], Any]] = [
        partial(_told, progress, "tables", partial(write_tables, result, folder)),
        *(
            partial(
                _told,
                progress,
                f"files of {h.name}",
                partial(write_horizon, h, result.repaired, folder, stem, grids.get(h.name)),
            )
            for h, stem in zip(result.horizons, stems, strict=True)
        ),
        partial(_told, progress, "3D view", partial(run_seen, result)),
        partial(_told, progress, "model", partial(_write_whole, result, folder, grids)),
    ]
    large = sum(len(h.first) for h in result.horizons) > _WORTH
    _, *written, seen, whole = shared(tasks) if large else [task() for task in tasks]
    files = {h.name: own for h, own in zip(result.horizons, written, strict=True)}
    progress("write", "pictures of the report")
    made = f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC"
    timed = _timed(result, begin)
    page = report_html(timed, files, _truth(result), whole, tuple(_TABLES), seen, made)
    (folder / "report.html").write_text(page, encoding="utf-8", newline="\n")
    timed = _timed(result, begin)
    text = as_text(run_report(timed, files, whole))
    (folder / "report.json").write_text(text, encoding="utf-8", newline="\n")
    return timed


def _told(progress: Progress, what: str, task: Callable[[], Any]) -> Any:
    """Tell what is written, then write it."""
    progress("write", what)
    return task()


def _timed(result: RunResult, begin: float) -> RunResult:
    """Return the result with the seconds of writing so far, which began at ``begin``, in its timings."""
    seconds = time.perf_counter() - begin
    total = result.timings.get("total", 0.0) + seconds
    return replace(result, timings={**result.timings, "write": seconds, "total": total})


def _write_whole(result: RunResult, folder: Path, grids: Mapping[str, FloatArray]) -> ModelFiles:
    """Write the repaired model, and the files that hold the whole model at once."""
    write_model(result.repaired, folder / "model")
    return write_model_files(result, folder, grids)


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
    notes = {"side": _SIDES, **({} if model.crs is None else {"crs": model.crs})}
    target = folder / files["vtp"]
    write_vtp(target, result.surface, z=model.z, arrays=arrays, unit=model.unit, notes=notes)
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
        (p.shape, {"fault": p.fault, "horizon": result.name, "piece": p.piece, "kind": str(p.kind), **own})
        for p, own in zip(found, _largest(result, found, model.crs), strict=True)
    ]
    write_geojson(folder / files["polygons"], features, z=model.z, crs=model.crs)
    rings = [floats(ring.coords) for p in found for ring in (p.shape.exterior, *p.shape.interiors)]
    write_pol(folder / files["pol"], rings, z=model.z)


def _largest(
    result: HorizonResult, polygons: Sequence[FaultPolygon], crs: str | None
) -> Iterator[dict[str, Any]]:
    """Yield the largest throw and heave, with their signs, of the piece that each polygon belongs to.

    Those of the part of the piece that is open, or overlaps, as the polygon is; and the coordinate system.
    """
    pieces = {name: [c for c in result.cutoffs if c.fault == name] for name in result.graph_faults}
    for polygon in polygons:
        cutoff = pieces[polygon.fault][polygon.piece - 1]
        alike = cutoff.heave > 0 if polygon.kind is Opening.GAP else cutoff.heave < 0
        at = np.flatnonzero(alike) if alike.any() else np.arange(len(cutoff.s))
        throw, heave = (
            float(values[at][np.abs(values[at]).argmax()]) for values in (cutoff.throw, cutoff.heave)
        )
        yield {"throw": throw, "heave": heave, **({} if crs is None else {"crs": crs})}
