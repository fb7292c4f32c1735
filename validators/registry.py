"""The checks in the order of the table in which findings are listed."""

from __future__ import annotations

from graben.validators import (
    acyclic,
    anchored,
    degenerate,
    duplicate,
    finite,
    functional,
    horizon,
    junction,
    junction_values,
    manifold,
    min_dip,
    near_miss,
    oriented,
    pairwise_connected,
    self_intersection,
    simplicial_complex,
    strongly_connected,
    trace,
    z_monotone,
)
from graben.validators.context import Check

#: Every check, in the order in which findings are listed.
CHECKS: tuple[Check, ...] = (
    finite.CHECK,
    degenerate.CHECK,
    duplicate.CHECK,
    manifold.CHECK,
    oriented.CHECK,
    strongly_connected.CHECK,
    self_intersection.CHECK,
    functional.CHECK,
    z_monotone.CHECK,
    min_dip.CHECK,
    simplicial_complex.CHECK,
    pairwise_connected.CHECK,
    near_miss.CHECK,
    horizon.CHECK,
    trace.CHECK,
    junction.CHECK,
    junction_values.CHECK,
    acyclic.CHECK,
    anchored.CHECK,
)


def known_ids() -> tuple[str, ...]:
    """Return the ids of all checks, in order.

    >>> known_ids()[0]
    'finite'
    """
    return tuple(check.id for check in CHECKS)


def find(check_id: str) -> Check:
    """Return the check with this id; KeyError where there is none."""
    for check in CHECKS:
        if check.id == check_id:
            return check
    raise KeyError(check_id)
