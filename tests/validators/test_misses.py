"""Faults that end within a step of a horizon, and horizons that no fault of their area reaches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.arrays import floats
from graben.finding import Finding, Profile, Status
from graben.model import Horizon, Model
from graben.pipeline import check
from graben.stages import examined
from graben.validators.measuring.misses import _clipped, misses
from graben.validators.measuring.reach import reach_of
from tests.zoo.networks import cut, field, flat, plane
from tests.zoo.shapes import STEP


def of_trace(model: Model) -> dict[tuple[str, ...], Finding]:
    return {f.objects: f for f in check(model).of("trace") if f.status is not Status.PASS}


def at(elevation: float, name: str, slope: float = 0.0) -> Horizon:
    """A plane horizon at an elevation in steps."""
    made = field(lambda x, y: slope * x + elevation * STEP)
    return replace(made, surface=replace(made.surface, name=name), name=name)


@pytest.mark.parametrize(
    ("top", "bottom", "where", "way"), [(-0.2, -3.0, "below", "up"), (3.0, 0.2, "above", "down")]
)
def test_a_fault_that_ends_just_short_of_a_horizon_is_named(top, bottom, where, way):
    said = of_trace(cut(field(flat), plane((-5, 0), (5, 0), top=top, bottom=bottom)))
    assert set(said) == {("H", "F")}
    finding = said["H", "F"]
    # ten steps of rim, a fifth of a step off
    assert finding.message == f"F ends 10 m {where} H along 500 m of its rim, and does not cut it."
    assert f"extend F {way} dip through it" in finding.remedy
    assert finding.worst.value == pytest.approx(10.0)


def test_a_miss_is_measured_where_it_is_less_than_a_step():
    # the horizon rises by half a step per step, so that two steps of its rim lie less than a step below it
    slanted = field(lambda x, y: 0.5 * (x + 5 * STEP))
    fault = plane((-5, 0), (5, 0), top=0.0, bottom=-3.0, dip=80.0)
    found = misses(slanted, [fault], [0], 1e-6)[0]
    assert found.length == pytest.approx(2 * STEP)
    assert found.heights == pytest.approx(-0.5 * (found.places[:, 0] + 5 * STEP), abs=1e-6)
    assert np.abs(found.places[:, 2]).max() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    "fault",
    [
        plane((-5, 0), (5, 0), top=-1.1, bottom=-3.0),
        plane((-0.9, 0), (0.9, 0), top=-0.2, bottom=-3.0),
        plane((-5, 9.5), (5, 9.5), top=-0.2, bottom=-3.0, dip=89.0),
    ],
    ids=["more than a step", "shorter than two steps", "at the boundary"],
)
def test_what_is_no_miss(fault):
    assert set(of_trace(cut(field(flat), fault))) == {("F",)}


def test_where_a_fault_ends_on_another_it_misses_nothing():
    rim = plane((-5, 0), (5, 0), top=3.0, bottom=0.2)
    below = plane((-6, 0), (6, 0), "G", top=2.0, bottom=-2.0, dip=30.0)
    on_it = plane((-5, 0), (5, 0), top=3.0, bottom=0.0)
    # both lines run through the origin: at elevation 0 the one ends on the other
    assert misses(at(-0.2, "H"), [on_it, below], [0], 1e-6) == {}
    assert set(misses(at(0.0, "H"), [rim, below], [0], 1e-6)) == {0}


def test_a_horizon_above_all_faults_of_its_area_is_told_where_another_is_cut():
    deep, shallow = at(0.0, "H"), at(5.0, "S")
    model = replace(cut(deep, plane((-5, 0), (5, 0))), horizons=(deep, shallow))
    said = of_trace(model)
    assert set(said) == {("S",)}
    # the fault ends two steps above the elevation of its line
    assert said[("S",)].message == "S lies 150 m above all faults of its area, and none cuts it."
    assert all(word in said[("S",)].remedy for word in ("sign of z", "unit of S and of F"))
    assert of_trace(replace(model, horizons=(deep,))) == {}


def test_how_far_a_fault_should_reach_is_told_all_along_it_where_steps_are_coarse():
    """The narrower the zone beside a trace, the fewer nodes tell its trend: the windows grow longer."""
    fault = plane((-8, -1.3), (8, 1.4), parts=(8, 4))
    model = cut(field(), fault, gamma=1.6)
    (horizon,) = model.horizons
    graph = examined(model, Profile.EXTENDED, lambda stage, what: None)[1].graphs["H"]
    reach = reach_of(horizon, [f.surface for f in model.faults], graph, 0, {0: 1.6 * STEP}, 1e-6)
    assert reach.length.sum() == pytest.approx(np.hypot(16.0, 2.7) * STEP, rel=0.05)


def test_a_rim_of_any_length_is_looked_at_where_the_horizon_is():
    low, high = floats([0.0, 0.0, -10.0]), floats([100.0, 50.0, 10.0])
    a = floats([[-1e12, 25.0, 0.0], [50.0, 10.0, 3.0], [50.0, 60.0, 0.0], [0.0, 0.0, -20.0]])
    b = floats([[1e12, 25.0, 0.0], [60.0, 20.0, 3.0], [70.0, 60.0, 0.0], [40.0, 40.0, 20.0]])
    start, end = _clipped(a, b, low, high)
    # through the box, inside it, beside it, in and out through its bottom and its top
    assert start == pytest.approx(
        floats([[0.0, 25.0, 0.0], [50.0, 10.0, 3.0], [10.0, 10.0, -10.0]]), abs=1e-3
    )
    assert end == pytest.approx(floats([[100.0, 25.0, 0.0], [60.0, 20.0, 3.0], [30.0, 30.0, 10.0]]), abs=1e-3)
