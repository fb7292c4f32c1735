"""The folder of a run or repair from Python: what `graben run` and `graben repair` write."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from graben.output import whole_folder
from graben.pipeline import RunResult
from graben.reports.repair_files import write_repair
from graben.reports.writing import write_run

if TYPE_CHECKING:
    from graben.repairs import RepairResult


def write(result: RunResult | RepairResult, folder: str | os.PathLike[str]) -> Path:
    """Write a run or a repair into a folder, as `graben run` and `graben repair` do with ``-o``.

    The folder appears whole or not at all.

    Parameters
    ----------
    result : RunResult or RepairResult
        Of :func:`graben.build` or :func:`graben.repair`.
    folder : str or path
        Absent or empty.

    Returns
    -------
    Path
        The report in it.

    Raises
    ------
    OutputError
        When the folder holds something or cannot be written.
    """
    target = Path(folder)
    with whole_folder(target) as partial:
        if isinstance(result, RunResult):
            write_run(result, partial)
        else:
            write_repair(result, partial)
    return target / "report.html"
