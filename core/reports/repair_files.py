"""Everything a repair writes into its folder."""

from __future__ import annotations

import time
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from graben.formats.blocks import TABLE, write_blocks
from graben.formats.repaired import write_repaired
from graben.reports.json_report import as_text
from graben.reports.repair_html import repair_html
from graben.reports.repair_json import repair_report
from graben.reports.repair_moves import fault_changes

if TYPE_CHECKING:
    from graben.model import Model
    from graben.repairs import RepairResult
    from graben.reports.repair_blocks import BlocksMade


def write_repair(
    result: RepairResult, folder: Path, blocks: BlocksMade | None = None, *, began: float | None = None
) -> None:
    """Write model.toml with the files of its surfaces, report.json, report.html and the fault blocks.

    Parameters
    ----------
    result : RepairResult
        A finished repair.
    folder : Path
        Where to write; made where it is missing, files of the same names are replaced.
    blocks : BlocksMade, optional
        Of :func:`graben.reports.repair_blocks.blocks_of`; they go into a folder of their own.
    began : float, optional
        When the work began, by ``time.perf_counter``, so that its reading counts in the total.
    """
    begin = time.perf_counter()
    write_repaired(result.input, result.model, folder)
    if blocks is not None:
        blocks = replace(blocks, folder=_with_blocks(blocks, result.model, folder))
    changes = fault_changes(result)
    page = repair_html(result, changes, files=True, blocks=blocks)
    (folder / "report.html").write_text(page, encoding="utf-8", newline="\n")
    writing = time.perf_counter() - begin
    total = result.seconds + writing if began is None else time.perf_counter() - began
    timings = {"repair": result.seconds, "write": writing, "total": total}
    text = as_text(repair_report(result, changes, timings, blocks))
    (folder / "report.json").write_text(text, encoding="utf-8", newline="\n")


def _with_blocks(made: BlocksMade, model: Model, folder: Path) -> str:
    """Write the blocks into a folder inside a folder; return its name."""
    # The file of a surface may have the same name and no ending.
    names = (TABLE if n == 1 else f"{TABLE}-{n}" for n in count(1))
    name = next(n for n in names if not (folder / n).exists())
    if made.blocks:
        write_blocks(made.blocks, folder / name, z=model.z, unit=model.unit, crs=model.crs)
    return name
