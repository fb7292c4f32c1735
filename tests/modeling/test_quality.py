"""Doubts about throws: none about a fault as it should be, and each defect is named where it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.arrays import floats
from graben.demo import build as demo
from graben.modeling.beyond import step_beyond
from graben.modeling.quality import Doubt, judged, jumps
from graben.modeling.results import HorizonResult
from graben.pipeline import build
from graben.surface import Surface
from tests.modeling.test_throws import with_throw
from tests.models import model_of_demo
from tests.reports import sample
from tests.reports.sample import GAMMA, ORIGIN

MODEL = sample.model()
DEPTHS = sample.model(depth=True)


def on_input(result: HorizonResult, z: np.ndarray) -> HorizonResult:
    """The same result from an input with other elevations."""
    surface = result.horizon.surface
    points = np.column_stack([surface.vertices[:, :2], z])
    return replace(
        result, horizon=replace(result.horizon, surface=Surface("Top A", points, surface.triangles))
    )


def stepping(result: HorizonResult, step: float) -> HorizonResult:
    """The same result from an input that steps along the whole line of the fault and on beyond its ends."""
    x, y, z = result.horizon.surface.vertices.T
    return on_input(result, z - 0.5 * step * np.tanh((x - sample.trace(y)) / 60.0))


@pytest.mark.parametrize("throw", [138.0, -138.0])
def test_a_fault_as_it_should_be_is_not_doubted(throw):
    assert judged(sample.cut_result(throw=throw), MODEL).doubts == ()
    assert judged(sample.uncut_result("Top A"), MODEL).doubts == ()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_fault_that_goes_on_is_named_at_both_ends_with_its_step(sign):
    result = stepping(sample.cut_result(throw=sign * 138.0), sign * 60.0)
    found = judged(result, MODEL).doubts
    assert [d.kind for d in found] == [Doubt.NO_TIP, Doubt.NO_TIP]
    (line,) = result.cutoffs
    for doubt, row in zip(found, (0, -1), strict=True):
        np.testing.assert_allclose(doubt.place, line.foot[row])
        # The trace bends by 60 m where its last direction goes straight on.
        assert doubt.value == pytest.approx(sign * 60.0, rel=0.15)
        assert "F1" in str(doubt)
        assert "Top A" in str(doubt)


def test_a_step_against_the_throw_is_not_of_this_fault():
    assert judged(stepping(sample.cut_result(), -60.0), MODEL).doubts == ()


@pytest.mark.parametrize("turn", [0.0, 37.0, 180.0])
def test_step_beyond_is_exact_for_planes_whatever_the_strike(turn):
    a = np.radians(turn)
    way, right = np.array([np.sin(a), np.cos(a)]), np.array([np.cos(a), -np.sin(a)])
    result = sample.cut_result()
    middle = result.horizon.surface.vertices[:, :2].mean(axis=0)
    to = result.horizon.surface.vertices[:, :2] - middle
    d = to @ right
    result = on_input(result, 7.0 + to @ [0.1, -0.2] - 0.5 * 40.0 * np.sign(d))
    line = middle + np.linspace(-600.0, 600.0, 9)[:, None] * way
    for last in (False, True):
        step = step_beyond(result, MODEL, "F1", line, last)
        assert step is not None
        assert step.value == pytest.approx(40.0)
        assert step.clear
    # Beyond an end at the outline is nothing to look at.
    outside = line + 5000.0 * way
    assert step_beyond(result, MODEL, "F1", outside, True) is None


def test_a_place_without_throw_is_named():
    result = sample.cut_result()
    (line,) = result.cutoffs
    middle = len(line.s) // 2
    waist = 1.0 - np.exp(-(((np.arange(len(line.s)) - middle) / 4.0) ** 2))
    (doubt,) = judged(with_throw(result, line.throw * waist), MODEL).doubts
    assert doubt.kind is Doubt.NO_THROW
    assert doubt.place[1] == pytest.approx(line.foot[middle, 1], abs=1.0)


def test_a_fault_that_turns_is_named_once():
    result = sample.cut_result()
    (line,) = result.cutoffs
    r = np.linspace(-1.0, 1.0, len(line.s))
    (doubt,) = judged(with_throw(result, 138.0 * np.sin(np.pi * r) * -1.0), MODEL).doubts
    assert doubt.kind is Doubt.TURN
    assert "normal to reverse" in str(doubt)


@pytest.mark.parametrize("row", [8, 20, 30])
def test_a_jump_is_named_where_it_is(row):
    result = sample.cut_result()
    (line,) = result.cutoffs
    throw = line.throw + np.where(np.arange(len(line.s)) > row, 40.0, 0.0)
    throw[-1] = 0.0
    found = [d for d in judged(with_throw(result, throw), MODEL).doubts if d.kind is Doubt.JUMP]
    assert [d.place[1] for d in found] == [pytest.approx(line.foot[row, 1], abs=1.0)]
    assert found[0].value == pytest.approx(40.0, abs=12.0)


@pytest.mark.parametrize(
    "profile",
    [
        lambda r: (1 - r**2) ** 1.5,
        lambda r: np.sqrt(1 - r**2),  # of a crack, steep at the tips
        lambda r: 1 - np.abs(r),  # peaked
        lambda r: np.minimum(1, 3 * (1 - np.abs(r))),  # flat, with corners
        lambda r: 1 - r**2 + 0.1 * np.cos(9 * r),
    ],
)
@pytest.mark.parametrize("count", [11, 41, 161])
def test_smooth_profiles_do_not_jump(profile, count):
    r = np.linspace(-1.0, 1.0, count)
    assert len(jumps(r, 100.0 * profile(r), 5.0)) == 0


def test_uneven_nodes_do_not_make_jumps():
    s = np.cumsum(np.random.default_rng(5).uniform(0.2, 1.8, 60))
    assert len(jumps(s, 3.0 * s, 0.1)) == 0
    assert len(jumps(s[:3], s[:3], 0.1)) == 0


def test_where_the_iteration_failed_nothing_else_is_said():
    result = stepping(sample.cut_result(), 60.0)
    ended = sample.failed_run().horizons[0].subdomains
    assert judged(replace(result, subdomains=ended), MODEL).doubts == ()


def test_sentences_name_horizons_and_count_z_as_the_model_does():
    result = stepping(sample.cut_result(), 60.0)
    told = [str(doubt) for doubt in judged(result, DEPTHS).doubts]
    assert len(told) == 2
    assert all("depth 2" in text or "depth 1" in text for text in told)
    z = result.cutoffs[0].foot[0, 2]
    assert f"depth {-z:.5g}" in told[0]
    assert f"elevation {z:.5g}" in str(judged(result, MODEL).doubts[0])


def test_a_name_with_braces_is_only_a_name():
    name = "F{0}{place}%s" + sample.EVIL
    result = stepping(sample.cut_result(fault_name=name), 60.0)
    (first, _) = judged(result, sample.model(name)).doubts
    assert name in str(first)


def test_warnings_tell_the_doubts_after_those_that_stood_before():
    result = replace(stepping(sample.cut_result(), 60.0), warnings=("before",))
    told = judged(result, MODEL)
    assert len(told.doubts) == 2
    assert told.warnings == ("before", *(str(doubt) for doubt in told.doubts))


def test_doubts_do_not_depend_on_where_the_model_lies():
    offset = floats([-ORIGIN[0], -ORIGIN[1], 2000.0])
    result = stepping(sample.cut_result(), 60.0)
    here, there = judged(result, MODEL).doubts, judged(result.moved(offset), MODEL.moved(offset)).doubts
    assert [d.kind for d in here] == [d.kind for d in there]
    np.testing.assert_allclose([d.value for d in here], [d.value for d in there], rtol=1e-6)


def test_gamma_is_what_the_window_is_made_of():
    assert MODEL.gamma(MODEL.faults[0], MODEL.horizons[0]) == GAMMA


def test_a_fault_picked_too_short_is_told_by_the_throw_that_it_cuts_off():
    """The model `single` as it is, and with its fault cut off in the middle, where its throw is 138 m."""
    whole = model_of_demo(demo("single"), gamma=400.0)
    (fault,) = whole.faults
    v, t = fault.surface.vertices, fault.surface.triangles
    middle = v[:, 1].mean()
    used, local = np.unique(t[(v[t][:, :, 1] <= middle).all(axis=1)], return_inverse=True)
    short = Surface(fault.name, v[used], local.reshape(-1, 3))
    model = replace(whole, faults=(replace(fault, surface=short),))
    (as_it_is,), (cut_off,) = build(whole).horizons, build(model).horizons
    assert judged(as_it_is, whole).doubts == ()
    assert cut_off.converged
    (doubt,) = judged(cut_off, model).doubts
    assert doubt.kind is Doubt.NO_TIP
    assert doubt.place[1] == pytest.approx(middle, abs=300.0)
    assert doubt.value == pytest.approx(as_it_is.largest_throw, rel=0.05)
    assert cut_off.largest_throw < 0.7 * as_it_is.largest_throw
