"""Surfaces with one known defect each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.model import Horizon
from graben.surface import Surface
from tests.zoo_shapes import (
    AT_MIDDLE,
    F60,
    MIDDLE,
    NAN,
    STEP,
    Case,
    dipping,
    faults,
    folded_points,
    joined,
    level,
    moved_vertex,
    sheet,
    two_triangles,
    without,
)


def _finite() -> list[Case]:
    nan = moved_vertex(F60, MIDDLE, [AT_MIDDLE[0], NAN, AT_MIDDLE[2]])
    stray = replace(F60, triangles=np.concatenate([F60.triangles, [[0, 1, 99]]]))
    negative = replace(F60, triangles=np.concatenate([F60.triangles, [[0, -1, 1]]]))
    points = np.array([[100.0, 100, 10], [150, 100, np.inf], [100, 150, 10], [150, 150, 15]])
    horizon = level(points=points)
    # one coordinate is lost: the place keeps the other two
    return [
        Case("nan", "finite", faults(nan), (AT_MIDDLE[0], None, AT_MIDDLE[2]), blocks=True),
        Case("index too large", "finite", faults(stray), F60.vertices[0], blocks=True),
        Case("negative index", "finite", faults(negative), F60.vertices[0], blocks=True),
        Case("infinite point", "finite", faults(horizons=[horizon]), (150, 100, None), ("H",), blocks=True),
    ]


def _degenerate() -> list[Case]:
    a, b = F60.vertices[0], F60.vertices[5]
    repeated = replace(F60, triangles=np.concatenate([F60.triangles, [[0, 0, 5]]]))
    flat = joined(F60, Surface("", [a - 100, b - 100, (a + b) / 2 - 100], [[0, 1, 2]]))
    thin = moved_vertex(
        two_triangles(), 1, (two_triangles().vertices[0] + two_triangles().vertices[3]) / 2 + [0, 0, 0.1]
    )
    collapsed = F60.with_vertices(F60.vertices * [1, 0, 0])
    line = sheet(8, 8, lambda i, j: (STEP * i, 0 * j, 0 * i), "H")
    return [
        Case("repeated corner", "degenerate", faults(repeated), (2 * a + b) / 3),
        Case("three in one line", "degenerate", faults(flat), (a + b) / 2 - 100),
        Case("sliver", "degenerate", faults(thin), thin.vertices[thin.triangles[1]].mean(axis=0)),
        Case("no area at all", "degenerate", faults(collapsed), (150, 0, 0), blocks=True),
        Case("no triangles", "degenerate", faults(Surface("F", [[0, 0, 0.0]], [])), None, blocks=True),
        Case(
            "horizon on a line",
            "degenerate",
            faults(horizons=[Horizon("H", line, STEP)]),
            (200, 0, 0),
            ("H",),
            blocks=True,
        ),
    ]


def _duplicate() -> list[Case]:
    split = joined(dipping(60, 3, 4), dipping(60, 2, 4).moved(np.array([3 * STEP, 0, 0])))
    twice = replace(F60, triangles=np.concatenate([F60.triangles, F60.triangles[5:6, [1, 0, 2]]]))
    extra = replace(F60, vertices=np.concatenate([F60.vertices, F60.vertices[MIDDLE : MIDDLE + 1]]))
    return [
        Case("crack", "duplicate", faults(split), split.vertices[15]),
        Case("triangle twice", "duplicate", faults(twice), F60.vertices[F60.triangles[5]].mean(axis=0)),
        Case("vertex twice", "duplicate", faults(extra), AT_MIDDLE),
    ]


def _manifold() -> list[Case]:
    fin = replace(
        F60,
        vertices=np.vstack([F60.vertices, AT_MIDDLE + np.array([25, 0, 60])]),
        triangles=np.concatenate([F60.triangles, [[MIDDLE, MIDDLE + 5, len(F60.vertices)]]]),
    )
    tip = replace(
        F60,
        vertices=np.concatenate([F60.vertices, F60.vertices[:2] - [STEP, 0, 0]]),
        triangles=np.concatenate([F60.triangles, [[0, len(F60.vertices), len(F60.vertices) + 1]]]),
    )
    cells = sheet(2, 2, lambda i, j: (STEP * i, STEP * j, 0 * i), "H")
    diagonal = replace(cells, triangles=cells.triangles[[0, 4, 3, 7]])
    edge = (F60.vertices[MIDDLE] + F60.vertices[MIDDLE + 5]) / 2
    return [
        Case("fin", "manifold", faults(fin), edge, blocks=True),
        Case("touching tip", "manifold", faults(tip), F60.vertices[0]),
        Case(
            "cells at a corner",
            "manifold",
            faults(horizons=[Horizon("H", diagonal, STEP)]),
            (STEP, STEP, 0),
            ("H",),
        ),
    ]


def _oriented() -> list[Case]:
    def turned(which):
        triangles = F60.triangles.copy()
        triangles[which] = triangles[which][:, ::-1]
        return replace(F60, triangles=triangles)

    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    inner, outer = (
        np.c_[
            (200 + w * np.cos(angle / 2)) * np.cos(angle),
            (200 + w * np.cos(angle / 2)) * np.sin(angle),
            w * np.sin(angle / 2),
        ]
        for w in (-STEP, STEP)
    )
    k = np.arange(23)
    band = [np.c_[k, k + 24, k + 1], np.c_[k + 1, k + 24, k + 25], [[23, 47, 24], [24, 47, 0]]]
    moebius = Surface("F", np.concatenate([inner, outer]), np.concatenate(band))
    return [
        Case("one turned", "oriented", faults(turned([7])), F60.vertices[F60.triangles[7]].mean(axis=0)),
        Case(
            "half turned",
            "oriented",
            faults(turned(range(24, 48))),
            (150, 50, -86.6),
        ),
        Case("one-sided band", "oriented", faults(moebius)),
    ]


def _strongly_connected() -> list[Case]:
    apart = joined(F60, dipping(60, 2, 4).moved(np.array([8 * STEP, 0, 0])))
    corner = without(dipping(60, 3, 2), [1, 2, 4, 7, 8, 10])
    crumb = joined(F60, two_triangles().moved(np.array([-3 * STEP, 0, 0])))
    crack = _duplicate()[0].model.faults[0].surface
    return [
        Case(
            "two parts",
            "strongly-connected",
            faults(apart),
            (9 * STEP, F60.vertices[2, 1], F60.vertices[2, 2]),
        ),
        Case("joined in a corner", "strongly-connected", faults(corner), (25, 12.5, -21.7)),
        Case("crumb", "strongly-connected", faults(crumb), (-2.5 * STEP, 0.25 * STEP, -0.43 * STEP)),
        Case("cracked", "strongly-connected", faults(crack), (200, 50, -86.6)),
    ]


def _functional() -> list[Case]:
    curved = sheet(4, 8, lambda i, j: (STEP * i, 150 * np.sin(j / 3), -STEP * j))
    spiral = sheet(
        40,
        1,
        lambda i, j: ((300 - 200 * j) * np.cos(0.2 * i), (300 - 200 * j) * np.sin(0.2 * i), 10 * i),
        "H",
    )
    upright = dipping(90.0)
    stacked = joined(
        sheet(4, 4, lambda i, j: (STEP * i, STEP * j, 0 * i), "H"),
        sheet(2, 2, lambda i, j: (60 + 20 * i, 60 + 20 * j, 90 + 0 * i)),
    )
    fold = sheet(8, 2, lambda i, j: (100 * np.sin(i / 2), STEP * j, STEP * i), "H")
    h = ("H",)
    warn = {"extended": "warn"}
    return [
        Case("vertical fault", "functional", faults(upright), None, **warn),
        Case(
            "overturned fault",
            "functional",
            faults(curved),
            (100, 150 * np.sin(7.3 / 3), -7.3 * STEP),
            **warn,
        ),
        Case(
            "spiral ramp", "functional", faults(horizons=[Horizon("H", spiral, STEP)]), None, h, blocks=True
        ),
        Case(
            "two sheets",
            "functional",
            faults(horizons=[Horizon("H", stacked, STEP)]),
            (80, 80, 90),
            h,
            blocks=True,
        ),
        Case(
            "folded sheet",
            "functional",
            faults(horizons=[Horizon("H", fold, STEP)]),
            (90, 50, 110),
            h,
            blocks=True,
        ),
        Case(
            "vertical limb",
            "functional",
            faults(horizons=[level(points=folded_points(90))]),
            (0, 0, 400),
            h,
            blocks=True,
        ),
        Case(
            "overturned limb",
            "functional",
            faults(horizons=[level(points=folded_points(110))]),
            (-75, 0, 200),
            h,
            blocks=True,
        ),
        Case(
            "limb of 88 degrees",
            "functional",
            faults(horizons=[level(points=folded_points(88))]),
            (10, 0, 300),
            h,
            blocks=True,
        ),
    ]


def _min_dip() -> list[Case]:
    warn = {"extended": "warn", "paper": "warn"}
    bent = sheet(
        4, 6, lambda i, j: (STEP * i, STEP * j, -STEP * np.where(j < 3, 1.2 * j, 3.6 + 0.2 * (j - 3)))
    )
    return [
        Case("flat fault", "min-dip", faults(dipping(29)), None, **warn),
        Case("listric fault", "min-dip", faults(bent), (100, 225, -205), **warn),
        Case("own limit", "min-dip", faults(dipping(40), checks={"min-dip": 45.0}), None, **warn),
    ]


def surfaces_that_fail() -> list[Case]:
    """Every surface with a defect."""
    made = (
        _finite,
        _degenerate,
        _duplicate,
        _manifold,
        _oriented,
        _strongly_connected,
        _functional,
        _min_dip,
    )
    return [case for make in made for case in make()]
