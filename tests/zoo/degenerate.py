"""The zoo of degenerate: triangles without area, slivers of faults; and slim ones that are allowed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.model import Horizon
from graben.surface import Surface
from tests.zoo.cases import Case
from tests.zoo.shapes import F60, STEP, dipping, faults, scene, sheet, two_triangles

A, B = F60.vertices[0], F60.vertices[5]  # of the edge of the upper rim that triangle 0 has


def _capped():
    """F60 with a triangle without area on its rim, between an edge and that edge's middle."""
    middle = len(F60.vertices)
    return replace(
        F60,
        vertices=np.vstack([F60.vertices, (A + B) / 2]),
        triangles=np.concatenate([F60.triangles, [[5, 0, middle]]]),
    )


def _split(columns: int, rows: int, share: float):
    """A fault whose first triangle is split in three at a point that is near its first side."""
    made = dipping(60, columns, rows)
    a, b, c = made.triangles[0]
    near = made.vertices[[a, b]].mean(axis=0)
    p = len(made.vertices)
    return replace(
        made,
        vertices=np.vstack([made.vertices, near + share * (made.vertices[c] - near)]),
        triangles=np.concatenate([[[a, b, p], [b, c, p], [c, a, p]], made.triangles[1:]]),
    )


def _case(name, model, place, *objects: str, blocks: bool = False, follows=()) -> Case:
    return Case(name, "degenerate", model, place, objects or ("F",), blocks=blocks, follows=follows)


_ON_A_LINE = sheet(8, 8, lambda i, j: (STEP * i + 5 * j, 0 * j, 0 * i), "H")

FAILING: tuple[Case, ...] = (
    _case(
        "repeated corner",
        scene(replace(F60, triangles=np.concatenate([F60.triangles, [[0, 0, 5]]]))),
        (2 * A + B) / 3,
    ),
    _case("three in one line", scene(_capped()), (A + B) / 2),
    _case("sliver", scene(_split(6, 4, 0.002)), (A + B) / 2),
    _case("sliver of two triangles", faults(_split(1, 1, 0.001)), (A + B) / 2),
    _case(
        "no area at all",
        faults(sheet(6, 4, lambda i, j: (STEP * i + 11 * j, 0 * i, 0 * i))),
        None,
        blocks=True,
    ),
    _case("no triangles", faults(Surface("F", [[0, 0, 0.0]], [])), None, blocks=True),
    _case("horizon on a line", faults(horizons=[Horizon("H", _ON_A_LINE, STEP)]), None, "H", blocks=True),
)


def _passes(name, model) -> Case:
    return Case(name, "degenerate", model, objects=())


PASSING: tuple[Case, ...] = (
    _passes("two triangles", faults(two_triangles())),
    _passes("slim", faults(sheet(2, 2, lambda i, j: (STEP * i, 0.6 * j, -1.0 * j)))),
    _passes(
        "needle of 1.3 degrees", faults(Surface("F", [[0, 0, 0], [100, 0, 0], [50, 0.8, 0.8]], [[0, 1, 2]]))
    ),
    _passes("split not so near", scene(_split(6, 4, 0.03))),
    _passes(
        "slivers of a horizon",
        faults(horizons=[Horizon("H", sheet(4, 4, lambda i, j: (STEP * i, 0.2 * j, 0 * i), "H"), STEP)]),
    ),
)
