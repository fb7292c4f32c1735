"""The bend of a horizon carried on into the zone: exact where it is known, and left alone where it is not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.special import erf

from graben.arrays import FloatArray, floats
from graben.demo import build as demo
from graben.model import Horizon, Model
from graben.modeling import preparation
from graben.modeling.algebra import Cholmod
from graben.modeling.bend import carried
from graben.modeling.cubics import Nodes, quadratic, thinned
from graben.modeling.energy import EdgePattern, assemble, system
from graben.modeling.preparation import CutHorizon, prepared
from graben.modeling.tracing import cut_graph
from graben.pipeline import build
from graben.refinement import refined
from graben.surface import Surface
from tests.modeling.meshes import irregular
from tests.models import grid_horizon, model_of, model_of_demo, plane_fault

STEP, GAMMA, SMEAR, THROW = 50.0, 400.0, 120.0, 100.0
#: Second derivatives of the paraboloid, 1 / m: it leaves its tangent plane by 4 m on the way to the cut.
K = floats([5e-5, 1e-5, -2e-5])
#: From one edge of the horizon to the other.
THROUGH = plane_fault((0, -4000), (0, 4000), dip=90.0)


def paraboloid(xy: FloatArray) -> FloatArray:
    return np.asarray(quadratic(K, xy) + 0.02 * xy[..., 0])


def smeared(xy: FloatArray) -> FloatArray:
    return np.asarray(paraboloid(xy) - 0.5 * THROW * erf(xy[..., 0] / (np.sqrt(2.0) * SMEAR)))


def broken(height: Callable[[FloatArray], FloatArray] = smeared, **parameters: object) -> Model:
    horizon = grid_horizon(lambda x, y: height(np.stack([x, y], axis=-1)), size=6000.0, step=STEP)
    return model_of(horizon, THROUGH, **{"gamma": GAMMA, **parameters})


def ready(model: Model) -> CutHorizon:
    (horizon,) = model.horizons
    network = refined([f.surface for f in model.faults])
    return prepared(model, horizon, cut_graph(model, horizon, network))


def with_nodes(horizon: Horizon, z: FloatArray) -> Horizon:
    old = horizon.surface
    vertices = np.column_stack([old.vertices[:, :2], z])
    return replace(horizon, surface=Surface(old.name, vertices, old.triangles), grid=None)


def lip_error(model: Model) -> float:
    """Return the largest error of a lip in elevation, as a share of the throw."""
    result = build(model, mend=False)
    assert result.passed, repr(result)
    (horizon,) = result.horizons
    (cutoff,) = horizon.cutoffs
    # The side with growing x, right of the fault, is the hanging one and lies lower.
    sides = ((cutoff.hanging, -0.5 * THROW), (cutoff.foot, 0.5 * THROW))
    wrong = [lip[:, 2] - paraboloid(lip[:, :2]) - moved for lip, moved in sides]
    return float(np.abs(np.concatenate(wrong)).max()) / THROW


def test_a_quadratic_solves_the_energy_with_its_own_bend() -> None:
    points, triangles = irregular(17)
    pattern = EdgePattern.of(triangles, len(points))
    bend = floats([3.0, -0.7, 1.6])
    u = quadratic(bend, points) + points @ [0.3, -2.0] + 1.0
    load = system(points, pattern, 0.7, 2.0, np.tile(bend, (len(points), 1)))[1]
    both = assemble(points, pattern, 0.7, 2.0) - assemble(points, pattern, 0.0, 2.0) * 0.3
    assert load == pytest.approx(both @ u, abs=1e-9 * np.abs(both.data).max())
    assert not system(points, pattern, 0.7, 2.0, np.zeros((len(points), 3)))[1].any()


def test_cubics_are_fitted_exactly_also_at_the_edge_of_what_is_known() -> None:
    xy = np.random.default_rng(1).uniform(-1.0, 1.0, (3000, 2))
    x, y = xy.T
    z = 1.0 + 0.3 * x - y + 2.0 * x * x - 0.4 * x * y + 0.7 * y * y + x**3 - 0.2 * x * y * y
    known = x > 0
    nodes = Nodes.of(np.column_stack([xy, z]), np.zeros(3000, dtype=int), np.full(3000, 9.0), known, 0.6)
    centres = np.flatnonzero(np.abs(xy).max(axis=1) < 0.3)
    fits = nodes.fitted(centres, np.full(len(centres), 0.6), np.zeros(len(centres)))
    assert len(fits.centres) > 20
    assert (xy[fits.centres, 0] < 0).any()
    x, y = xy[fits.centres].T
    bend = np.stack([4.0 + 6.0 * x, -0.4 - 0.4 * y, 1.4 - 0.4 * x], axis=1)
    assert fits.bend == pytest.approx(bend, abs=1e-6)
    along_x = 0.3 + 4.0 * x - 0.4 * y + 3.0 * x * x - 0.2 * y * y
    along_y = -1.0 - 0.4 * x + 1.4 * y - 0.4 * x * y
    assert fits.slope == pytest.approx(np.stack([along_x, along_y], axis=1), abs=1e-6)
    assert fits.height == pytest.approx(z[fits.centres], abs=1e-7)


def test_nothing_is_fitted_across_a_cut_or_to_another_subdomain() -> None:
    xy = np.random.default_rng(2).uniform(-1.0, 1.0, (2000, 2))
    away, labels = np.abs(xy[:, 0]), (xy[:, 1] > 0).astype(int)
    nodes = Nodes.of(np.column_stack([xy, xy[:, 0]]), labels, away, away > 0.1, 0.5)
    centres = np.flatnonzero(away < 0.4)
    owner, node, way = nodes.around(nodes.used, centres, np.full(len(centres), 0.5))
    assert len(owner) > 1000
    assert (np.sign(xy[centres[owner], 0]) == np.sign(xy[node, 0])).all()
    assert (labels[centres[owner]] == labels[node]).all()
    assert way == pytest.approx(xy[node] - xy[centres[owner]])


def test_places_are_thinned_to_a_gap_and_cover_all() -> None:
    places = np.random.default_rng(3).uniform(0.0, 1.0, (500, 2))
    kept = places[thinned(places, 0.1)]
    apart = np.hypot(*(kept[:, None] - kept).transpose(2, 0, 1)) + 9.0 * np.eye(len(kept))
    assert apart.min() > 0.1
    assert np.hypot(*(places[:, None] - kept).transpose(2, 0, 1)).min(axis=1).max() <= 0.1


def test_a_bend_that_is_the_same_at_all_fixed_nodes_is_carried_on_as_it_is() -> None:
    points, triangles = irregular(17)
    pattern = EdgePattern.of(triangles, len(points))
    unknown = points[:, 0] > np.median(points[:, 0])
    bend = np.where(unknown[:, None], 0.0, [1.0, -2.0, 0.5])
    found = carried(points, pattern, unknown, bend, Cholmod())
    assert found == pytest.approx(np.tile([1.0, -2.0, 0.5], (len(points), 1)))
    assert not carried(points, pattern, unknown, np.zeros((len(points), 3)), Cholmod()).any()


def test_a_broken_paraboloid_is_found_again(monkeypatch: pytest.MonkeyPatch) -> None:
    model = broken()
    cut = ready(model)
    beside = cut.bend.any(axis=1)
    assert not (beside & cut.unknown).any()
    assert cut.bend[beside] == pytest.approx(np.tile(K, (beside.sum(), 1)), abs=2e-6)
    error = lip_error(model)
    assert error < 0.005
    monkeypatch.setattr(preparation, "bend_at_rim", lambda *given: np.zeros_like(given[2]))
    assert lip_error(model) > 4.0 * error


def test_planes_have_no_bend() -> None:
    flat = ready(broken(lambda xy: smeared(xy) - paraboloid(xy) + 0.03 * xy[..., 1]))
    assert flat.unknown.any()
    assert 0.5 * np.abs(flat.bend).max() * GAMMA**2 < 1e-3 * THROW


def white(count: int, xy: FloatArray, width: float) -> FloatArray:
    """Return noise of unit variance, smoothed over a width."""
    noise = np.random.default_rng(4).standard_normal(count)
    if width == 0:
        return noise
    tree = cKDTree(xy)
    near = tree.sparse_distance_matrix(tree, 4.0 * width).tocsr()
    near.data = np.exp(-0.5 * (near.data / width) ** 2)
    smooth = near @ noise + noise
    return np.asarray(smooth / smooth.std())


@pytest.mark.parametrize("alike", [0.0, 2.0])
def test_noise_is_not_taken_for_a_bend(alike: float) -> None:
    """White, and alike over a Gaussian of two steps."""
    model = model_of_demo(demo("single"))
    (horizon,) = model.horizons
    assert ready(model).bend.any()
    noise = white(len(horizon.surface.vertices), horizon.surface.vertices[:, :2], alike * horizon.step)
    noisy = with_nodes(horizon, horizon.surface.vertices[:, 2] + 5.0 * noise)
    assert not ready(replace(model, horizons=(noisy,))).bend.any()


def test_what_is_smeared_takes_no_part() -> None:
    """At 2.85 widths the smear is bent more than twice as much as the paraboloid, across the fault alone."""
    bend = ready(broken(gamma=2.85 * SMEAR)).bend
    beside = bend.any(axis=1)
    assert beside.any()
    assert bend[beside, 0] / bend[beside, 2] == pytest.approx(np.full(beside.sum(), K[0] / K[2]), rel=0.2)
    assert not ready(broken(gamma=2.0 * SMEAR)).bend.any()


def test_the_dirichlet_energy_alone_has_no_bend() -> None:
    assert not ready(broken(theta=0.0)).bend.any()
