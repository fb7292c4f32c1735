"""The zoo of near-miss: faults that end short of another or just past it; and ones that are meant so."""

from __future__ import annotations

import numpy as np

from graben.settings import ContactRule
from graben.surface import Surface
from tests.zoo.cases import Case
from tests.zoo.shapes import STEP, dipping, faults, sheet

#: A long fault that strikes along x and dips towards +y, its top rim at elevation 0 on the line y = 0.
G = dipping(70, 40, 10, "G")
_NORMAL = np.array([0, np.sin(np.radians(70)), np.cos(np.radians(70))])


def splay(off: float, angle: float = 90, dip: float = 60, columns: int = 12, rows: int = 8, top: float = 0):
    """A fault F that strikes at an angle to G, its near rim on or off G by so much along F's own plane.

    Off is positive on G's upper side; negative beyond G. The rim begins so far below 0.
    """
    s = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0])
    right = np.array([s[1], -s[0], 0])
    normal = np.sin(np.radians(dip)) * right + np.cos(np.radians(dip)) * np.array([0, 0, 1])
    along = np.cross(normal, _NORMAL)
    along *= -np.sign(along[2]) / np.linalg.norm(along)
    out = np.cross(normal, along)
    out *= np.sign(out @ _NORMAL)
    start = np.array([20 * STEP, 0, 0]) + off * out - top / along[2] * along

    def place(i, j):
        return tuple(start[k] + STEP * (out[k] * i + along[k] * j) for k in range(3))

    return sheet(columns, rows, place)


def middle(fault: Surface, rows: int = 8):
    """The middle of the near rim of a splay."""
    return (fault.vertices[0] + fault.vertices[rows]) / 2


def _shifted(surface: Surface, *offset: float) -> Surface:
    return surface.moved(np.array(offset, float))


def _case(name, model, place, *objects: str, follows=()) -> Case:
    return Case(name, "near-miss", model, place, objects or ("F", "G"), "warn", "warn", follows=follows)


CROSSES = ("simplicial-complex",)


def _below(off: float):
    """A fault F that dips the other way, with its top rim so far below G along its own dip."""
    c, r = 0.5, np.sqrt(0.75)
    depth = 100 * np.tan(np.radians(70))
    return sheet(
        12, 8, lambda i, j: (500 + STEP * i, 100 - c * (off + STEP * j), -depth - r * (off + STEP * j))
    )


def _facing(apart: float):
    """Two faults that dip towards each other and end in one level plane, so far apart there."""
    f = dipping(60, 12, 8)
    mirrored = f.vertices * [1, -1, 1] + [0, 2 * f.vertices[:, 1].max() + apart, 0]
    return f, Surface("G", mirrored, f.triangles)


_BESIDE = _shifted(splay(28, 90, 88), 10, 0, 0)

FAILING: tuple[Case, ...] = (
    _case("30 m short", faults(splay(30), G), middle(splay(30))),
    _case("30 m short at 45 degrees", faults(splay(30, 45), G), middle(splay(30, 45))),
    _case("30 m short at 30 degrees", faults(splay(30, 30, 75), G), middle(splay(30, 30, 75))),
    _case("stub of 40 m", faults(splay(-40), G), middle(splay(-40)), follows=CROSSES),
    _case("stub at 45 degrees", faults(splay(-40, 45), G), middle(splay(-40, 45)), follows=CROSSES),
    _case("ends below", faults(_below(30), G), _below(30).vertices[[0, -9]].mean(axis=0)),
    _case("misses the end of the other", faults(_BESIDE, dipping(70, 20, 10, "G")), _BESIDE.vertices[0]),
)


def _passes(name, model, follows=()) -> Case:
    return Case(name, "near-miss", model, objects=(), follows=follows)


PASSING: tuple[Case, ...] = (
    _passes("further than the limit", faults(splay(140), G)),
    _passes("a lower limit", faults(splay(30), G, checks={"near-miss": 25.0})),
    _passes("accepted", faults(splay(30), G, contacts=(ContactRule(faults=("G", "F"), rule="accept"),))),
    _passes(
        "passes the end of the other at 45 degrees",
        faults(_shifted(splay(60, 90, 88), 60, 0, 0), dipping(70, 20, 10, "G")),
    ),
    _passes("cross", faults(splay(-320), G), follows=CROSSES),
    _passes("cut off at one depth", faults(*_facing(40))),
    _passes("side by side", faults(dipping(60, 12, 8), _shifted(dipping(60, 12, 8, "G"), 0, 40, 0))),
)
