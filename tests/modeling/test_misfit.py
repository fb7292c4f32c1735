"""Misfit by distance and what was left out, against inputs that differ from the result by known amounts."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from graben.arrays import floats
from graben.modeling.misfit import BINS, Misfit, misfit_of
from graben.modeling.products import polygons_of
from graben.modeling.results import HorizonResult
from graben.surface import Surface
from tests.reports import sample

MODEL = sample.model()


def made_of_itself(result: HorizonResult, shift: float = 0.0) -> HorizonResult:
    """The result as if its own nodes, moved up by ``shift``, had been picked."""
    picks = result.surface.vertices[result.side == 0] + [0.0, 0.0, shift]
    return replace(result, horizon=replace(result.horizon, picks=floats(picks)))


@pytest.mark.parametrize("throw", [300.0, -300.0])
@pytest.mark.parametrize("shift", [0.0, 5.0])
def test_picks_on_the_result_differ_by_what_they_were_moved(throw, shift):
    result = made_of_itself(sample.cut_result(throw=throw), shift)
    bins = misfit_of(result, MODEL)().bins
    assert [(b.near, b.far) for b in bins] == [
        (low * sample.GAMMA, high * sample.GAMMA) for low, high in pairwise(BINS)
    ]
    known = [b for b in bins if b.count]
    assert known
    assert all(b.gap == 0 for b in bins)
    np.testing.assert_allclose([b.mean for b in known], shift, atol=1e-6)
    np.testing.assert_allclose([b.rms for b in known], shift, atol=1e-6)


def test_bins_count_every_point_once_and_gaps_apart():
    result = sample.cut_result(throw=400.0)
    bins = misfit_of(result, MODEL)().bins
    import shapely

    places = result.horizon.surface.vertices[:, :2]
    trace = shapely.linestrings(result.graph.nodes[:, :2])
    away = shapely.distance(shapely.points(places), trace)
    assert sum(b.count + b.gap for b in bins) == np.count_nonzero(away < BINS[-1] * sample.GAMMA)
    gap = shapely.union_all([p.shape for p in polygons_of(result)])
    assert sum(b.gap for b in bins) == shapely.contains_xy(gap, places).sum() > 10


def test_nodes_of_the_zone_are_left_out_and_counted():
    result = sample.cut_result()
    (told,) = misfit_of(result, MODEL)().masked
    assert told.what == "nodes"
    assert told.within == told.left_out > 100


def test_picks_that_jump_at_the_fault_are_used_and_smeared_ones_are_not():
    sharp = made_of_itself(sample.cut_result(throw=138.0))
    smeared = replace(sharp, horizon=replace(sharp.horizon, picks=sharp.horizon.surface.vertices))
    (told,), (other,) = misfit_of(sharp, MODEL)().masked, misfit_of(smeared, MODEL)().masked
    assert (told.what, told.left_out) == ("picks", 0)
    assert other.left_out == other.within > 0


def test_an_uncut_horizon_has_neither():
    assert misfit_of(sample.uncut_result("Top A"), MODEL)() == Misfit()


def test_nothing_depends_on_where_the_model_lies():
    offset = floats([500_000.0, 500_000.0, 0.0])
    result = sample.cut_result()
    here, there = misfit_of(result, MODEL)().bins, misfit_of(result.moved(offset), MODEL.moved(offset))().bins
    assert [(b.count, b.gap) for b in here] == [(b.count, b.gap) for b in there]
    np.testing.assert_allclose([b.rms for b in here], [b.rms for b in there], rtol=1e-6)


def test_a_result_that_is_raised_is_raised_everywhere():
    result = sample.cut_result()
    raised = Surface("Top A", result.surface.vertices + np.array([0.0, 0.0, 3.0]), result.surface.triangles)
    for low, high in zip(
        misfit_of(replace(result, surface=raised), MODEL)().bins, misfit_of(result, MODEL)().bins, strict=True
    ):
        # The side of a point is that of the input, so that raising moves the mean alone.
        assert high.mean - low.mean == pytest.approx(3.0)
