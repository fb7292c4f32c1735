"""What the files of a model state of their numbers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from graben.formats.kinds import kind_of
from graben.formats.stated import stated_units, states_sign
from graben.model import Statement
from graben.surface import Surface
from graben.validators.finite import usable


def statements(surfaces: Sequence[Surface]) -> tuple[Statement, ...]:
    """Return what each file of some surfaces states, in the order of the first surface from it."""
    files: dict[Path, list[Surface]] = {}
    for surface in surfaces:
        if surface.file is not None:
            files.setdefault(surface.file, []).append(surface)
    return tuple(_statement(file, held) for file, held in files.items())


def _statement(file: Path, held: Sequence[Surface]) -> Statement:
    kind = kind_of(file)
    vertices = np.concatenate([s.vertices for s in held])
    z = vertices[usable(vertices).all(axis=1), 2]
    low, high = (float(z.min()), float(z.max())) if len(z) else (np.nan, np.nan)
    names = tuple(s.name for s in held)
    return Statement(file, names, stated_units(file, kind), states_sign(file, kind), low, high)
