"""Rebuilt horizons that cross each other are found, with their place and depth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from graben.demo import build as demo
from graben.model import Horizon, Model
from graben.modeling.crossing import crossings
from graben.modeling.results import HorizonResult
from graben.pipeline import build
from tests.models import grid_horizon, model_of, model_of_demo, plane_fault

TOLERANCE = 0.1
Height = Callable[[np.ndarray, np.ndarray], np.ndarray]


def smeared(throw: float, level: float = 0.0) -> Height:
    def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        taper = np.maximum(1 - (y / 1500.0) ** 2, 0) ** 1.5
        return level - throw / 2 * np.tanh(x / 100.0) * taper

    return height


@cache
def thin_layer() -> tuple[Model, tuple[HorizonResult, ...]]:
    """Two horizons 40 m apart with the same throw of 80 m."""
    return modeled(smeared(80.0), smeared(80.0, -40.0))


def modeled(*heights: Height, dip: float = 60.0) -> tuple[Model, tuple[HorizonResult, ...]]:
    horizons = tuple(grid_horizon(h, name=f"H{k}") for k, h in enumerate(heights))
    one = model_of(horizons[0], plane_fault((0, -1500), (0, 1500), dip=dip))
    model = replace(one, horizons=horizons)
    results = build(model, mend=False).horizons
    assert len(results) == len(heights)
    return model, results


def found(model: Model, horizons: tuple[HorizonResult, ...]):
    return crossings(horizons, [f.surface for f in model.faults], TOLERANCE)


def lowered(result: HorizonResult, place: tuple[float, float], radius: float, by: float) -> HorizonResult:
    """The horizon with its rebuilt nodes near a place moved down, on one side of the fault."""
    v = result.surface.vertices
    near = (np.hypot(v[:, 0] - place[0], v[:, 1] - place[1]) < radius) & ~result.fixed
    assert near.any()
    surface = result.surface.with_vertices(v - np.where(near, by, 0.0)[:, None] * [0.0, 0.0, 1.0])
    return replace(result, surface=surface)


def test_horizons_that_keep_their_distance_do_not_cross() -> None:
    model, horizons = thin_layer()
    assert found(model, horizons) == ()


@pytest.mark.parametrize("dip", [30.0, 60.0])
def test_a_throw_wider_than_the_layer_is_no_crossing(dip: float) -> None:
    """Across the fault the lower horizon may lie above the upper one: normal, reverse, with an overlap."""
    for throw in (80.0, -80.0):
        model, horizons = modeled(smeared(throw), smeared(throw, -20.0), dip=dip)
        assert found(model, horizons) == ()
        assert np.abs(horizons[0].cutoffs[0].throw).max() > 60.0


def test_places_and_depths_are_those_of_the_crossing() -> None:
    model, (upper, lower) = thin_layer()
    bent = lowered(lowered(upper, (250.0, 700.0), 130.0, 55.0), (-250.0, -600.0), 130.0, 47.0)
    for order in ((bent, lower), (lower, bent)):
        (crossing,) = found(model, order)
        assert (crossing.upper, crossing.lower) == ("H0", "H1")
        assert crossing.depths == pytest.approx([15.0, 7.0], abs=2.0)
        assert crossing.places[:, :2] == pytest.approx(
            np.array([[250.0, 700.0], [-250.0, -600.0]]), abs=150.0
        )
        assert "H0 lies below H1 in 2 places once rebuilt, by up to 1" in crossing.warning("m")


def test_a_throw_that_dies_out_downwards_crosses_near_the_fault() -> None:
    """The upper horizon falls by half of 150 m on the hanging side, the lower, 30 m below, does not."""
    model, horizons = modeled(smeared(150.0), smeared(0.0, -30.0))
    (crossing,) = found(model, horizons)
    # Outside the zone they cross already: of what was rebuilt, the hanging side lies too deep.
    assert (crossing.upper, crossing.lower) == ("H0", "H1")
    assert crossing.places[0, 0] > 0.0
    assert abs(crossing.places[0, 1]) < 300.0
    assert 30.0 < crossing.depths[0] < 60.0
    assert any("H0 lies below H1" in warning for warning in horizons[0].warnings)
    assert not horizons[1].warnings


def test_found_in_any_frame() -> None:
    model, (upper, lower) = thin_layer()
    far = np.array([432_000.0, 6_780_000.0, -1500.0])
    here = found(model, (lowered(upper, (250.0, 700.0), 130.0, 55.0), lower))[0]
    bent = lowered(upper, (250.0, 700.0), 130.0, 55.0).moved(far)
    there = found(model.moved(far), (bent, lower.moved(far)))[0]
    assert there.depths == pytest.approx(here.depths, abs=1e-6)
    assert there.places == pytest.approx(here.places + far, abs=1e-6)


@pytest.mark.parametrize("name", ["cross", "tee", "reverse", "exit-both"])
def test_copies_of_a_demo_horizon_below_each_other_do_not_cross(name: str) -> None:
    model = model_of_demo(demo(name))
    (top,) = model.horizons
    surface = replace(top.surface.moved(np.array([0.0, 0.0, -60.0])), name="Base")
    both = replace(model, horizons=(top, Horizon("Base", surface, top.step, top.grid)))
    horizons = build(both, mend=False).horizons
    assert [h.name for h in horizons] == ["Top", "Base"]
    assert all(h.largest_throw > 60.0 for h in horizons), "more than the thickness of the layer"
    assert found(both, horizons) == ()
