"""W_fict: the wall of a closed prism, over the horizon's own boundary nodes."""

from __future__ import annotations

from dataclasses import replace

import manifold3d
import numpy as np
import pytest

from graben import demo
from graben.errors import ModelingError
from graben.modeling.fictitious import fictitious_fault, wall_edges
from graben.prism import over, volume
from graben.refinement import refined
from graben.surface import Surface, boundary_edges, triangle_normals
from tests.models import model_of_demo


def horizon_and_network(name="tee", **frame):
    model = model_of_demo(demo.build(name, step=200.0, **frame))
    return model.horizons[0].surface, refined([f.surface for f in model.faults])


def plan_area(horizon):
    return 0.5 * np.abs(triangle_normals(horizon.vertices, horizon.triangles)[:, 2]).sum()


@pytest.mark.parametrize("frame", [{}, {"rotation": 33.0, "shift": (450_000.0, 6_100_000.0)}])
def test_vertices_stand_over_the_boundary_nodes_to_the_bit(frame):
    horizon, network = horizon_and_network(**frame)
    wall = fictitious_fault(horizon, network)
    nodes = np.unique(boundary_edges(horizon.triangles))
    foot, head = np.split(wall.vertices, 2)
    assert np.array_equal(foot[:, :2], horizon.vertices[nodes, :2])
    assert np.array_equal(head[:, :2], horizon.vertices[nodes, :2])
    assert (triangle_normals(wall.vertices, wall.triangles)[:, 2] == 0.0).all()
    levels = np.concatenate([horizon.vertices[:, 2], network.vertices[:, 2]])
    assert (foot[:, 2] < levels.min()).all()
    assert (head[:, 2] > levels.max()).all()


@pytest.mark.parametrize("frame", [{}, {"rotation": 33.0, "shift": (450_000.0, 6_100_000.0)}])
def test_the_wall_belongs_to_a_closed_prism_of_known_volume(frame):
    horizon, _ = horizon_and_network(**frame)
    made = over("prism", horizon, -2000.0, -1000.0)
    assert volume(made.surface) == pytest.approx(1000.0 * plan_area(horizon), rel=1e-11)
    centred = made.surface.vertices - made.surface.vertices.mean(axis=0)
    solid = manifold3d.Manifold(manifold3d.Mesh64(centred, made.surface.triangles.astype(np.uint64)))
    assert solid.status() == manifold3d.Error.NoError
    assert solid.volume() == pytest.approx(volume(made.surface), rel=1e-11)
    kept = {row.tobytes() for row in solid.to_mesh64().vert_properties}
    assert kept == {row.tobytes() for row in centred}, (
        "manifold3d moves vertices: then the wall may not be its"
    )


def test_a_horizon_that_turns_the_other_way_has_the_same_wall():
    horizon, network = horizon_and_network()
    turned = replace(horizon, triangles=horizon.triangles[:, ::-1])
    for ours, theirs in zip(wall_edges(horizon, network)[1:], wall_edges(turned, network)[1:], strict=True):
        assert np.array_equal(ours, theirs)


def test_a_hole_has_a_wall_and_takes_its_volume():
    horizon, network = horizon_and_network()
    x, y = horizon.vertices[horizon.triangles].mean(axis=1)[:, :2].T
    hole = (np.abs(x - 4400.0) < 1000.0) & (np.abs(y - 4000.0) < 600.0)
    open_horizon = replace(horizon, triangles=horizon.triangles[~hole])
    assert hole.any()
    made = over("prism", open_horizon, 0.0, 10.0)
    assert volume(made.surface) == pytest.approx(10.0 * plan_area(open_horizon), rel=1e-12)
    wall = fictitious_fault(open_horizon, network)
    assert len(wall.triangles) == 2 * len(boundary_edges(open_horizon.triangles))


def test_parts_that_touch_in_a_node_are_closed_too():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    vertices = np.concatenate([square, (square + np.array([1.0, 1.0, 0.0]))[1:]])
    triangles = [[0, 1, 2], [0, 2, 3], [2, 4, 5], [2, 5, 6]]
    assert volume(over("two", Surface("H", vertices, triangles), 0.0, 3.0).surface) == 6.0


def test_a_horizon_without_plan_area_is_told_so():
    upright = Surface("H", [[0, 0, 0], [1, 0, 0], [1, 0, 1]], [[0, 1, 2]])
    with pytest.raises(ModelingError, match="bounds no area in plan"):
        fictitious_fault(upright, refined([]))
