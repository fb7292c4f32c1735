"""Patches meshed anew: all around them, rims, vertices held and lines to the bit, and the surface near."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.arrays import ints
from graben.cleaning.shaping.fans import trouble
from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.remeshing import differing, followed, remeshed, rings, shared_edges
from graben.surface import Surface, boundary_edges, edge_table
from graben.validators.measuring.measures import smallest_angles
from tests.cleaning.cracked import area
from tests.cleaning.test_slivers import bent, shaken
from tests.zoo.shapes import STEP, sheet

AWAY = 0.05 * STEP
FAR = np.array([5e5, 6e6, 0.0])


def column(surface: Surface, x: float) -> np.ndarray:
    """Which vertices of a sheet lie at an x: a line across it."""
    return np.isclose(surface.vertices[:, 0], x)


def line_at(surface: Surface, x: float) -> np.ndarray:
    edges = edge_table(surface.triangles)[0]
    return edges[column(surface, x)[edges].all(axis=1)]


def places(surface: Surface, edges: np.ndarray) -> set[tuple[float, ...]]:
    ends = surface.vertices[edges]
    return {tuple(np.sort(pair, axis=0).ravel()) for pair in ends.round(12)}


def made_of(surface: Surface, seed: int, count: int = 2, length: float = 0.5 * STEP, x: float = 6 * STEP):
    """A patch around some triangle meshed anew, with a line across the surface held."""
    start = np.random.default_rng(seed).integers(len(surface.triangles), size=1)
    patch = rings(surface.triangles, start, count)
    held, lines = column(surface, x), line_at(surface, x)
    made = remeshed(surface, patch, held, lines, length, AWAY)
    assert made is not None
    return made, patch, held, lines


@pytest.mark.parametrize("surface", [bent(), shaken(1, 0.1), shaken(2, 0.3)], ids=["whole", "few", "many"])
@pytest.mark.parametrize("seed", range(6))
def test_what_is_around_the_rim_and_lines_stay_to_the_bit(surface, seed):
    made, patch, held, lines = made_of(surface, seed)
    rest = np.delete(surface.triangles, patch, axis=0)
    assert np.array_equal(made.vertices[made.triangles[: len(rest)]], surface.vertices[rest])
    assert places(made, boundary_edges(made.triangles)) == places(surface, boundary_edges(surface.triangles))
    kept, edges = followed(surface, made, held, lines)
    assert kept.sum() == held.sum()
    assert len(edges) == len(lines)
    assert trouble(made.triangles) == (0, 0)
    assert distances(made, [surface]).max() < AWAY
    assert distances(surface, [made]).max() < AWAY
    assert len(np.unique(made.triangles)) == len(made.vertices)


@pytest.mark.parametrize("seed", range(3))
def test_the_same_bytes_every_time(seed):
    surface = shaken(seed, 0.2)
    first, second = (made_of(surface, seed)[0] for _ in range(2))
    assert first.vertices.tobytes() == second.vertices.tobytes()
    assert first.triangles.tobytes() == second.triangles.tobytes()


def test_a_plane_stays_one_and_its_edges_get_the_length_asked_for():
    flat = sheet(8, 8, lambda i, j: (STEP * i, 30 * j, -40 * j))
    made, patch, _, _ = made_of(flat, 5, 3, 0.25 * STEP)
    assert distances(made, [flat]).max() < 1e-9 * STEP
    assert area(made) == pytest.approx(area(flat), rel=1e-12)
    assert len(made.triangles) > len(flat.triangles) + 2 * len(patch)


def test_needles_around_a_vertex_become_wide():
    # a wheel with its hub a hair from the rim of it: flips of its spokes would leave it
    turn = np.radians(np.arange(0, 360, 30))
    wheel = np.c_[100 * np.cos(turn), 100 * np.sin(turn), 0 * turn]
    hub = [[99.5 * np.cos(turn[0] + 0.25), 99.5 * np.sin(turn[0] + 0.25) * 0.2, 0.0]]
    k = np.arange(12)
    surface = Surface("F", np.concatenate([wheel, hub]), np.c_[k, (k + 1) % 12, 0 * k + 12])
    held = np.zeros(13, dtype=bool)
    made = remeshed(surface, k, held, ints([], -1, 2), 60.0, 1.0)
    assert made is not None
    before, after = (smallest_angles(s.vertices, s.triangles).min() for s in (surface, made))
    assert after > 5 * before


def test_far_from_the_origin_nothing_is_lost():
    surface = bent()
    moved = surface.with_vertices(surface.vertices + FAR)
    held, lines = column(surface, 6 * STEP), line_at(surface, 6 * STEP)
    patch = rings(surface.triangles, ints([100]), 2)
    near, far = (remeshed(s, patch, held, lines, 0.5 * STEP, AWAY) for s in (surface, moved))
    assert near is not None
    assert far is not None
    assert abs(len(near.triangles) - len(far.triangles)) < 0.1 * len(patch)
    rest = np.delete(moved.triangles, patch, axis=0)
    assert np.array_equal(far.vertices[far.triangles[: len(rest)]], moved.vertices[rest])
    assert distances(far, [moved]).max() < AWAY


def test_lines_of_the_file_follow_the_triangles():
    surface = bent()
    numbered = replace(surface, lines=np.arange(len(surface.triangles)))
    patch = rings(surface.triangles, ints([100]), 2)
    none = np.zeros(len(surface.vertices), dtype=bool)
    made = remeshed(numbered, patch, none, ints([], -1, 2), 0.5 * STEP, AWAY)
    assert made is not None
    count = len(surface.triangles) - len(patch)
    assert np.array_equal(made.lines[:count], np.delete(numbered.lines, patch))
    assert set(made.lines[count:].tolist()) <= set(patch.tolist())
    assert len(made.lines) == len(made.triangles)


def test_a_patch_without_area_is_left():
    flat = Surface("F", [[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
    assert remeshed(flat, ints([0]), np.zeros(3, dtype=bool), ints([], -1, 2), 1.0, 1.0) is None


def test_an_edge_is_shared_where_both_faults_have_it_not_where_they_have_its_ends():
    surface = bent()
    other = replace(surface, name="G", triangles=surface.triangles[:1])
    a, b, c = np.sort(surface.triangles[0])
    assert shared_edges(surface, [other]).tolist() == [[a, b], [a, c], [b, c]]
    two = Surface("H", surface.vertices[[a, b, c]], np.zeros((0, 3), dtype=int))
    assert shared_edges(surface, [two, surface]).tolist() == []


def test_surfaces_differ_where_a_triangle_is_new_gone_or_turned_over():
    surface = bent()
    order = np.random.default_rng(0).permutation(len(surface.triangles))
    mixed = replace(surface, triangles=np.roll(surface.triangles[order], 1, axis=1))
    assert [len(k) for k in differing(surface, mixed)] == [0, 0]
    turned = surface.triangles.copy()
    turned[7] = turned[7][::-1]
    assert [k.tolist() for k in differing(surface, replace(surface, triangles=turned))] == [[7], [7]]
    fewer = replace(surface, triangles=surface.triangles[3:])
    assert [k.tolist() for k in differing(surface, fewer)] == [[0, 1, 2], []]
