"""The zoo of simplicial-complex: how faults meet otherwise than in common edges; and how they may."""

from __future__ import annotations

import numpy as np

from graben.surface import Surface
from tests.zoo.cases import Case
from tests.zoo.near_miss import G, middle, splay
from tests.zoo.shapes import STEP, dipping, faults, scene, sheet, without

#: The contact distance of the models of a splay and G, about.
CONTACT = 2.2e-3
_SIN, _COS = np.sin(np.radians(60)), np.cos(np.radians(60))


def _case(name, model, place, *, extended="fail", objects=("F", "G"), follows=()) -> Case:
    return Case(name, "simplicial-complex", model, place, objects, extended, "fail", follows=follows)


def strayed(off) -> Surface:
    """A splay on G whose near rim lies ``off`` (a function of the row) past G along its own plane."""
    fault = splay(0)
    rows = np.arange(9)
    toward = splay(-1).vertices[:9] - fault.vertices[:9]
    vertices = fault.vertices.copy()
    vertices[:9] += off(rows)[:, None] * toward
    return fault.with_vertices(vertices)


def on_plane(points) -> Surface:
    """Triangles by their corners, in steps along strike, down dip and upwards from the plane of F."""
    s, d, h = STEP * np.array(points, float).T
    vertices = np.stack([s, _COS * d + _SIN * h, -_SIN * d + _COS * h], axis=1)
    return Surface("G", vertices, np.arange(len(vertices)).reshape(-1, 3))


def tip() -> Surface:
    """A fault with one corner inside a triangle of F."""
    return on_plane([[10.3, 8.2, 0], [7.3, 8, 9], [13.3, 8, 9]])


def roof() -> Surface:
    """A fault that touches F with a ridge, 200 m long, and stays on its upper side."""

    def place(i, j):
        y, z = np.array([[-1.0, 6.0], [0.0, 0.0], [8.0, -6.0]]).T
        return STEP * (8.7 + i), STEP * y[j.astype(int)], STEP * z[j.astype(int)]

    return sheet(4, 2, place, "G").moved(STEP * np.array([0, 8.3 * _COS, -8.3 * _SIN]))


def coplanar() -> Surface:
    """A fault of 5 x 3 steps in the plane of F, on it, its triangles not those of F."""

    def place(i, j):
        return STEP * (8.4 + i), _COS * STEP * (7.3 + j), -_SIN * STEP * (7.3 + j)

    return sheet(5, 3, place, "G")


def joined_at_rim() -> tuple[Surface, Surface]:
    """Two faults that share a line of edges, the rim of the second."""
    first = dipping(60, 8, 6)
    line = first.vertices[4 * 7 : 5 * 7]
    offset = STEP * np.array([0.6, 0.8, -0.1])
    return first, sheet(5, 6, lambda i, j: tuple((line[j.astype(int)] + i[:, None] * offset).T), "G")


def crossed_in_edges() -> tuple[Surface, Surface]:
    """Two faults that cross in a line of edges that both have."""
    first = dipping(60, 8, 6)
    line = first.vertices[4 * 7 : 5 * 7]
    offset = STEP * np.array([0.6, 0.8, -0.1])
    return first, sheet(6, 6, lambda i, j: tuple((line[j.astype(int)] + (i - 3)[:, None] * offset).T), "G")


def with_hole(row: int) -> Surface:
    """A fault that leaves the domain of the scene to the west, with a hole there in a row of its cells."""
    made = dipping(60, 12, 8).moved(STEP * np.array([-6.3, 0.2, 0.15]))
    hole = [(column * 8 + row) + k * 96 for column in (1, 2, 3) for k in (0, 1)]
    return without(made, hole)


F = dipping(60, 20, 16)
#: The upper end of the hole in the row 2, where the scene ends.
HOLE = STEP * np.array([-4.0, 0.2 + 2 * _COS, 0.15 - 2 * _SIN])
_CROSSES, _T = splay(-300), splay(0)
#: The rim on G in the upper half, further and further past it below.
_BOTH = strayed(lambda row: np.maximum(row - 4, 0) * 30.0)
PAIRWISE = ("pairwise-connected",)

_RIDGE = roof().vertices[[1, -2]].mean(axis=0)

FAILING: tuple[Case, ...] = (
    _case("proper crossing", faults(_CROSSES, G), middle(_T), extended="warn"),
    _case("T-contact", faults(_T, G), middle(_T)),
    _case(
        "a rim that strays to both sides",
        faults(strayed(lambda row: 0.8 * CONTACT * np.cos(2.3 * row)), G),
        middle(_T),
    ),
    _case("rim and crossing", faults(_BOTH, G), (_T.vertices[0] + middle(_T)) / 2, follows=("near-miss",)),
    _case("touching in a point", faults(F, tip()), tip().vertices[0], follows=PAIRWISE),
    _case("touching in a line", faults(F, roof()), _RIDGE),
    _case("overlap", faults(F, coplanar()), None, follows=PAIRWISE),
    _case(
        "hole over the boundary",
        scene(with_hole(2)),
        HOLE,
        objects=("H", "F"),
        extended="warn",
        follows=("manifold",),
    ),
)


def _passes(name, model, follows=()) -> Case:
    return Case(name, "simplicial-complex", model, objects=(), follows=follows)


PASSING: tuple[Case, ...] = (
    _passes("rim in common edges", faults(*joined_at_rim())),
    _passes("cross in common edges", faults(*crossed_in_edges())),
    _passes("apart", faults(splay(140), G)),
    _passes("a gap of fifty contact distances", faults(splay(50 * CONTACT), G), follows=("near-miss",)),
    _passes("a hole over the boundary, far below", scene(with_hole(5)), ("manifold",)),
    _passes(
        "a hole inside the domain", scene(with_hole(5).moved(STEP * np.array([5.0, 0, 0]))), ("manifold",)
    ),
)
