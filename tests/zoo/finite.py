"""The zoo of finite: coordinates that are no numbers, indices out of range; and numbers that are only odd."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.zoo.cases import Case
from tests.zoo.shapes import (
    AT_MIDDLE,
    F60,
    MIDDLE,
    NAN,
    STEP,
    dipping,
    faults,
    level,
    moved_vertex,
    scene,
    two_triangles,
)

_POINTS = np.array([[100.0, 100, 10], [150, 100, 15], [100, 150, 10], [150, 150, 15]])


def _with_triangle(*corners: int):
    return replace(F60, triangles=np.concatenate([F60.triangles, [corners]]))


def _points(k: int, elevation: float):
    points = _POINTS.copy()
    points[k, 2] = elevation
    return faults(horizons=[level(points=points)])


def _case(name, model, place, *objects: str) -> Case:
    return Case(name, "finite", model, place, objects or ("F",), blocks=True)


# where a coordinate is lost, the place keeps the other two
FAILING: tuple[Case, ...] = (
    _case(
        "nan",
        scene(moved_vertex(F60, MIDDLE, [AT_MIDDLE[0], NAN, AT_MIDDLE[2]])),
        (AT_MIDDLE[0], None, AT_MIDDLE[2]),
    ),
    _case(
        "mark of the undefined",
        faults(moved_vertex(F60, MIDDLE, [*AT_MIDDLE[:2], 1e30])),
        (*AT_MIDDLE[:2], None),
    ),
    _case("index too large", scene(_with_triangle(0, 1, 99)), F60.vertices[0]),
    _case("negative index", faults(_with_triangle(0, -1, 1)), F60.vertices[0]),
    _case("infinite point", _points(1, np.inf), (150, 100, None), "H"),
)


def _passes(name, model) -> Case:
    return Case(name, "finite", model, objects=())


PASSING: tuple[Case, ...] = (
    _passes("two triangles", faults(two_triangles())),
    _passes("far away", faults(F60.moved(np.array([5e5, 5e6, 0.0])))),
    _passes("a millionth of the size", faults(F60.with_vertices(1e-6 * F60.vertices))),
    _passes("as large as a planet", faults(F60.with_vertices(1e4 * F60.vertices))),
    _passes("unused vertex", faults(replace(F60, vertices=np.vstack([F60.vertices, AT_MIDDLE + STEP])))),
    _passes("finite points", _points(1, 18.0)),
    _passes("two faults, one horizon", scene(F60, dipping(60, name="G").moved(np.array([0, -3 * STEP, 0])))),
)
