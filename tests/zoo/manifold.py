"""The zoo of manifold: three triangles at an edge, parts that touch in a point, holes; and what has none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.model import Horizon
from graben.surface import Surface
from tests.zoo.cases import Case
from tests.zoo.shapes import (
    AT_MIDDLE,
    F60,
    MIDDLE,
    STEP,
    dipping,
    faults,
    scene,
    sheet,
    two_triangles,
    without,
)

FAN = Surface("F", [[0, 0, 0], [50, 0, -50], [50, 30, -90], [30, 60, -140]], [[0, 1, 2], [0, 2, 3]])


def _with_triangle(points, *corners: int):
    return replace(
        F60,
        vertices=np.vstack([F60.vertices, points]),
        triangles=np.concatenate([F60.triangles, [corners]]),
    )


def perforated(*cells: tuple[int, int], name: str = "F"):
    """A fault of 7 by 6 cells without some, by column and row."""
    first = np.array([6 * column + row for column, row in cells])
    return without(dipping(60, 7, 6, name), np.concatenate([first, first + 42]))


def pipe(wide: float = 1.2):
    """A pipe of 12 by 4 cells that widens downwards to so many times its width."""
    turn = np.arange(12) * np.pi / 6
    at = 2 * STEP * np.linspace(1, wide, 5)
    vertices = [(r * np.cos(a), r * np.sin(a), -STEP * j) for a in turn for j, r in enumerate(at)]
    grid = sheet(12, 4, lambda i, j: (i, j, 0 * i))
    return Surface("F", vertices, grid.triangles % 60)


def hanging():
    """A fault of 7 by 6 cells, an edge of which has a vertex on one side only."""
    made = dipping(60, 7, 6)
    a, b, c = made.triangles[20]
    vertices = np.vstack([made.vertices, made.vertices[[a, c]].mean(axis=0)])
    m = len(vertices) - 1
    return replace(
        made,
        vertices=vertices,
        triangles=np.concatenate([np.delete(made.triangles, 20, axis=0), [[a, b, m], [m, b, c]]]),
    )


def _horizon(surface: Surface):
    return faults(horizons=[Horizon("H", replace(surface, name="H"), STEP)])


_LEVEL = sheet(4, 4, lambda i, j: (STEP * i, STEP * j, 0 * i))
_AT_A_CORNER = replace(_LEVEL, triangles=_LEVEL.triangles[[5, 21, 10, 26]])  # cells (1, 1) and (2, 2)
_N = len(F60.vertices)
FAR = np.array([5e5, 5e6, 0.0])


def _case(name, model, place, *follows: str, objects=("F",), blocks: bool = False) -> Case:
    return Case(name, "manifold", model, place, objects, blocks=blocks, follows=follows)


def _warns(name, model, place) -> Case:
    return Case(name, "manifold", model, place, extended="warn", paper="warn")


_AROUND = dipping(60, 7, 6).vertices[[[10, 11], [17, 18]]].reshape(-1, 3)  # the cell (1, 3)
_BROKEN = perforated((4, 4))
_FIN_AND_HOLE = replace(
    _BROKEN,
    vertices=np.vstack([_BROKEN.vertices, _BROKEN.vertices[9] + [25, 0, 60]]),
    triangles=np.concatenate([_BROKEN.triangles, [[9, 16, len(_BROKEN.vertices)]]]),
)


# wherever a third triangle stands at an edge, it lies over or under one of the two in plan
FAILING: tuple[Case, ...] = (
    _case(
        "fin",
        faults(_with_triangle(np.add(AT_MIDDLE, [25, 0, 60]), MIDDLE, MIDDLE + 5, _N)),
        np.add(AT_MIDDLE, [25, 0, 0]),
        "functional",
        blocks=True,
    ),
    _case(
        "fin of a horizon",
        _horizon(
            replace(
                _LEVEL,
                vertices=np.vstack([_LEVEL.vertices, [125, 90, 40]]),
                triangles=np.concatenate([_LEVEL.triangles, [[12, 17, 25]]]),
            )
        ),
        (125, 100, 0),
        "functional",
        objects=("H",),
        blocks=True,
    ),
    _case("two holes that touch", scene(perforated((2, 3), (3, 4))), dipping(60, 7, 6).vertices[3 * 7 + 4]),
    _case(
        "touching tip",
        faults(_with_triangle(F60.vertices[:2] - [STEP, 0, 0], 0, _N, _N + 1)),
        F60.vertices[0],
        "strongly-connected",
    ),
    _case("cells at a corner", _horizon(_AT_A_CORNER), (100, 100, 0), objects=("H",)),
    _case("fin and hole", faults(_FIN_AND_HOLE), _BROKEN.vertices[9] + [25, 0, 0], "functional", blocks=True),
    _warns("two holes with a cell between", scene(perforated((1, 3), (3, 3))), _AROUND),
    _warns("far away", faults(perforated((1, 3)).moved(FAR)), _AROUND + FAR),
    _warns("a vertex on one side of an edge", faults(hanging()), hanging().vertices[-1]),
)


def _passes(name, model) -> Case:
    return Case(name, "manifold", model, objects=())


PASSING: tuple[Case, ...] = (
    _passes("two triangles", faults(two_triangles())),
    _passes("fan", faults(FAN)),
    _passes("horizon with a hole", _horizon(without(_LEVEL, [5, 21]))),
    _passes("notch in the rim", faults(perforated((1, 0)))),
    _passes("pipe", faults(pipe())),
    _passes("pipe that widens", faults(pipe(1.8))),
    _passes("far away in one piece", faults(F60.moved(FAR))),
)
