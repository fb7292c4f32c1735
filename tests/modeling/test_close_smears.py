"""The smear of faults that run close to each other: steps of known width, throw and place."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ndtr

from graben.arrays import FloatArray
from graben.cutgraph import CutGraph
from graben.model import Horizon
from graben.modeling.close_smears import close_faults, close_smear, unsmeared
from graben.modeling.smears import smear_widths
from tests.modeling.test_close_faults import straight
from tests.models import grid_horizon

GAMMAS = {0: 400.0, 1: 400.0}
#: Half the steps of the two faults: a stair, a graben.
HALVES = [(50.0, 30.0), (-40.0, 40.0)]


def strip(apart: float, turned: float = 0.35) -> tuple[CutGraph, FloatArray]:
    """Two parallel faults through the whole horizon and the unit vector across them, turned off the grid."""
    right, way = np.array([[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]])
    places = apart * np.array([-0.5, 0.5])
    lines = [(tuple(x * right - 3000.0 * way), tuple(x * right + 3000.0 * way)) for x in places]
    return straight(*lines), right


def smeared(
    apart: float, width: float, halves: tuple[float, float], noise: float = 0.0
) -> tuple[Horizon, CutGraph, FloatArray]:
    """A sloping horizon with both steps smeared, the cut graph, and the elevations without the smear."""
    graph, right = strip(apart)

    def height(x: FloatArray, y: FloatArray, w: float) -> FloatArray:
        across = x * right[0] + y * right[1]
        steps = [
            np.sign(d) if w == 0.0 else 2.0 * ndtr(d / w) - 1.0
            for d in (across + apart / 2, across - apart / 2)
        ]
        return 0.05 * x - 0.02 * y - 1e-5 * across**2 - halves[0] * steps[0] - halves[1] * steps[1]

    rng = np.random.default_rng(3)
    horizon = grid_horizon(lambda x, y: height(x, y, width) + noise * rng.standard_normal(np.shape(x)))
    x, y, _ = horizon.surface.vertices.T
    return horizon, graph, height(x, y, 0.0)


@pytest.mark.parametrize("halves", HALVES)
@pytest.mark.parametrize("width", [40.0, 80.0, 120.0])
@pytest.mark.parametrize("apart", [300.0, 450.0, 600.0])
def test_widths_are_found_where_each_smear_reaches_the_other_fault(apart, width, halves) -> None:
    horizon, graph, _ = smeared(apart, width, halves)
    assert smear_widths(horizon, graph, GAMMAS) == pytest.approx([width] * 2, rel=0.05)


def test_noise_leaves_the_widths() -> None:
    horizon, graph, _ = smeared(300.0, 60.0, HALVES[0], noise=2.0)
    assert smear_widths(horizon, graph, GAMMAS) == pytest.approx([60.0] * 2, rel=0.1)


@pytest.mark.parametrize("halves", HALVES)
@pytest.mark.parametrize("width", [40.0, 80.0, 120.0])
def test_without_the_smear_a_strip_lies_where_it_did(width, halves) -> None:
    """Its middle, 1.25 widths from both faults at worst, had lost up to a fifth of both steps."""
    horizon, graph, sharp = smeared(300.0, width, halves)
    points = horizon.surface.vertices
    x, y = points[:, 0], points[:, 1]
    _, right = strip(300.0)
    middle = np.abs(x * right[0] + y * right[1]) < 75.0
    middle &= np.hypot(x, y) < 1500.0
    found = unsmeared(points[middle], horizon, graph, GAMMAS)
    assert found == pytest.approx(sharp[middle], abs=0.02 * np.abs(halves).max())
    assert np.abs(points[middle, 2] - sharp[middle]).max() > 0.02 * np.abs(halves).max()


def test_sharp_steps_are_left_alone() -> None:
    horizon, graph, sharp = smeared(300.0, 0.0, HALVES[0])
    assert [close_smear(horizon, graph, f, GAMMAS) for f in (0, 1)] == [None, None]
    assert unsmeared(horizon.surface.vertices, horizon, graph, GAMMAS) == pytest.approx(sharp)


def test_noise_is_no_step() -> None:
    horizon, graph, _ = smeared(300.0, 60.0, (0.0, 0.0), noise=2.0)
    assert [close_smear(horizon, graph, f, GAMMAS) for f in (0, 1)] == [None, None]


def test_faults_are_close_where_their_zones_overlap() -> None:
    assert close_faults(strip(700.0)[0], 0, GAMMAS) == (1,)
    assert close_faults(strip(900.0)[0], 0, GAMMAS) == ()


def test_faults_that_meet_are_not_close() -> None:
    graph = straight(((0.0, -1000.0), (0.0, 1000.0)), ((300.0, 1000.0), (0.0, 0.0)))
    ends = np.flatnonzero(np.hypot(*graph.nodes[:, :2].T) < 1e-9)
    edges = np.where(graph.edges == ends[1], ends[0], graph.edges)
    met = CutGraph(graph.horizon, graph.nodes, graph.kinds, edges, graph.faults)
    assert close_faults(graph, 0, GAMMAS) == (1,)
    assert close_faults(met, 0, GAMMAS) == close_faults(met, 1, GAMMAS) == ()


def test_nothing_moves_where_no_smear_reaches() -> None:
    horizon, graph, _ = smeared(300.0, 60.0, HALVES[0])
    points, right = horizon.surface.vertices, strip(300.0)[1]
    far = points[np.abs(points[:, :2] @ right) > 8.0 * 60.0 + 150.0]
    assert unsmeared(far, horizon, graph, GAMMAS) == pytest.approx(far[:, 2], abs=1e-9)
