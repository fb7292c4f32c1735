"""What repair did to the faults as pages show it: a row for each, and where each came from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from graben.repairs import RepairResult
from graben.reports.check_parts import sized, told
from graben.reports.repair_moves import FaultChange, fault_changes
from graben.reports.style import Frame

if TYPE_CHECKING:
    from graben.cleaning.ledger import RepairAction
    from graben.pipeline import RunResult


def fault_row(change: FaultChange, changed: Sequence[FaultChange], frame: Frame) -> dict[str, Any]:
    """Return the row of a fault: before and after in pairs, then lengths.

    Parameters
    ----------
    change : FaultChange
        The fault.
    changed : sequence of FaultChange
        Every fault that changed.
    frame : Frame
        Unit.
    """
    square = f"{frame.unit}²" if frame.unit else ""
    sides = []
    for m in (change.before, change.after):
        if m is None:
            sides.append(("left out", *[""] * 4))
            continue
        sides.append(
            (
                f"{m.triangles:,}",
                sized(m.area, square),
                f"{m.dip:.1f}°",
                frame.length(m.rim),
                f"{m.components}",
            )
        )
    lengths = (change.largest_move, change.mean_move, change.extended, change.cut_back)
    return {
        "name": told(change.name),
        "anchor": "",
        "origin": told(origin(change, changed)),
        "cells": list(zip(*sides, strict=True)),
        "lengths": [frame.length(value) if value > 0 else "–" for value in lengths],
    }


def origin(change: FaultChange, changed: Sequence[FaultChange]) -> str:
    """Return in words what became of a fault of another name, or nothing."""
    if change.after is None:
        return "left out"
    parts = [c for c in changed if c.source == change.source and c.after is not None]
    if len(parts) > 1:
        return f"one of {len(parts)} parts of {change.source}"
    return "" if change.name == change.source else f"from {change.source}"


def run_changes(result: RunResult) -> tuple[FaultChange, ...]:
    """Return what became of each fault in a run; see :func:`graben.reports.repair_moves.fault_changes`.

    Empty where the ledger does not tell where a fault came from.
    """
    given = [f.name for f in result.model.faults]
    lineage = lineage_of(result.repairs, given)
    known = {name: source for name, source in lineage.items() if source in set(given)}
    if not {f.name for f in result.repaired.faults} <= known.keys():
        return ()
    done = RepairResult(
        result.model,
        result.repaired,
        result.repairs,
        result.left,
        result.before,
        result.after,
        MappingProxyType(known),
    )
    return fault_changes(done)


def lineage_of(actions: Sequence[RepairAction], given: Sequence[str]) -> Mapping[str, str]:
    """Return the fault of the input that each name of a ledger came from.

    A name that a change brings came from the fault that it replaced; of several, from that whose name it
    goes on from.
    """
    lineage = {name: name for name in given}
    for action in actions:
        old = [m.name for m in action.before if m.name in lineage]
        for new in action.after:
            if new.name not in lineage and old:
                nearest = max(old, key=lambda name: (new.name.startswith(name), len(name)))
                lineage[new.name] = lineage[nearest]
    return MappingProxyType(lineage)
