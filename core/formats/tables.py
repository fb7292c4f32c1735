"""Cutoff tables (CSV)."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from itertools import repeat
from pathlib import Path
from typing import Any, Protocol

from graben.arrays import FloatArray
from graben.formats.tsurf import Sign
from graben.formats.tsurf_writer import in_convention

COLUMNS = ("fault", "side", "s", "x", "y", "z", "throw", "heave")
#: Further columns: for each cutoff the values of each pair of rows, (hanging, foot).
More = Mapping[str, Sequence[Sequence[tuple[Any, Any]]]]


class CutoffLine(Protocol):
    """A pair of cutoff lines: shapes (k,) for s, throw and heave, (k, 3) for hanging and foot."""

    @property
    def fault(self) -> str:
        """Name of the fault."""

    @property
    def s(self) -> FloatArray:
        """Distance along the first trace in plan."""

    @property
    def hanging(self) -> FloatArray:
        """Hanging-wall cutoff, elevations."""

    @property
    def foot(self) -> FloatArray:
        """Footwall cutoff, elevations."""

    @property
    def throw(self) -> FloatArray:
        """Elevation of foot minus elevation of hanging."""

    @property
    def heave(self) -> FloatArray:
        """Opening in the local direction of dip."""


def write_cutoffs(
    path: Path, cutoffs: Iterable[CutoffLine], *, z: Sign = "elevation", more: More | None = None
) -> None:
    """Write cutoff lines: rows in pairs (hanging, foot) with the same s, throw and heave.

    Names are written as they are, also those that a spreadsheet would take for a formula (``=``, ``+``, ``-``
    or ``@`` at the beginning): it does so with quoted text as well, and with a mark before it a name would be
    another one. Import the column as text there.

    Parameters
    ----------
    path : Path
        The file.
    cutoffs : iterable of CutoffLine
        Elevations; the column z is written in the convention of ``z``, throw keeps its sign.
    z : "elevation" or "depth"
        How the file counts z.
    more : mapping, optional
        Columns that follow, by their names: for each cutoff a pair of values for each pair of rows.
    """
    further = dict(more or {})
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow((*COLUMNS, *further))
        for k, line in enumerate(cutoffs):
            hanging, foot = in_convention(line.hanging, z).tolist(), in_convention(line.foot, z).tolist()
            shared = zip(line.s.tolist(), line.throw.tolist(), line.heave.tolist(), strict=True)
            pairs = zip(*(values[k] for values in further.values()), strict=True) if further else repeat(())
            for upper, lower, (s, throw, heave), pair in zip(
                hanging, foot, shared, pairs, strict=bool(further)
            ):
                writer.writerow((line.fault, "hanging", s, *upper, throw, heave, *(v for v, _ in pair)))
                writer.writerow((line.fault, "foot", s, *lower, throw, heave, *(v for _, v in pair)))
