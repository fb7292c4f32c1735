"""The zoo of strongly-connected: faults in pieces; and faults with holes, horizons in pieces."""

from __future__ import annotations

import numpy as np

from graben.model import Horizon
from tests.zoo.cases import Case
from tests.zoo.duplicate import cracked, slit
from tests.zoo.manifold import FAN, perforated
from tests.zoo.shapes import F60, STEP, dipping, faults, joined, level, scene, two_triangles, without


def _case(name, model, place, *follows: str) -> Case:
    return Case(name, "strongly-connected", model, place, follows=follows)


_APART = joined(dipping(60, 3, 4), dipping(60, 2, 4).moved(np.array([5 * STEP, 0, 0])))
_CRUMB = joined(F60, two_triangles().moved(np.array([-3 * STEP, 0, 0])))
_ABOVE = joined(F60, dipping(60, 2, 1).moved(np.array([100.0, -50, 86.6])))
_AT_A_CORNER = without(dipping(60, 3, 2), [1, 7, 2, 8, 4, 10])

FAILING: tuple[Case, ...] = (
    # each piece cuts the horizon, so that the trace is in pieces too
    _case("two pieces that are cut", scene(_APART), (300, 50, -86.6), "trace"),
    _case("a piece above", scene(_ABOVE), (150, -37.5, 65)),
    _case("crumb", faults(_CRUMB), (-125, 12.5, -21.7)),
    _case("joined in a corner", faults(_AT_A_CORNER), (25, 12.5, -21.7), "manifold"),
)


def _passes(name, model, *follows: str) -> Case:
    return Case(name, "strongly-connected", model, objects=(), follows=follows)


_SIDE_BY_SIDE = joined(level().surface, level().surface.moved(np.array([8.5 * STEP, 0, 200])))

PASSING: tuple[Case, ...] = (
    _passes("two triangles", faults(two_triangles())),
    _passes("a hole", scene(perforated((2, 3))), "manifold"),
    _passes("cracked between equal vertices", faults(cracked()), "duplicate"),
    _passes("slit almost through", scene(slit(0.01))),
    _passes("fan", faults(FAN)),
    _passes("a horizon in pieces", faults(horizons=[Horizon("H", _SIDE_BY_SIDE, STEP)])),
)
