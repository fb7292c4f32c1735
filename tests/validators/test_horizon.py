"""What horizon says where the answer is known: distances, slopes, counts of picks and widths of the smear."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ndtr

from graben import demo
from graben.cutgraph import CutGraph
from graben.demo import SyntheticModel
from graben.finding import Element, Finding, Status
from graben.model import Horizon, Model
from graben.modeling.tracing import cut_graph
from graben.pipeline import check
from graben.reading import read_model
from graben.refinement import refined
from graben.validators.context import CheckContext, Defect, Evidence
from graben.validators.horizon import CHECK
from graben.validators.measuring.flanks import robust_fit
from graben.validators.measuring.holes import holes_of
from graben.validators.measuring.parallel import slope_ratios
from graben.validators.measuring.smear import smear_width
from graben.validators.measuring.strays import strays
from tests.models import grid_horizon, model_of_demo
from tests.zoo.horizon import (
    STRAYED,
    THROW,
    WHICH,
    around,
    faulted,
    model,
    sharp_picks,
    smeared_picks,
    strayed,
)

DATA = Path(__file__).parents[2].parent / "shared" / "data"
STEP = 50.0


def graph_of(made: Model) -> CutGraph:
    return cut_graph(made, made.horizons[0], refined([f.surface for f in made.faults]))


def gammas_of(made: Model) -> dict[int, float]:
    return {k: made.gamma(f, made.horizons[0]) for k, f in enumerate(made.faults)}


def defects(made: Model, graph: CutGraph) -> list[Defect]:
    names = frozenset(s.name for s in made.surfaces)
    graphs = MappingProxyType({made.horizons[0].name: graph})
    return CHECK.run(CheckContext(made, names, Evidence(graphs=graphs)))


def finding(made: Model) -> Finding:
    (only,) = check(made).of("horizon")
    return only


def straight(horizon: Horizon, y: float = 0.0) -> CutGraph:
    """A trace along y over the middle of a horizon, in edges of a step."""
    x = np.arange(-500.0, 501.0, STEP)
    k = np.arange(len(x) - 1)
    nodes = np.column_stack([x, 0 * x + y, 0 * x])
    kinds = [1, *[0] * (len(x) - 2), 1]
    return CutGraph(horizon.name, nodes, kinds, np.column_stack([k + 1, k]), 0 * k)


# -- holes


def holed(*places, size=2000.0, **keys) -> Horizon:
    """A level horizon without the nodes within a step or so of some places."""

    def height(x, y):
        gone = np.zeros(x.shape, dtype=bool)
        for px, py, half in places:
            gone |= (np.abs(x - px) < half) & (np.abs(y - py) < half)
        return np.where(gone, np.nan, 0 * x)

    return replace(grid_horizon(height, size, STEP), **keys)


def test_a_hole_has_its_width_its_nodes_and_its_distance():
    horizon = holed((100, 150, 10))  # a diamond of two steps from corner to corner
    (hole,) = holes_of(horizon, straight(horizon))
    assert hole.nodes == 1
    assert hole.width == pytest.approx(np.sqrt(2) * STEP)
    assert sorted(map(tuple, hole.rim[:, :2])) == [(50, 150), (100, 100), (100, 200), (150, 150)]
    assert not hole.filled


@pytest.mark.parametrize(("gamma", "near"), [(90.0, 0), (110.0, 1), (310.0, 2)])
def test_holes_count_within_gamma(gamma, near):
    horizon = holed((100, 150, 10), (-200, -400, 60))  # 100 m and 300 m from the trace
    made = replace(model(faulted, gamma=gamma), horizons=(horizon,))
    found = [p for d in defects(made, straight(horizon)) for p in d.parts if p.kind == "hole"]
    assert len(found) == near
    if near:
        assert found[-1].place[:2] == pytest.approx((100, 100), abs=2)
        assert found[-1].value == pytest.approx(np.sqrt(2) * STEP)
    if near == 2:
        assert found[0].value == pytest.approx(4 * STEP)
        assert found[0].count == 9


def test_the_distance_is_said():
    horizon = holed((100, 150, 10))
    made = replace(model(faulted, gamma=150.0), horizons=(horizon,))
    (defect,) = defects(made, straight(horizon))
    assert "70.7 m across and 100 m from it" in defect.message


def test_a_bay_is_no_hole():
    horizon = holed((0, 900, 110))
    assert holes_of(horizon, straight(horizon)) == ()


def test_an_island_in_a_hole_leaves_one_hole():
    ring = holed((0, 0, 210))
    island = holed(size=200.0)
    both = np.concatenate([ring.surface.vertices, island.surface.vertices])
    triangles = np.concatenate(
        [ring.surface.triangles, island.surface.triangles + len(ring.surface.vertices)]
    )
    surface = replace(ring.surface, vertices=both, triangles=triangles)
    horizon = replace(ring, surface=surface, grid=None)
    (hole,) = holes_of(horizon, straight(horizon, 800.0))
    # a triangle stands in each corner of the hole
    assert hole.area.area == pytest.approx(500.0**2 - 200.0**2 - 4 * STEP**2 / 2)
    assert hole.nodes == 0


def test_a_crack_between_vertices_is_no_hole():
    whole = holed()
    corners = whole.surface.vertices[whole.surface.triangles].reshape(-1, 3)
    surface = replace(whole.surface, vertices=corners, triangles=np.arange(len(corners)).reshape(-1, 3))
    assert holes_of(replace(whole, surface=surface), straight(whole)) == ()


@pytest.mark.parametrize("off", [0, 150])
def test_what_is_filled_warns_with_its_nodes(off):
    horizon = holed((100, off, 60))
    nodes = [(x, off + y, 0) for x in (50, 100, 150) for y in (-50, 0, 50)]
    graph = replace(straight(horizon), filled=nodes)
    made = replace(model(faulted, gamma=150.0), horizons=(horizon,))
    (defect,) = defects(made, graph)
    assert defect.severity.value == "warn"
    assert defect.count == 9
    assert "9 undefined nodes of H in a hole" in defect.message
    assert [p.kind for p in defect.parts] == ["filled hole"]


def test_what_is_filled_far_from_any_trace_is_said_of_the_horizon():
    horizon = holed((100, 600, 10))
    graph = replace(straight(horizon), filled=[(100, 600, 0)])
    made = replace(model(faulted), horizons=(horizon,))
    assert [(d.objects, d.count) for d in defects(made, graph)] == [(("H",), 1)]
    none = CutGraph("H", [], [], [], [], filled=[(100, 600, 0)])
    assert [(d.objects, d.count) for d in defects(made, none)] == [(("H",), 1)]


# -- slopes


@pytest.mark.parametrize("dip", [15.0, 40.0, 75.0])
@pytest.mark.parametrize("ratio", [0.9, 0.3, -0.5])
def test_the_slope_of_a_plane_is_exact(dip, ratio):
    made = model(lambda x, y: 0.05 * x - ratio * np.tan(np.radians(dip)) * y, dip=dip)
    found = slope_ratios(made.horizons[0], made.faults[0].surface, graph_of(made), 0, gammas_of(made))
    assert [s.ratio for s in found] == pytest.approx([ratio] * len(found), rel=1e-9)
    assert sum(s.length for s in found) > 700


def test_the_smeared_step_is_not_taken_for_the_slope():
    made = model(lambda x, y: faulted(x, y, 40.0, 200.0), gamma=150.0)
    at_the_trace = 200.0 / (np.sqrt(2 * np.pi) * 40.0) / np.tan(np.radians(60))
    found = slope_ratios(made.horizons[0], made.faults[0].surface, graph_of(made), 0, gammas_of(made))
    assert at_the_trace > 0.8
    assert max(abs(s.ratio) for s in found) < 0.05


def test_one_parallel_side_is_enough():
    slope = np.tan(np.radians(40.0))
    made = model(lambda x, y: np.where(y > 0, -0.9 * slope * y, -0.1 * slope * y), dip=40.0)
    assert finding(made).worst.value == pytest.approx(0.9, rel=1e-6)


def test_the_limit_can_be_set():
    made = model(lambda x, y: -0.7 * np.tan(np.radians(40.0)) * y, dip=40.0)
    assert finding(made).status is Status.PASS
    assert finding(replace(made, checks={"horizon": 0.6})).status is Status.WARN


def test_a_robust_plane_forgets_wild_points():
    rng = np.random.default_rng(1)
    basis = np.column_stack([np.ones(200), rng.uniform(-1, 1, (200, 2))])
    values = basis @ [5.0, 2.0, -3.0] + 0.1 * rng.standard_normal(200)
    values[:20] += 50.0
    found, scatter = robust_fit(basis, values, np.ones(200))
    assert found == pytest.approx([5.0, 2.0, -3.0], abs=0.15)
    assert scatter < 1.0


# -- picks


@pytest.mark.parametrize("count", [1, 4, 10])
def test_the_strayed_picks_are_named_all_and_alone(count):
    picks, which = strayed(sharp_picks(), count)
    found = finding(model(faulted, picks=picks))
    assert found.element is Element.PICK
    assert found.elements.tolist() == sorted(which.tolist())
    assert found.count == count
    local = THROW * (1 - (picks[which, 0] / 400.0) ** 2) ** 1.5
    assert found.worst.value == pytest.approx(local.max(), abs=0.1 * THROW)


@pytest.mark.parametrize("seed", range(4))
def test_good_smeared_and_noisy_picks_are_left_alone(seed):
    for picks in (
        sharp_picks(seed),
        sharp_picks(seed, noise=5.0),
        sharp_picks(seed, noise=15.0),
        sharp_picks(seed, throw=0.0),
        *(smeared_picks(width) for width in (20.0, 40.0, 80.0)),
    ):
        made = model(faulted, picks=picks)
        found = strays(made.horizons[0], made.faults[0].surface, graph_of(made), 0, gammas_of(made))
        assert found.picks.tolist() == []


def test_an_outlier_is_no_pick_of_the_other_lip():
    picks = STRAYED.copy()
    picks[WHICH, 2] += 200.0
    assert finding(model(faulted, picks=picks)).status is Status.PASS


# -- smear


@cache
def traced_demo(name: str, step: float, noise: float) -> tuple[SyntheticModel, Model, CutGraph]:
    made = demo.build(name, step=step, noise=noise)
    local = model_of_demo(made)
    local = local.moved(-local.local_origin())
    return made, local, graph_of(local)


def true_width(made: SyntheticModel, fault: int) -> float:
    """Where 95 % of the step is done in the middle of a fault: a ramp of half the heave smeared by 120 m."""
    half = made.geology.half_heaves[fault][1].max()
    blur = np.linspace(-8, 8, 4001)
    weight = np.exp(-(blur**2) / 2)

    def missing(d):
        return weight @ np.clip((d + 120.0 * blur) / half, -1, 1) / weight.sum() - 0.9

    return brentq(missing, 1.0, 2000.0)


@pytest.mark.parametrize(("step", "noise"), [(100.0, 0.0), (100.0, 2.0), (50.0, 2.0)])
@pytest.mark.parametrize("name", ["single", "exit", "cross", "reverse", "low-dip"])
def test_the_smear_of_the_demos_is_found(name, step, noise):
    made, local, graph = traced_demo(name, step, noise)
    for k in range(len(local.faults)):
        found = smear_width(local.horizons[0], graph, k, gammas_of(local))
        assert found.width == pytest.approx(true_width(made, k), rel=0.15)


def test_the_smear_does_not_depend_on_gamma():
    _, local, graph = traced_demo("single", 100.0, 0.0)
    widths = [smear_width(local.horizons[0], graph, 0, {0: g}).width for g in (100.0, 400.0, 1000.0)]
    assert widths == pytest.approx([widths[0]] * 3)


@pytest.mark.parametrize("width", [30.0, 50.0, 80.0, 110.0])
def test_the_smear_grows_with_the_width_of_the_step(width):
    made = model(lambda x, y: faulted(x, y, width))
    found = smear_width(made.horizons[0], graph_of(made), 0, gammas_of(made))
    assert found.width == pytest.approx(1.645 * width, rel=0.1)
    # 95 % of the step is done there, as the horizon itself shows
    step = faulted(0.0, np.array([-found.width, found.width]), width) - 0.02 * np.array([-1, 1]) * found.width
    assert (0.5 * THROW - step[0]) / THROW == pytest.approx(0.05, abs=0.02)


def test_a_horizon_without_a_step_is_not_smeared():
    heights = [
        lambda x, y: 0.0 * x,
        lambda x, y: 0.1 * x + 0.07 * y,
        lambda x, y: 30 * np.sin(x / 300) * np.cos(y / 400),
        lambda x, y: 5 * np.sin(12.9 * x + 78.2 * y),
    ]
    for height in heights:
        made = model(height)
        assert smear_width(made.horizons[0], graph_of(made), 0, gammas_of(made)) is None


def test_picks_on_both_lips_are_not_smeared():
    made = model(lambda x, y: faulted(x, y, 80.0), picks=sharp_picks())
    assert smear_width(made.horizons[0], graph_of(made), 0, gammas_of(made)) is None


def test_the_gamma_that_is_advised_is_enough():
    made = model(lambda x, y: faulted(x, y, 80.0))
    found = finding(made)
    assert found.remedy == "Set gamma of F to at least 230 m."
    assert found.worst.value == pytest.approx(2.25 * 80.0, rel=0.1)
    assert finding(replace(made, parameters=made.parameters.model_copy(update={"gamma": 230.0}))).count == 0


# -- together


def test_one_finding_says_everything_of_a_pair():
    made = model(lambda x, y: faulted(x, y, 80.0), around(7, 107))
    found = finding(made)
    assert found.status is Status.FAIL
    assert [p.kind for p in found.parts] == ["hole", "smear"]
    assert "hole" in found.message
    assert "smeared" in found.message
    assert found.worst.value == pytest.approx(np.sqrt(2) * STEP)


@pytest.mark.parametrize("name", ["cross", "tee", "reverse", "low-dip", "low-dip-12"])
def test_the_demos_are_fit(name):
    _, local, graph = traced_demo(name, 100.0, 0.0)
    assert defects(local, graph) == []


def test_a_horizon_that_is_not_functional_waits():
    folded = model(lambda x, y: 0 * x, picks=np.column_stack([np.zeros((9, 2)) + 400, np.arange(9) * 200.0]))
    (found,) = check(folded).of("horizon")
    assert found.status is Status.SKIPPED
    assert "functional" in found.message


def test_a_trace_that_closes_on_itself_is_looked_at():
    turn = np.linspace(0, 2 * np.pi, 20)[:-1]
    nodes = np.column_stack([200 * np.cos(turn), 200 * np.sin(turn), 0 * turn])
    k = np.arange(len(turn))
    made = model(lambda x, y: 30 * (0.5 - ndtr((np.hypot(x, y) - 200) / 80)))
    ring = CutGraph("H", nodes, 0 * k, np.column_stack([k, (k + 1) % len(k)]), 0 * k)
    found = smear_width(made.horizons[0], ring, 0, {0: 100.0})
    assert found.width == pytest.approx(1.645 * 80, rel=0.2)


def test_claudius_is_fit():
    path = DATA / "claudius" / "model.toml"
    if not path.is_file():
        pytest.skip(f"no {path}")
    read = read_model(path)
    only = replace(read, horizons=tuple(h for h in read.horizons if h.name == "D"))
    assert finding(only).status is Status.PASS
