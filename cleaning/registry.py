"""The repairs in the order in which they are tried."""

from __future__ import annotations

from graben.cleaning import (
    components,
    contacts,
    cycles,
    holes,
    margin,
    monotone,
    nonmanifold,
    orient,
    pieces,
    separate,
    slivers,
    stitch,
    t_vertices,
    trace_ends,
    uncross,
    unfit,
    unfold,
    weld,
)
from graben.cleaning.repairing import Repair

#: Every repair: what others build on comes first. A surface by itself, then what faults do to each other,
#: then what they do to horizons.
REPAIRS: tuple[Repair, ...] = (
    unfit.REPAIR,
    weld.REPAIR,
    stitch.REPAIR,
    t_vertices.REPAIR,
    nonmanifold.REPAIR,
    slivers.REPAIR,
    orient.REPAIR,
    uncross.REPAIR,
    components.REPAIR,
    holes.REPAIR,
    unfold.REPAIR,
    monotone.REPAIR,
    separate.REPAIR,
    pieces.REPAIR,
    contacts.REPAIR,
    margin.REPAIR,
    trace_ends.REPAIR,
    cycles.REPAIR,
)


def known_repairs() -> tuple[str, ...]:
    """Return the ids that `skip` in [repair] may name."""
    return tuple(repair.id for repair in REPAIRS)


def answered_checks() -> frozenset[str]:
    """Return the ids of the checks whose findings some repair answers; `cycles` only says what to do."""
    return frozenset(check for repair in REPAIRS if repair is not cycles.REPAIR for check in repair.checks)
