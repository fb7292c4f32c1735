"""Noisy horizons: is the noise found, does the fit win, and does a smooth horizon stay as it is?"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from graben.arrays import FloatArray
from graben.cutgraph import CutGraph
from graben.demo import build as demo
from graben.demo import write
from graben.modeling.noise import Smoothing, fitted, node_areas, rings, smoothing
from graben.modeling.results import HorizonResult
from graben.pipeline import build
from graben.reading import read_model
from tests.models import grid_horizon

STEP = 100.0
SEEDS = (0, 1)


def strip(height: FloatArray | float) -> tuple[FloatArray, np.ndarray, np.ndarray, CutGraph]:
    """Return nodes, triangles, zone and cut of a horizon of 61 x 61 nodes with one straight cut."""
    surface = grid_horizon(lambda x, y: 0.0 * x, size=6000.0, step=STEP).surface
    points = surface.vertices.copy()
    points[:, 2] = height
    line = np.column_stack([np.zeros(41), np.linspace(-2000.0, 2000.0, 41), np.zeros(41)])
    edges = np.stack([np.arange(40), np.arange(1, 41)], axis=1)
    graph = CutGraph("H", line, np.zeros(41, dtype=np.int64), edges, np.zeros(40, dtype=np.int64))
    zone = (np.abs(points[:, 0]) < 400.0) & (np.abs(points[:, 1]) < 2400.0)
    return points, surface.triangles, zone, graph


def plane(sigma: float, seed: int = 0) -> FloatArray:
    points = strip(0.0)[0]
    noise = sigma * np.random.default_rng(seed).standard_normal(len(points))
    return np.asarray(0.1 * points[:, 0] - 0.05 * points[:, 1] + noise)


@pytest.mark.parametrize("sigma", [0.01, 2.0, 50.0])
def test_white_noise_on_a_plane_is_found(sigma: float) -> None:
    points, triangles, zone, graph = strip(plane(sigma))
    found = smoothing(points, triangles, zone, graph, STEP, None)
    assert found.noise == pytest.approx(sigma, rel=0.1)
    # A plane has nothing that smoothing could spoil.
    assert found.length >= 4 * STEP


def test_noise_that_is_known_is_taken_as_it_is() -> None:
    points, triangles, zone, graph = strip(plane(2.0))
    assert smoothing(points, triangles, zone, graph, STEP, 2.5).noise == 2.5
    assert smoothing(points, triangles, zone, graph, STEP, 0.0) == Smoothing()


def test_a_smooth_horizon_asks_for_no_fit() -> None:
    x, y = strip(0.0)[0][:, :2].T
    waves = 12.0 * np.sin(x / 800.0) * np.cos(y / 900.0) + 0.1 * x
    assert smoothing(*strip(waves), STEP, None) == Smoothing()


def test_the_size_of_the_model_does_not_count() -> None:
    points, triangles, zone, graph = strip(plane(2.0))
    metres = smoothing(points, triangles, zone, graph, STEP, None)
    larger = replace(graph, nodes=graph.nodes * 10.0)
    tenfold = smoothing(points * 10.0, triangles, zone, larger, 10.0 * STEP, None)
    assert tenfold.length == pytest.approx(10.0 * metres.length)
    assert tenfold.noise == pytest.approx(10.0 * metres.noise, rel=1e-6)


def test_rings_count_edges_and_the_fit_reaches_five_lengths() -> None:
    _, triangles, zone, _ = strip(0.0)
    found = rings(triangles, zone, 4)
    assert (found[zone] == 0).all()
    for k in range(1, 5):
        corners = found[triangles[(found[triangles] == k).any(axis=1)]]
        assert set(np.unique(corners)) <= {k - 1, k, k + 1, -1}
        assert k == 4 or (corners != -1).all()
    reach = fitted(triangles, zone, 1.5 * STEP, STEP)
    assert np.array_equal(reach, rings(triangles, zone, 8) > 0)
    assert not fitted(triangles, zone, 0.0, STEP).any()


def test_the_areas_of_the_nodes_add_up() -> None:
    points, triangles, _, _ = strip(0.0)
    assert node_areas(points, triangles).sum() == pytest.approx(6000.0**2)


@cache
def rebuilt(name: str, sigma: float, seed: int, fit: bool, folder: str) -> HorizonResult:
    place = Path(folder) / f"{name}-{sigma}-{seed}-{fit}"
    write(demo(name, noise=sigma, seed=seed), place)
    model = read_model(place / "model.toml")
    known = None if fit else 0.0
    horizon = replace(model.horizons[0], noise=known)
    return build(replace(model, horizons=(horizon,))).horizons[0]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(tmp_path_factory.mktemp("noisy"))


def cutoff_error(sigma: float, fit: bool, folder: str) -> float:
    """Return the cutoff error in percent of the largest throw, a mean over seeds."""
    results = [rebuilt("single", sigma, seed, fit, folder) for seed in SEEDS]
    assert all(r.converged for r in results)
    return float(np.mean([r.score.cutoff.percent for r in results if r.score is not None]))


@pytest.mark.parametrize(("sigma", "bar"), [(2.0, 5.0), (5.0, 10.0)])
def test_the_fit_wins_over_interpolation(sigma: float, bar: float, folder: str) -> None:
    interpolated = cutoff_error(sigma, False, folder)
    assert interpolated <= bar
    assert cutoff_error(sigma, True, folder) <= 2.0 / 3.0 * interpolated


def test_reliable_nodes_keep_their_values_and_the_note_tells_of_the_noise(folder: str) -> None:
    result = rebuilt("single", 2.0, 0, True, folder)
    assert np.array_equal(result.surface.vertices[result.fixed], result.first[result.fixed])
    (note,) = [n for n in result.horizon.notes if n.startswith("Noise of")]
    assert "estimated" in note and "least squares" in note


def test_smooth_input_is_interpolated_to_the_bit(folder: str) -> None:
    fit, without = (rebuilt("single", 0.0, 0, fit, folder) for fit in (True, False))
    assert np.array_equal(fit.surface.vertices, without.surface.vertices)
