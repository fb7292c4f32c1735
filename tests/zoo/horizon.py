"""The zoo of horizon: holes near a trace, a slope like the fault's, stray picks, smear; and what comes close.

All have one plane fault that strikes along x, passes the origin and dips towards +y, on a horizon of 1.2 km,
and a gamma of two steps unless said otherwise.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr

from graben.formats.irap import grid_surface
from graben.model import Fault, GridGeometry, Horizon, Model
from graben.settings import Parameters
from graben.surface import Surface
from tests.models import plane_fault
from tests.zoo.cases import Case
from tests.zoo.shapes import STEP

HALF = 12  #: half the size of the horizon, steps
LENGTH = 400.0  #: half the length of the fault, m
THROW = 60.0  #: in the middle, foot minus hanging, m
SLIDE = 7.0  #: how far the grid is off the trace, so that no node lies on it, m
GRID = GridGeometry(2 * HALF + 1, 2 * HALF + 1, STEP, STEP, (-HALF * STEP + SLIDE, -HALF * STEP + SLIDE))


def faulted(x, y, width: float = 1.0, throw: float = THROW):
    """A gentle slope with a step of standard width ``width`` that fades towards the fault's ends."""
    profile = np.maximum(1 - (x / LENGTH) ** 2, 0) ** 1.5
    return 0.03 * x + 0.02 * y + throw * profile * (0.5 - ndtr(y / width))


def fault(dip: float = 60.0) -> Surface:
    return Surface("F", *_arrays(plane_fault((LENGTH, 0), (-LENGTH, 0), dip, 300.0, parts=(9, 7)).surface))


def _arrays(surface: Surface):
    return surface.vertices, surface.triangles


def model(height, undefined=None, *, grid=False, picks=None, dip=60.0, gamma=2 * STEP) -> Model:
    """A horizon of the given height, without the nodes that are ``undefined``, and the fault."""
    x, y = np.moveaxis(GRID.nodes(), -1, 0)
    z = height(x, y)
    if undefined is not None:
        z = np.where(undefined(x, y), np.nan, z)
    points = np.zeros((0, 3)) if picks is None else picks
    horizon = Horizon("H", grid_surface("H", GRID, z), STEP, GRID if grid else None, points)
    return Model("zoo", (horizon,), (Fault(fault(dip)),), unit="m", parameters=Parameters(gamma=gamma))


def around(x0: float, y0: float, half: float = 20.0, half_y: float | None = None):
    """Which nodes lie in a box about a place."""
    reach = half if half_y is None else half_y
    return lambda x, y: (np.abs(x - x0) <= half) & (np.abs(y - y0) <= reach)


def sharp_picks(seed: int = 3, noise: float = 0.5, throw: float = THROW):
    """Picks on both lips, each on its side of the fault."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-550, 550, (2, 900))
    profile = throw * np.maximum(1 - (x / LENGTH) ** 2, 0) ** 1.5
    trend = 0.03 * x + 0.02 * y
    foot, hanging = trend + profile / 2, trend - profile / 2
    lip = np.where(
        y < -foot / np.tan(np.radians(60)),
        foot,
        np.where(y > -hanging / np.tan(np.radians(60)), hanging, np.nan),
    )
    there = np.isfinite(lip)
    return np.column_stack([x, y, lip + noise * rng.standard_normal(len(x))])[there]


def strayed(picks, count: int = 6):
    """The picks with some of the hanging lip near the middle of the fault lifted to the other, and which."""
    near = np.flatnonzero((np.abs(picks[:, 0]) < 120) & (picks[:, 1] > 30) & (picks[:, 1] < 80))[:count]
    profile = THROW * (1 - (picks[near, 0] / LENGTH) ** 2) ** 1.5
    result = picks.copy()
    result[near, 2] += profile
    return result, near


def smeared_picks(width: float):
    picks = sharp_picks()
    return np.column_stack([picks[:, :2], faulted(picks[:, 0], picks[:, 1], width)])


def _dipping(ratio: float, dip: float = 40.0):
    """A plane that dips as the fault, with ``ratio`` of its slope."""
    return lambda x, y: 0 * x - ratio * np.tan(np.radians(dip)) * y


_OBJECTS = ("H", "F")
STRAYED, WHICH = strayed(sharp_picks())


def _warns(name, made, place) -> Case:
    return Case(name, "horizon", made, place, _OBJECTS, "warn", "warn")


FAILING: tuple[Case, ...] = (
    Case("hole beside the trace", "horizon", model(faulted, around(7, 107)), (7, 57, -30), _OBJECTS),
    Case(
        "hole at the trace",
        "horizon",
        model(faulted, around(7, 7)),
        (7, 15, None),
        _OBJECTS,
        follows=("trace",),
    ),
    Case(
        "two holes of different width",
        "horizon",
        model(faulted, lambda x, y: around(-193, 107)(x, y) | around(157, -118, 30)(x, y)),
        [(-193, 57, -25), (157, -43, 27)],
        _OBJECTS,
    ),
    _warns("hole that is filled", model(faulted, around(7, 7), grid=True), (7, 15, None)),
    _warns("slope of 0.9 of the fault's", model(_dipping(0.9), dip=40.0), (0, 0, 0)),
    _warns("picks on the wrong side", model(faulted, picks=STRAYED), STRAYED[WHICH]),
    _warns("smear wider than gamma", model(lambda x, y: faulted(x, y, 80.0)), (0, 0, 0)),
)


def _passes(name, made) -> Case:
    return Case(name, "horizon", made, objects=())


PASSING: tuple[Case, ...] = (
    _passes("hole beyond gamma", model(faulted, around(7, 207))),
    _passes("bay of the boundary", model(faulted, around(7, 407, 20, 310))),
    _passes("slope of 0.7 of the fault's", model(_dipping(0.7), dip=40.0)),
    _passes("slope against the fault", model(_dipping(-0.9), dip=40.0)),
    _passes("picks on both lips", model(faulted, picks=sharp_picks())),
    _passes("picks that are smeared", model(faulted, picks=smeared_picks(40.0))),
    _passes("picks of much noise", model(faulted, picks=sharp_picks(noise=15.0))),
    _passes("smear narrower than gamma", model(lambda x, y: faulted(x, y, 40.0))),
)
