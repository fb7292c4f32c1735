"""Surfaces that come close to a defect and have none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.model import Horizon
from graben.surface import Surface
from tests.zoo_shapes import (
    AT_MIDDLE,
    F60,
    STEP,
    Case,
    dipping,
    faults,
    folded_points,
    joined,
    level,
    sheet,
    two_triangles,
    without,
)


def surfaces_that_pass() -> list[Case]:
    huge = faults(F60.moved(np.array([5e5, 5e6, 0])))
    slim = sheet(2, 2, lambda i, j: (STEP * i, 0.6 * j, -1.0 * j))
    needle = Surface("F", [[0, 0, 0], [100, 0, 0], [50, 0.8, 0.8]], [[0, 1, 2]])
    slivers = sheet(4, 4, lambda i, j: (STEP * i, 0.2 * j, 0 * i), "H")
    near = replace(F60, vertices=np.vstack([F60.vertices, AT_MIDDLE + np.array([1e-6, 0, 0])]))
    fan = Surface("F", [[0, 0, 0], [50, 0, -50], [50, 30, -60], [30, 60, -70]], [[0, 1, 2], [0, 2, 3]])
    ring = without(sheet(3, 3, lambda i, j: (STEP * i, STEP * j, 0 * i), "H"), [4, 13])
    tube = sheet(3, 3, lambda i, j: (STEP * i, STEP * j, -STEP * j))
    hole = without(tube, [4, 13])
    still = replace(F60, triangles=F60.triangles[:, ::-1])
    steep = dipping(89.8)
    bow = sheet(6, 4, lambda i, j: (STEP * i, 30 * j + 40 * np.cos(i), -STEP * j))
    ramp = sheet(
        24,
        1,
        lambda i, j: ((300 - 200 * j) * np.cos(0.25 * i), (300 - 200 * j) * np.sin(0.25 * i), 10 * i),
        "H",
    )
    side_by_side = joined(level().surface, level().surface.moved(np.array([8.5 * STEP, 0, 200])))
    throw, lip = 300.0, dipping(60, 24, 16).moved(np.array([-600.0, -200, 350]))
    x = np.arange(-600, 600, 25.0)
    cut = -200 + 350 / np.tan(np.radians(60))
    half = throw / 2 / np.tan(np.radians(60))
    reverse = np.concatenate(
        [
            np.stack(np.broadcast_arrays(*np.meshgrid(x, np.arange(0, 400, 25.0)), 0), -1).reshape(-1, 3)
            * [1, s, 1]
            + [0, cut + s * -half, s * throw / 2]
            for s in (1, -1)
        ]
    )
    one = {"objects": ()}
    return [
        Case("two triangles", check, faults(two_triangles()), **one)
        for check in (
            "finite",
            "degenerate",
            "duplicate",
            "manifold",
            "oriented",
            "strongly-connected",
            "functional",
            "min-dip",
        )
    ] + [
        Case("far away", "finite", huge),
        Case("unused vertex", "finite", faults(near)),
        Case("zeros", "finite", faults(Surface("F", np.zeros((3, 3)), [[0, 1, 2]]))),
        Case("slim", "degenerate", faults(slim)),
        Case("needle of 1.3 degrees", "degenerate", faults(needle)),
        Case("slivers of a horizon", "degenerate", faults(horizons=[Horizon("H", slivers, STEP)])),
        Case("almost the same place", "duplicate", faults(near)),
        Case("two faults at one place", "duplicate", faults(F60, dipping(60, name="G"))),
        Case("far away", "duplicate", huge),
        Case("fan", "manifold", faults(fan)),
        Case("hole", "manifold", faults(horizons=[Horizon("H", ring, STEP)])),
        Case("far away", "manifold", huge),
        Case("turned as a whole", "oriented", faults(still)),
        Case("hole", "oriented", faults(hole)),
        Case("fan", "oriented", faults(fan)),
        Case("hole", "strongly-connected", faults(hole)),
        Case("a horizon in parts", "strongly-connected", faults(horizons=[Horizon("H", side_by_side, STEP)])),
        Case("fan", "strongly-connected", faults(fan)),
        Case("89.8 degrees", "functional", faults(steep)),
        Case("bow", "functional", faults(bow)),
        Case("three quarters of a ramp", "functional", faults(horizons=[Horizon("H", ramp, STEP)])),
        Case("parts side by side", "functional", faults(horizons=[Horizon("H", side_by_side, STEP)])),
        Case("limb of 75 degrees", "functional", faults(horizons=[level(points=folded_points(75))])),
        Case("reverse fault", "functional", faults(lip, horizons=[level(points=reverse)])),
        Case("turned as a whole", "functional", faults(still)),
        Case("31 degrees", "min-dip", faults(dipping(31))),
        Case("vertical", "min-dip", faults(dipping(90))),
        Case("own limit", "min-dip", faults(dipping(12), checks={"min-dip": 10.0})),
    ]
