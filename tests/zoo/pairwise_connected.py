"""The zoo of pairwise-connected: faults that meet twice, in a point, in an area, in a fork or a ring."""

from __future__ import annotations

import numpy as np

from graben.surface import Surface
from tests.zoo.cases import Case
from tests.zoo.near_miss import G, splay
from tests.zoo.shapes import STEP, dipping, faults, sheet
from tests.zoo.simplicial_complex import (
    F,
    coplanar,
    crossed_in_edges,
    joined_at_rim,
    on_plane,
    strayed,
    tip,
)

_SIN = np.sin(np.radians(60))
_LARGE = dipping(60, 20, 32)
#: Faults that end where their common line does.
ENDS = ("near-miss",)
COMPLEX = ("simplicial-complex",)


def _case(name, model, place, *, blocks=False, follows=COMPLEX) -> Case:
    return Case(name, "pairwise-connected", model, place, ("F", "G"), blocks=blocks, follows=follows)


def bent(rows: int) -> Surface:
    """A fault that bends through a plane of dip 60, 10 steps down dip, and back through it, 22 steps down."""

    def place(i, j):
        d = 2.0 + j
        h = 0.02 * (d - 10) * (d - 22)
        return STEP * (4.4 + i), STEP * (0.5 * d + _SIN * h), STEP * (-_SIN * d + 0.5 * h)

    return sheet(10, rows, place, "G")


def star() -> tuple[Surface, Surface]:
    """Two faults that have three edges in common, from one vertex: between them the second bulges upwards."""
    angles = np.radians(30 + 60 * np.arange(6))
    length = np.array([6, 6, 5.5, 6, 6.7, 6])
    spokes = np.stack([length * np.cos(angles), length * np.sin(angles)], axis=1)
    plain = np.array([[0, 0], *spokes])
    fan = np.array([[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)])
    flat = np.column_stack([plain + 8, np.zeros(7)])
    lifted = flat + np.array([0, 0, 0.9]) * (np.arange(7) % 2 == 0)[:, None] * (np.arange(7) > 0)[:, None]
    first, second = (on_plane(points[fan].reshape(-1, 3)) for points in (flat, lifted))
    return _welded(first, "F"), _welded(second, "G")


def dome() -> tuple[Surface, Surface]:
    """Two faults of which the second stands on the first with all of its rim, in common edges."""
    angles = np.radians(15 + 60 * np.arange(6))
    ring = np.column_stack([8 + 4 * np.cos(angles), 8 + 4 * np.sin(angles), np.zeros(6)])
    reach = np.array([9, 9.4, 8.8, 9.2, 9.1, 9.6])
    far = np.column_stack([8 + reach * np.cos(angles), 8 + reach * np.sin(angles), np.zeros(6)])
    centre, top = np.array([8.0, 8, 0]), np.array([8.0, 8, 1.1])
    after = np.roll(np.arange(6), -1)
    inner = [[centre, ring[k], ring[after[k]]] for k in range(6)]
    outer = [[ring[k], far[k], far[after[k]]] for k in range(6)]
    outer += [[ring[k], far[after[k]], ring[after[k]]] for k in range(6)]
    cap = [[top, ring[k], ring[after[k]]] for k in range(6)]
    return tuple(
        _welded(on_plane(np.reshape(t, (-1, 3))), name) for t, name in (([*inner, *outer], "F"), (cap, "G"))
    )


def _welded(surface: Surface, name: str) -> Surface:
    vertices, index = np.unique(surface.vertices, axis=0, return_inverse=True)
    return Surface(name, vertices, index.reshape(-1)[surface.triangles])


FAILING: tuple[Case, ...] = (
    _case("meet twice", faults(_LARGE, bent(28)), on_plane([[9.4, 10, 0], [9.4, 22, 0]] * 3).vertices[:2]),
    _case("touching in a point", faults(F, tip()), tip().vertices[0], follows=COMPLEX),
    _case("overlap", faults(F, coplanar()), None, blocks=True),
    _case("the line forks", faults(*star()), on_plane([[8, 8, 0]] * 3).vertices[0], follows=ENDS),
    _case("a closed line", faults(*dome()), None, follows=ENDS),
    _case(
        "a rim on and off",
        faults(strayed(lambda row: -20.0 * (row == 4)), G),
        None,
        follows=(*COMPLEX, "near-miss"),
    ),
)


def _passes(name, model, follows=COMPLEX) -> Case:
    return Case(name, "pairwise-connected", model, objects=(), follows=follows)


PASSING: tuple[Case, ...] = (
    _passes("cross once", faults(splay(-300), G)),
    _passes("bent, and met once", faults(_LARGE, bent(14))),
    _passes("end at the other", faults(splay(0), G)),
    _passes("rim in common edges", faults(*joined_at_rim()), follows=()),
    _passes("cross in common edges", faults(*crossed_in_edges()), follows=()),
    _passes("apart", faults(splay(140), G), follows=()),
)
