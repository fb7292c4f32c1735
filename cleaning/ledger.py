"""The ledger: every change a repair made, with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RepairAction:
    """One change.

    Parameters
    ----------
    action : str
        Id of the repair.
    check : str
        Id of the check whose finding it answers.
    objects : tuple of str
        Names of the surfaces changed.
    count : int
        How many elements were changed.
    max_move : float
        The largest distance a vertex moved, model units.
    place : (x, y, z) or None
        One place of the change, elevation.
    reason : str
        One sentence.
    """

    action: str
    check: str
    objects: tuple[str, ...]
    count: int
    max_move: float
    place: tuple[float, float, float] | None
    reason: str
