"""The repairs in the order in which they are tried."""

from __future__ import annotations

from graben.cleaning import contacts, orient, weld
from graben.cleaning.repairing import Repair

#: Every repair: what others build on comes first.
REPAIRS: tuple[Repair, ...] = (weld.REPAIR, orient.REPAIR, contacts.REPAIR)


def known_repairs() -> tuple[str, ...]:
    """Return the ids that `skip` in [repair] may name."""
    return tuple(repair.id for repair in REPAIRS)
