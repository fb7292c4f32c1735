"""The zoo of functional: what covers a place of the plan twice or stands upright; and what nearly does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.model import Horizon, Model
from graben.settings import Parameters
from graben.surface import Surface
from tests.zoo.cases import Case
from tests.zoo.shapes import STEP, dipping, faults, folded_points, joined, level, scene, sheet, two_triangles


def _ramp(turn: float, steps: int):
    """A ramp that goes round and up, ``turn`` radians a step."""

    def place(i, j):
        radius = 300 - 200 * j
        return radius * np.cos(turn * i), radius * np.sin(turn * i), 10 * i

    return sheet(steps, 1, place, "H")


def _horizon(surface: Surface) -> Model:
    return faults(horizons=[Horizon("H", replace(surface, name="H"), STEP)])


def _limb(dip: float) -> Model:
    return faults(horizons=[level(points=folded_points(dip))])


_UPRIGHT = dipping(90).moved(np.array([0.0, 40, 0]))
_CURVED = sheet(6, 8, lambda i, j: (STEP * i, 150 * np.sin(j / 3) - 50, -STEP * (j - 3)))
_STACKED = joined(
    sheet(4, 4, lambda i, j: (STEP * i, STEP * j, 0 * i)),
    sheet(2, 2, lambda i, j: (60 + 20 * i, 60 + 20 * j, 90 + 0 * i)),
)
_FOLD = sheet(8, 2, lambda i, j: (100 * np.sin(i / 2), STEP * j, STEP * i))
_ALONG = (-75.0, 0.0, 75.0)
_STRAY = (20.0, -20.0, 900.0)


def _strayed() -> Model:
    """Points of a level horizon, one of them far above its neighbours."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(-300.0, 301, 20), np.arange(-300.0, 301, 20)))
    points = np.stack([x, y, 0 * x], axis=1)
    points[(points[:, :2] == _STRAY[:2]).all(axis=1)] = _STRAY
    return faults(horizons=[level(points=points)])


def _reverse() -> Model:
    """Both lips of a reverse fault in the points of a horizon, one above the other by 2.4 steps."""
    fault = dipping(60, 24, 16).moved(np.array([-600.0, -200, 350]))
    cut, half = -200 + 350 / np.tan(np.radians(60)), 60 / np.tan(np.radians(60))
    x, y = (a.ravel() for a in np.meshgrid(np.arange(-590, 600, 20.0), np.arange(0, 300, 20.0)))
    lips = [np.stack([x, cut + s * (y - half), 60 * s + 0 * x], axis=1) for s in (1, -1)]

    def smeared(i, j):
        return STEP * (i - 16), STEP * (j - 8), 60 * np.tanh((STEP * (j - 8) - cut) / 40)

    top = Horizon("H", sheet(32, 16, smeared, "H"), STEP, picks=np.concatenate(lips))
    return faults(fault, horizons=[top], parameters=Parameters(gamma=2 * STEP))


def _case(name, model, place, *objects: str) -> Case:
    return Case(name, "functional", model, place, objects or ("H",), blocks=True)


def _fault(name, model, place) -> Case:
    return Case(name, "functional", model, place, extended="warn")


FAILING: tuple[Case, ...] = (
    _fault("vertical fault", scene(_UPRIGHT), None),
    # the limb under the nose is overturned, the most so at its end
    _fault(
        "overturned fault",
        scene(_CURVED),
        [(x, 150 * np.sin(7.5 / 3) - 50, -4.5 * STEP) for x in (50, 150, 250)],
    ),
    _case("spiral ramp", _horizon(_ramp(0.2, 40)), None),
    _case("two sheets", _horizon(_STACKED), (80, 80, 90)),
    _case("folded sheet", _horizon(_FOLD), [(24, y, 25) for y in (25, 75)]),
    _case("vertical limb", _limb(90), [(0, y, 400) for y in _ALONG]),
    _case("overturned limb", _limb(110), [(-127, y, 350) for y in _ALONG]),
    _case("limb of 88 degrees", _limb(88), [(14, y, 400) for y in _ALONG]),
    _case("one stray pick", _strayed(), _STRAY),
)


def _passes(name, model, *follows: str) -> Case:
    return Case(name, "functional", model, objects=(), follows=follows)


_BOW = sheet(6, 4, lambda i, j: (STEP * i, 30 * j + 40 * np.cos(i), -STEP * j))
_SIDE_BY_SIDE = joined(level().surface, level().surface.moved(np.array([8.5 * STEP, 0, 200])))

PASSING: tuple[Case, ...] = (
    _passes("two triangles", faults(two_triangles())),
    _passes("89.8 degrees", scene(dipping(89.8).moved(np.array([0.0, 40, 0])))),
    _passes("bow", scene(_BOW)),
    _passes("three quarters of a ramp", _horizon(_ramp(0.25, 24))),
    _passes("pieces side by side", _horizon(_SIDE_BY_SIDE)),
    _passes("limb of 75 degrees", _limb(75)),
    _passes("reverse fault", _reverse()),
)
