"""The zoo of oriented: triangles that face another way than their neighbours; and sheets turned over."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.surface import Surface
from tests.zoo.cases import Case
from tests.zoo.manifold import FAN, perforated
from tests.zoo.shapes import F60, STEP, dipping, faults, scene, two_triangles


def _turned(surface: Surface, which=slice(None)) -> Surface:
    triangles = surface.triangles.copy()
    triangles[which] = triangles[which][:, ::-1]
    return replace(surface, triangles=triangles)


def _one_sided(count: int = 24, radius: float = 4 * STEP, width: float = 2 * STEP) -> Surface:
    """An upright ring with half a twist where it rises steeply, so that it dips steeply all round."""
    angle = 2 * np.pi * np.arange(count) / count
    rise = np.clip(np.where(angle > np.pi, angle - 2 * np.pi, angle) / 0.9, -1, 1)
    twist = np.pi * (0.5 + 0.5 * rise)
    out = np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
    way = np.cos(twist)[:, None] * out + np.sin(twist)[:, None] * [0.0, 1.0, 0.0]
    inner, outer = (radius * out + side * width * way for side in (-0.5, 0.5))
    # behind the twist the two rims have changed places: the band closes crosswise where angle is pi
    k = np.arange(count)
    after = (k + 1) % count
    swapped = k == count // 2
    a, b = np.where(swapped, k + count, k), np.where(swapped, k, k + count)
    band = [np.stack([a, b, after], axis=1), np.stack([after, b, after + count], axis=1)]
    return Surface("F", np.concatenate([inner, outer]), np.concatenate(band))


def _case(name, model, place, *follows: str, objects=("F",)) -> Case:
    return Case(name, "oriented", model, place, objects, follows=follows)


_CUT = scene(F60)
_TOP = _CUT.horizons[0].surface
_HORIZON = replace(_CUT, horizons=(replace(_CUT.horizons[0], surface=_turned(_TOP, [40])),))

FAILING: tuple[Case, ...] = (
    _case("one turned", scene(_turned(F60, [7])), F60.vertices[F60.triangles[7]].mean(axis=0)),
    # each cell has one triangle in either half, so that the edge between the two is wrong in all of them
    _case("half turned", faults(_turned(F60, slice(24, 48))), None),
    _case("one cell turned", scene(_turned(F60, [9, 33])), F60.vertices[[11, 17]].mean(axis=0)),
    _case(
        "one turned in a horizon", _HORIZON, _TOP.vertices[_TOP.triangles[40]].mean(axis=0), objects=("H",)
    ),
    _case("one-sided band", faults(_one_sided()), None, "functional"),
)


def _passes(name, model, *follows: str) -> Case:
    return Case(name, "oriented", model, objects=(), follows=follows)


PASSING: tuple[Case, ...] = (
    _passes("two triangles", faults(two_triangles())),
    _passes("turned as a whole", scene(_turned(F60))),
    _passes("holes", faults(perforated((1, 3), (4, 2))), "manifold"),
    _passes("fan", faults(FAN)),
    _passes(
        "two faults turned against each other",
        scene(F60, _turned(dipping(60, name="G").moved(np.array([0, -3 * STEP, 0])))),
    ),
)
