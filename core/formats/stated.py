"""What a file states of its numbers: units of length, and whether the sign of z."""

from __future__ import annotations

import re
from pathlib import Path

from graben.formats.kinds import Kind
from graben.formats.points import header_units
from graben.formats.text import load_bytes

_WORD = r'("[^"\r\n]*"|[^\s"]+)'
_AXIS_UNIT = re.compile(rf"^[ \t]*AXIS_UNIT[ \t]+{_WORD}[ \t]*{_WORD}[ \t]*{_WORD}".encode(), re.MULTILINE)
_ZPOSITIVE = re.compile(rb"^[ \t]*ZPOSITIVE[ \t]", re.MULTILINE)
#: How files write the units that model.toml knows; small letters alone. A US survey foot is a foot to 2e-6.
_SPELLINGS = {
    "m": ("m", "metre", "metres", "meter", "meters"),
    "ft": ("ft", "foot", "feet", "ftus", "usft", "ftussurvey"),
}


def stated_units(path: Path, kind: Kind) -> tuple[str, ...]:
    """Return which of the units of length "m" and "ft" a file states for its axes.

    A GOCAD TSurf states them in AXIS_UNIT, a table in its header behind the names of columns, as in
    "TVDSS (ft)". Other kinds of files state none, and what is no length (ms) is passed over.

    Parameters
    ----------
    path : Path
        The file.
    kind : Kind
        What it is, as :func:`graben.formats.kinds.kind_of` says.
    """
    if kind is Kind.TSURF:
        axes = _AXIS_UNIT.findall(load_bytes(path))
        return _known([word.decode("latin-1") for words in axes for word in words])
    return _known(header_units(path)) if kind in (Kind.TABLE, Kind.STICKS) else ()


def states_sign(path: Path, kind: Kind) -> bool:
    """Return whether a file states the sign of z, as a GOCAD TSurf does with ZPOSITIVE."""
    return kind is Kind.TSURF and _ZPOSITIVE.search(load_bytes(path)) is not None


def _known(words: list[str]) -> tuple[str, ...]:
    """Return those units of model.toml that words stand for, each once."""
    plain = {"".join(c for c in word.lower() if c.isalpha()) for word in words}
    return tuple(unit for unit, spellings in _SPELLINGS.items() if plain.intersection(spellings))
