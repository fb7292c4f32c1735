"""What is done on a short way, and what is left out, against the same done plainly."""

from __future__ import annotations

import os

import numpy as np
import pytest

from graben import refinement
from graben.arrays import floats, ints
from graben.beside import beside
from graben.formats.irap import _cells, grid_surface
from graben.formats.numbers import rows_of_text
from graben.model import GridGeometry
from graben.modeling.distance import distances
from graben.modeling.tracing import cut_graph
from graben.proximity import PlanIndex, box_pairs, boxes_over, nearest
from graben.refinement import refined
from graben.reports import thinning
from graben.surface import Surface, boundary_edges, edge_sharing, edge_table
from graben.validators.manifold import _pinched
from graben.validators.measuring.measures import components, mesh_of
from graben.validators.measuring.smear import _Window
from tests.models import grid_horizon, model_of, plane_fault


def test_a_frozen_array_is_shared_and_any_other_copied():
    own = np.arange(6.0)
    view = own.view()
    view.flags.writeable = False
    frozen = floats(view)
    own[0] = 9.0
    assert frozen[0] == 0.0
    assert floats(frozen) is frozen
    assert floats(frozen, -1, 3).base is frozen
    assert not floats(frozen, -1, 3).flags.writeable
    assert ints(frozen).dtype == np.int64


def test_boundary_edges_are_the_sides_that_no_other_triangle_has(seed=3):
    random = np.random.default_rng(seed)
    triangles = ints(random.integers(0, 30, (60, 3)))
    edges, sides = edge_table(triangles)
    t, k = np.nonzero(edge_sharing(sides, len(edges))[sides] == 1)
    expected = np.stack([triangles[t, (k + 1) % 3], triangles[t, (k + 2) % 3]], axis=1)
    np.testing.assert_array_equal(boundary_edges(triangles), expected)


@pytest.mark.parametrize("size", [0.0, 0.05, 0.3])
def test_boxes_that_are_left_out_meet_none(size):
    random = np.random.default_rng(0)
    for _ in range(50):
        low, others = random.uniform(-1, 2, (40, 3)), random.uniform(0, 1, (15, 3))
        high, ends = low + random.uniform(0, size, low.shape), others + random.uniform(0, size, others.shape)
        kept = boxes_over(low, high, others, ends)
        met = np.unique(box_pairs(low, high, others, ends)[:, 0])
        assert kept[met].all()
    assert not boxes_over(low + 5.0, high + 5.0, others, ends).any()


def test_an_index_of_the_plan_finds_what_lies_in_a_box():
    random = np.random.default_rng(0)
    points = np.round(random.uniform(0, 10, (500, 3)), 1)
    points[7, 0] = np.nan
    index = PlanIndex(points)
    for low in random.uniform(-1, 9, (40, 2)):
        high = np.round(low + 2.0, 1)
        inside = ((points[:, :2] >= low) & (points[:, :2] <= high)).all(axis=1)
        np.testing.assert_array_equal(index.within(low, high), np.flatnonzero(inside))
    assert len(PlanIndex(points[:0]).within(np.zeros(2), np.ones(2))) == 0


@pytest.fixture
def graph():
    horizon = grid_horizon(lambda x, y: 0.02 * x)
    model = model_of(horizon, plane_fault((0.0, -800.0), (200.0, 900.0)))
    return cut_graph(model, horizon, refined([f.surface for f in model.faults]))


def test_distances_beyond_what_is_asked_are_infinite(graph):
    points = np.random.default_rng(0).uniform(-2000, 2000, (800, 2))
    whole, edge = distances(points, graph)
    near, near_edge = distances(points, graph, within=150.0)
    asked = whole <= 150.0
    np.testing.assert_array_equal(near[asked], whole[asked])
    np.testing.assert_array_equal(near_edge[asked], edge[asked])
    assert (near[~asked] >= 150.0).all()


def test_two_halves_make_the_same_complex(monkeypatch):
    horizon = grid_horizon(lambda x, y: 0.02 * x + 0.01 * y).surface
    faults = [plane_fault((x, -800.0), (x + 100.0, 900.0)).surface for x in (-1200.0, 0.0, 1200.0)]
    whole = refined([*faults, horizon])
    monkeypatch.setattr(refinement, "_WORTH", 0)
    halved = refined([*faults, horizon])
    np.testing.assert_array_equal(halved.vertices, whole.vertices)

    def rows(made):
        told = np.column_stack([np.sort(made.triangles, axis=1), made.owner, made.parent])
        return told[np.lexsort(told.T)]

    np.testing.assert_array_equal(rows(halved), rows(whole))
    assert len(whole.triangles) > sum(len(s.triangles) for s in (*faults, horizon))


def test_work_beside_gives_its_value_or_its_error():
    assert beside(lambda: np.arange(3).tolist())() == [0, 1, 2]
    with pytest.raises(ZeroDivisionError):
        beside(lambda: 1 / 0)()


def test_work_of_a_copy_that_was_ended_is_done_again():
    here = os.getpid()

    def work():
        if os.getpid() != here:
            os._exit(1)
        return "done"

    assert beside(work)() == "done"


def test_rows_of_text_read_back_to_the_bit():
    random = np.random.default_rng(0)
    values = np.concatenate(
        [
            random.normal(size=(50, 3)) * 10.0 ** random.integers(-300, 300, (50, 1)),
            [[0.1, -0.0, 6e6 + 1 / 3]],
        ]
    )
    read = np.array([[float(word) for word in row.split()] for row in rows_of_text(values)])
    np.testing.assert_array_equal(read.view(np.int64), values.view(np.int64))
    assert rows_of_text(np.array([[1.0, np.nan], [np.inf, 2.5]])) == [b"1.0 nan", b"inf 2.5"]
    assert rows_of_text(np.array([[1, -2], [3, 4]])) == [b"1 -2", b"3 4"]
    assert rows_of_text(np.zeros((0, 3))) == []


def test_a_whole_grid_has_the_triangles_of_one_with_a_hole_elsewhere():
    grid, values = GridGeometry(6, 5, 10.0, 10.0, (0.0, 0.0)), np.zeros((6, 5))
    index = np.arange(30).reshape(6, 5)
    whole = _cells(index, np.ones((6, 5), dtype=bool))
    defined = np.ones((6, 5), dtype=bool)
    defined[5, 4] = False
    holed = _cells(index, defined)
    # only the last cell differs
    np.testing.assert_array_equal(whole[:-2], holed[:-1])
    assert (grid_surface("H", grid, values).triangles == whole).all()


def test_vertices_with_two_fans_are_those_whose_corners_fall_into_two_parts():
    random = np.random.default_rng(0)
    found = 0
    for trial in range(60):
        values = np.where(random.uniform(size=(8, 7)) < 0.2, np.nan, 0.0)
        surface = grid_surface("H", GridGeometry(8, 7, 1.0, 1.0, (0.0, 0.0)), values)
        one, two = random.integers(0, len(surface.vertices), 2)
        glued = np.where(surface.triangles == one, two, surface.triangles)
        mesh = mesh_of(Surface("H", surface.vertices, glued if trial % 2 else surface.triangles))
        first, second = mesh.joints.T
        ends = [side // 3 * 3 + (side % 3 + k) % 3 for side in (first, second) for k in (1, 2)]
        labels = components(
            mesh.triangles.size,
            np.concatenate([np.stack([ends[0], ends[3]], axis=1), np.stack([ends[1], ends[2]], axis=1)]),
        )
        fans = np.unique(np.stack([mesh.triangles.ravel(), labels], axis=1), axis=0)[:, 0]
        expected = np.flatnonzero(np.bincount(fans) > 1)
        np.testing.assert_array_equal(_pinched(mesh), expected)
        found += len(expected)
    assert found > 0


def test_residuals_of_many_widths_are_those_of_each():
    random = np.random.default_rng(0)
    d, s = random.uniform(-300, 300, 200), random.uniform(-1, 1, 200)
    z = 20.0 * np.tanh(d / 80.0) + 0.01 * d + 3.0 * s + random.normal(0, 0.5, 200)
    window = _Window(0.0, s, d, z, random.uniform(0.2, 1.0, 200), 300.0)
    widths = np.geomspace(5.0, 120.0, 7)
    expected = [window.fit(float(width))[1] for width in widths]
    np.testing.assert_allclose(window.residuals(widths), expected, rtol=1e-9)


def test_a_coarse_horizon_covers_the_same_part_of_the_plan():
    surface = grid_horizon(lambda x, y: 0.0 * x).surface
    middle = surface.vertices[surface.triangles].mean(axis=1)
    holed = surface.triangles[np.hypot(*middle[:, :2].T) > 500.0]
    plan = surface.vertices[:, :2]
    coarse = thinning.coarsened(plan, holed, 400.0)

    def areas(triangles):
        a, b, c = (plan[triangles[:, k]] for k in range(3))
        return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]

    assert len(coarse) < 0.7 * len(holed)
    assert (areas(coarse) > 0).all()
    assert areas(coarse).sum() == pytest.approx(areas(holed).sum())
    sides = [{tuple(edge) for edge in boundary_edges(t).tolist()} for t in (coarse, holed)]
    assert sides[0] == sides[1]
    # no triangle lies over the hole
    inside = np.array([[0.0, 0.0]])
    assert nearest(inside, plan, coarse).distance[0] > 300.0
