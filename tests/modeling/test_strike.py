"""Layers on both walls of a fault and where they meet, against rectangles of known area."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from graben.arrays import floats
from graben.modeling.results import Cutoff, HorizonResult
from graben.modeling.strike import Strike, juxtaposed, stretches_on
from graben.surface import Surface
from tests.models import grid_triangles
from tests.reports import sample

LENGTH = 1000.0


def wall(turn: float = 0.0) -> Surface:
    """A vertical wall, LENGTH long; its strike is ``turn`` degrees clockwise from north."""
    a = np.radians(turn)
    s, z = np.meshgrid(np.linspace(0.0, LENGTH, 6), [-900.0, 0.0], indexing="ij")
    points = np.stack([s * np.sin(a), s * np.cos(a), z], axis=-1).reshape(-1, 3)
    return Surface("W", points, grid_triangles(6, 2))


def cut_by_wall(name: str, z: float, throw: float, turn: float = 0.0, rows: int = 11) -> HorizonResult:
    """A level horizon whose hanging wall lies ``throw`` deeper all along the wall."""
    a, s = np.radians(turn), np.linspace(0.0, LENGTH, rows)
    foot = np.stack([s * np.sin(a), s * np.cos(a), np.full(rows, z)], axis=1)
    hanging = foot - [0.0, 0.0, throw]
    line = Cutoff("W", s, hanging, foot, np.full(rows, throw), np.zeros(rows))
    return replace(sample.cut_result(name), cutoffs=(line,))


@pytest.mark.parametrize("turn", [0.0, 30.0, 77.0, 120.0])
def test_places_along_strike_begin_where_the_fault_does(turn):
    result = cut_by_wall("A", -100.0, 30.0, turn)
    fault = wall(turn)
    (line,) = stretches_on([result], fault)
    assert line.along.min() == pytest.approx(0.0, abs=1e-9)
    assert line.along.max() == pytest.approx(LENGTH)
    assert Strike.of(fault).along(fault.vertices).min() == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(line.hanging[:, 0], line.foot[:, 0])
    np.testing.assert_array_equal(line.throw, 30.0)


def horizons(throw: float) -> list[HorizonResult]:
    """Three levels 50 and 70 apart, out of order."""
    return [
        cut_by_wall(n, z, throw, rows=r) for n, z, r in (("B", -50.0, 7), ("C", -120.0, 5), ("A", 0.0, 9))
    ]


@pytest.mark.parametrize("throw", [0.0, 20.0, 60.0, -30.0, 500.0])
def test_layers_meet_over_what_their_depths_share(throw):
    found = juxtaposed(horizons(throw), wall())
    assert (
        [layer.name for layer in found.foot]
        == [layer.name for layer in found.hanging]
        == ["A to B", "B to C"]
    )
    tops = {"A to B": (0.0, -50.0), "B to C": (-50.0, -120.0)}
    for layer in (*found.foot, *found.hanging):
        top, base = tops[layer.name]
        assert layer.shape.area == pytest.approx(LENGTH * (top - base))
    shared = {
        (f, h): LENGTH * max(min(tops[f][0], tops[h][0] - throw) - max(tops[f][1], tops[h][1] - throw), 0.0)
        for f in tops
        for h in tops
    }
    told = {(m.foot.name, m.hanging.name): m.area for m in found.meetings}
    assert told.keys() == {pair for pair, area in shared.items() if area > 0}
    assert all(area == pytest.approx(shared[pair]) for pair, area in told.items())


def test_layers_that_swap_their_order_have_no_negative_part():
    upper, lower = cut_by_wall("A", 0.0, 10.0), cut_by_wall("B", -50.0, 10.0)
    (line,) = lower.cutoffs
    tilt = np.linspace(0.0, 100.0, len(line.s))[:, None] * [0.0, 0.0, 1.0]
    crossing = replace(line, hanging=line.hanging + tilt, foot=line.foot + tilt)
    found = juxtaposed([upper, replace(lower, cutoffs=(crossing,))], wall())
    # A triangle of half the length and a height of 50.
    assert found.foot[0].shape.area == pytest.approx(LENGTH / 2 * 50.0 / 2)
    assert all(shapely.is_valid(layer.shape) for layer in (*found.foot, *found.hanging))


def test_a_junction_parts_a_line_and_its_layers_stay_whole():
    result = cut_by_wall("A", 0.0, 20.0)
    (line,) = result.cutoffs
    twice = np.sort(np.append(np.arange(11), 5))
    parted = Cutoff("W", *(getattr(line, k)[twice] for k in ("s", "hanging", "foot", "throw", "heave")))
    parted = replace(parted, hanging=parted.hanging - floats([[0.0, 0.0, 9.0 * (k > 5)] for k in range(12)]))
    lower = cut_by_wall("B", -100.0, 20.0)
    found = juxtaposed([replace(result, cutoffs=(parted,)), lower], wall())
    assert len(found.stretches) == 3
    assert found.foot[0].shape.area == pytest.approx(LENGTH * 100.0)
    assert found.hanging[0].shape.area == pytest.approx(LENGTH * (100.0 - 4.5))


def test_a_fault_with_one_horizon_or_none_has_no_layer():
    assert juxtaposed([cut_by_wall("A", 0.0, 1.0)], wall()).foot == ()
    assert juxtaposed([], wall()).meetings == ()
