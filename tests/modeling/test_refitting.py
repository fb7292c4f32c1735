"""Horizons from points: are the nodes beside the faults those that the picks outside the zone ask for?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from graben.arrays import FloatArray, floats
from graben.demo import HORIZON, SIZE, build, write
from graben.model import Fault, Horizon, Model
from graben.modeling.fitting import fit_points
from graben.modeling.preparation import CutHorizon, prepared
from graben.modeling.results import Score
from graben.modeling.scattered import Places, Scattered, located
from graben.modeling.scoring import score
from graben.modeling.tracing import cut_graph
from graben.pipeline import build as modeled
from graben.reading import points_step
from graben.refinement import refined
from graben.surface import Surface
from tests.models import model_of, model_of_demo, plane_fault

STEP, GAMMA, SPACING = 100.0, 300.0, 100.0
Height = Callable[[FloatArray], FloatArray]


def regular(size: float = 4000.0, spacing: float = SPACING) -> FloatArray:
    axis = np.arange(-size / 2, size / 2 + spacing / 2, spacing) + 3.0
    return np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)


def horizon_of(picks: FloatArray, step: float = STEP, noise: float | None = None) -> Horizon:
    fitted = fit_points(picks, step)
    surface = Surface("H", fitted.vertices, fitted.triangles)
    return Horizon("H", surface, step, picks=picks, noise=noise, smoothing=fitted.smoothing)


def ready(horizon: Horizon, *faults: Fault, **parameters: object) -> CutHorizon:
    model = model_of(horizon, *faults, gamma=GAMMA, **parameters)
    graph = cut_graph(model, horizon, refined([f.surface for f in faults]))
    return prepared(model, horizon, graph)


def stepped(xy: FloatArray, throw: float = 60.0) -> FloatArray:
    """A different plane on each side of x = 0, joined by a ramp 200 m wide."""
    share = np.clip(0.5 + xy[:, 0] / 200.0, 0.0, 1.0)
    left, right = 0.05 * xy[:, 0] + 0.5 * throw, -0.02 * xy[:, 0] + 0.03 * xy[:, 1] - 0.5 * throw
    return np.asarray((1 - share) * left + share * right)


THROUGH = plane_fault((0, -3000), (0, 3000))


def beside(cut: CutHorizon) -> FloatArray:
    """Return the reliable nodes within 500 m of the zone and inside the points' own area, (k, 3)."""
    points = cut.first[~cut.unknown]
    inner = (np.abs(points[:, 0]) < GAMMA + 500.0) & (np.abs(points[:, 1]) < 1900.0)
    return points[inner]


def test_each_side_is_its_own_plane_whatever_the_fit_across_the_fault_made_of_it() -> None:
    xy = regular()
    horizon = horizon_of(np.column_stack([xy, stepped(xy)]), 200.0)
    nodes = horizon.surface.vertices
    near = (np.abs(nodes[:, 0]) > GAMMA) & (np.abs(nodes[:, 0]) < 800.0)
    assert np.abs(nodes[near, 2] - stepped(nodes[near])).max() > 1.0
    points = beside(ready(horizon, THROUGH))
    assert len(points) > 100
    # What is kept of the first surface has a millionth of the weight of the picks.
    assert points[:, 2] == pytest.approx(stepped(points), abs=1e-3)


def test_a_plane_stays_to_rounding() -> None:
    xy = regular()
    horizon = horizon_of(np.column_stack([xy, 0.1 * xy[:, 0] - 0.2 * xy[:, 1]]))
    points = ready(horizon, THROUGH).first
    assert points[:, 2] == pytest.approx(0.1 * points[:, 0] - 0.2 * points[:, 1], abs=1e-8)


def test_picks_inside_the_zone_have_no_say() -> None:
    xy = regular()
    horizon = horizon_of(np.column_stack([xy, stepped(xy)]))
    other = horizon.picks.copy()
    inside = np.abs(xy[:, 0]) < GAMMA - 100.0
    other[inside, 2] += 30.0 * np.random.default_rng(0).standard_normal(inside.sum())
    first, second = (ready(replace(horizon, picks=floats(p)), THROUGH) for p in (horizon.picks, other))
    assert np.array_equal(first.first, second.first)
    assert first.horizon.smoothing == second.horizon.smoothing


def test_nodes_of_the_zone_and_far_away_keep_their_elevation() -> None:
    xy = regular(6000.0)
    # Without relief any length would do.
    relief = 20.0 * np.sin(xy[:, 0] / 500.0) * np.cos(xy[:, 1] / 600.0)
    horizon = horizon_of(np.column_stack([xy, stepped(xy) + relief]))
    with_picks, without = (ready(h, THROUGH) for h in (horizon, replace(horizon, picks=floats([], 0, 3))))
    change = with_picks.first[:, 2] - without.first[:, 2]
    far = np.abs(with_picks.first[:, 0]) > GAMMA + 14 * STEP
    assert far.any()
    assert not change[with_picks.unknown | far].any()
    assert np.abs(change).max() > 0.5


@pytest.mark.parametrize("sigma", [0.5, 5.0])
def test_noise_is_found_and_smoothed(sigma: float) -> None:
    xy = regular()
    noise = sigma * np.random.default_rng(1).standard_normal(len(xy))
    cut = ready(horizon_of(np.column_stack([xy, stepped(xy) + noise])), THROUGH)
    points = beside(cut)
    rms = float(np.sqrt(np.mean((points[:, 2] - stepped(points)) ** 2)))
    assert rms < 0.3 * sigma
    (note,) = [n for n in cut.horizon.notes if n.startswith("Around the faults")]
    assert float(note.split("at a noise of ")[1].split()[0]) == pytest.approx(sigma, rel=0.15)


def test_a_part_with_hardly_a_pick_outside_is_fitted_to_what_it_has() -> None:
    xy = regular()
    picks = np.column_stack([xy, stepped(xy)])
    horizon = horizon_of(picks)
    before = ready(replace(horizon, picks=floats([], 0, 3)), THROUGH).first
    right = before[:, 0] > GAMMA
    for reach, stays in ((GAMMA, False), (20.0, True)):
        few = picks[(xy[:, 0] < reach) & ((xy[:, 0] < 20.0) | (np.abs(xy[:, 1]) < 1000.0))]
        few = few[(few[:, 0] < 0.0) | (np.abs(few[:, 1]) < (500.0 if stays else 1000.0))]
        after = ready(replace(horizon, picks=floats(few)), THROUGH).first
        assert not np.array_equal(after[~right], before[~right])
        assert np.array_equal(after[right], before[right]) == stays


def test_the_equations_are_the_slope_of_the_misfit() -> None:
    rng = np.random.default_rng(2)
    surface = horizon_of(np.column_stack([regular(), np.zeros(len(regular()))])).surface
    points, triangles = surface.vertices[:, :2] / STEP, surface.triangles
    places = Places.of(floats(rng.uniform(-15, 15, (3000, 2))), floats(rng.standard_normal(3000)))
    faces, weights, inside = located(points, triangles, places.points)
    assert inside.all()
    corners = points[triangles[faces]]
    assert (weights[:, :, None] * corners).sum(axis=1) == pytest.approx(places.points, abs=1e-9)
    problem = Scattered.of(points, triangles, faces, weights, floats(rng.uniform(0.5, 2.0, 3000)))

    def misfit(u: FloatArray) -> float:
        return 0.5 * float((problem.shares * (problem.at_places(u) - places.means) ** 2).sum())

    u, way = rng.standard_normal((2, len(points)))
    slope = (misfit(u + way) - misfit(u - way)) / 2.0
    assert float(way @ (problem.data @ u - problem.load(places.means))) == pytest.approx(slope, rel=1e-9)


@pytest.mark.parametrize("width", [120.0, 200.0])
def test_a_smear_as_wide_as_the_picks_are_apart_is_not_taken_for_sharp(width: float) -> None:
    """Planes through ten picks of each side show half of such a jump; the nearest picks give it away."""
    xy = np.random.default_rng(3).uniform(-2000.0, 2000.0, (1600, 2))
    heave = 60.0 / np.tan(np.radians(60.0))
    xy = xy[np.abs(xy[:, 0]) > heave / 2]
    for smeared in (True, False):
        share = np.clip(0.5 + xy[:, 0] / width, 0.0, 1.0) if smeared else (xy[:, 0] > 0) * 1.0
        cut = ready(horizon_of(np.column_stack([xy, 60.0 * (0.5 - share)])), THROUGH)
        assert (len(cut.data.nodes) == 0) == smeared


@cache
def made(name: str, folder: str) -> Path:
    write(build(name), Path(folder) / name)
    return Path(folder) / name / "truth"


def scored(model: Model, truth: Path) -> Score:
    (horizon,) = modeled(model, mend=False).horizons
    assert horizon.converged
    found = score(truth, horizon, model.faults)
    assert found is not None
    return found


@cache
def grid_score(name: str, folder: str) -> Score:
    """Return the score of a demo model on a grid of 200 m."""
    return scored(model_of_demo(build(name, step=200.0)), made(name, folder))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(tmp_path_factory.mktemp("truth"))


def from_points(name: str, pattern: str, noise: float = 0.0, seed: int = 0) -> Model:
    """Return a demo model whose horizon is picks about 100 m apart, at the default step for these."""
    synthetic = build(name)
    rng = np.random.default_rng(seed)
    xy = synthetic.grid.nodes().reshape(-1, 2)
    if pattern == "random":
        xy = rng.uniform(0.0, 1.0, xy.shape) * SIZE
    z = synthetic.geology.seismic(synthetic.frame.inward(xy)) + noise * rng.standard_normal(len(xy))
    horizon = horizon_of(np.column_stack([xy, z]), points_step(floats(np.column_stack([xy, z]))))
    surface = replace(horizon.surface, name=HORIZON)
    whole = model_of_demo(synthetic)
    return replace(whole, horizons=(replace(horizon, name=HORIZON, surface=surface),))


@pytest.mark.parametrize(
    ("name", "pattern"), [("single", "regular"), ("single", "random"), ("tee", "random")]
)
def test_points_do_as_well_as_a_grid_of_their_step(name: str, pattern: str, folder: str) -> None:
    truth = made(name, folder)
    grid = grid_score(name, folder)
    points = scored(from_points(name, pattern), truth)
    assert points.cutoff.value <= 1.5 * grid.cutoff.value
    assert points.throw.value <= 1.5 * grid.throw.value


def test_noisy_points_do_as_well_as_a_noisy_grid_of_as_many_nodes(folder: str) -> None:
    truth = made("single", folder)
    grid = scored(model_of_demo(build("single", noise=5.0)), truth)
    assert scored(from_points("single", "random", 5.0), truth).cutoff.value <= grid.cutoff.value
