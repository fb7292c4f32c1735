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


def answered_checks() -> dict[str, tuple[str, ...]]:
    """Return the repairs that answer each check, by its id; `cycles` only says what to do."""
    answering = [repair for repair in REPAIRS if repair is not cycles.REPAIR]
    checks = dict.fromkeys(check for repair in answering for check in repair.checks)
    return {check: tuple(r.id for r in answering if check in r.checks) for check in checks}
