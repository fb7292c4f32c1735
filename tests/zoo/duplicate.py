"""The zoo of duplicate: vertices at one place, triangles twice; and surfaces that only come as close."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.zoo.cases import Case
from tests.zoo.shapes import AT_MIDDLE, F60, MIDDLE, STEP, dipping, faults, joined, scene, two_triangles


def slit(width: float = 0.0):
    """F60 cut open along the edges down from the upper rim to the vertex in the middle, the lips apart."""
    middle = F60.vertices[:, 0] == AT_MIDDLE[0]
    lip = np.flatnonzero(middle & (F60.vertices[:, 2] > AT_MIDDLE[2]))
    right = F60.vertices[F60.triangles].mean(axis=1)[:, 0] > AT_MIDDLE[0]
    copies = np.arange(len(F60.vertices))
    copies[lip] = len(F60.vertices) + np.arange(len(lip))
    return replace(
        F60,
        vertices=np.concatenate([F60.vertices, F60.vertices[lip] + [width, 0, 0]]),
        triangles=np.where(right[:, None], copies[F60.triangles], F60.triangles),
    )


def cracked():
    """Two parts of a fault whose common edge is not common: its vertices stand twice."""
    return joined(dipping(60, 4, 4), dipping(60, 2, 4).moved(np.array([4 * STEP, 0, 0])))


def _case(name, model, place, *follows: str) -> Case:
    return Case(name, "duplicate", model, place, follows=follows)


_TWICE = 13  # inside, so that each of its edges has three triangles

FAILING: tuple[Case, ...] = (
    _case("slit", scene(slit()), F60.vertices[MIDDLE - 2 : MIDDLE]),
    _case("crack", faults(cracked()), F60.vertices[20:25]),
    _case(
        "vertex twice",
        scene(replace(F60, vertices=np.concatenate([F60.vertices, F60.vertices[[MIDDLE]]]))),
        AT_MIDDLE,
    ),
    _case(
        "triangle twice",
        faults(
            replace(F60, triangles=np.concatenate([F60.triangles, F60.triangles[[_TWICE]][:, [1, 2, 0]]]))
        ),
        F60.vertices[F60.triangles[_TWICE]].mean(axis=0),
        "manifold",
    ),
)


def _passes(name, model) -> Case:
    return Case(name, "duplicate", model, objects=())


_BESIDE = dipping(60, name="G").moved(np.array([6 * STEP, 0, 0]))

PASSING: tuple[Case, ...] = (
    _passes("two triangles", faults(two_triangles())),
    _passes("open slit", scene(slit(0.01))),
    _passes(
        "almost the same place", faults(replace(F60, vertices=np.vstack([F60.vertices, AT_MIDDLE + 1e-6])))
    ),
    _passes("two faults with a common rim", faults(F60, _BESIDE)),
    _passes("far away", faults(F60.moved(np.array([5e5, 5e6, 0.0])))),
)
