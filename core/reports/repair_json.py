"""report.json of a repair, strictly valid JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from graben.reports.json_report import left_entry, repair_entry, strict
from graben.reports.repair_blocks import BlocksMade, blocks_entry

if TYPE_CHECKING:
    from graben.repairs import RepairResult
    from graben.reports.repair_moves import FaultChange


def repair_report(
    result: RepairResult,
    changes: Sequence[FaultChange],
    timings: Mapping[str, float],
    blocks: BlocksMade | None = None,
) -> dict[str, Any]:
    """Return report.json of a repair as plain dictionaries, lists, numbers and strings.

    Parameters
    ----------
    result : RepairResult
        A finished repair.
    changes : sequence of FaultChange
        Of :func:`graben.reports.repair_moves.fault_changes`.
    timings : mapping of str to float
        Seconds of each stage.
    blocks : BlocksMade, optional
        The fault blocks, where they were asked for.

    Returns
    -------
    dict
        As the schema of report.json says; z counts as in the model file. Numbers that are not finite are
        None. Only ``timings`` and ``peak_memory_mb`` differ between two repairs of the same input.
    """
    factor = result.input.z_factor
    plain: dict[str, Any] = strict(
        {
            "schema": 1,
            "version": version("graben"),
            "model": result.input.name,
            "before": result.before.as_dict(),
            "repairs": [repair_entry(action, factor) for action in result.actions],
            "after": result.after.as_dict(),
            "left": [left_entry(left, factor) for left in result.left],
            "faults": [_fault(change) for change in changes],
            **({} if blocks is None else {"blocks": blocks_entry(blocks, result.model)}),
            "timings": dict(timings),
            "peak_memory_mb": result.peak_memory_mb,
        }
    )
    return plain


def _fault(change: FaultChange) -> dict[str, Any]:
    return {
        "name": change.name,
        "from": change.source,
        "changed": change.changed,
        "before": asdict(change.before),
        "after": None if change.after is None else asdict(change.after),
        "largest_move": change.largest_move,
        "mean_move": change.mean_move,
        "extended_by": change.extended,
        "cut_back_by": change.cut_back,
    }
