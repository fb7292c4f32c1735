"""From the exact intersection to the opened mesh."""

from __future__ import annotations

import numpy as np
import pytest

from graben.cutgraph import NodeKind
from graben.model import Fault, Model
from graben.modeling.cutting import opened
from graben.modeling.tracing import cut_graph, exact_trace
from graben.modeling.triangulation import triangulated
from graben.refinement import refined
from graben.surface import edge_sharing, edge_table, strong_components
from tests.models import grid_horizon, model_of, plane_fault


def flat(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 0.05 * x + 20.0 * np.sin(y / 700.0)


def graph_of(model: Model):
    network = refined([f.surface for f in model.faults])
    return cut_graph(model, model.horizons[0], network)


def opened_mesh(model: Model):
    graph = graph_of(model)
    horizon = model.horizons[0]
    gammas = np.full(len(np.unique(graph.faults)), 400.0)
    mesh = triangulated(horizon.surface, graph, horizon.step, gammas)
    return graph, mesh, opened(mesh)


SHAPES = {
    "inside": ([plane_fault((0, -800), (60, 900))], {"tips": 2, "exits": 0, "junctions": 0, "parts": 1}),
    "one exit": ([plane_fault((0, -800), (60, 2600))], {"tips": 1, "exits": 1, "junctions": 0, "parts": 1}),
    "through": ([plane_fault((30, -2600), (60, 2600))], {"tips": 0, "exits": 2, "junctions": 0, "parts": 2}),
    "cross": (
        [plane_fault((0, -1100), (60, 1000)), plane_fault((-900, 50), (1100, 10), name="F2")],
        {"tips": 4, "exits": 0, "junctions": 1, "parts": 1},
    ),
    "cross through": (
        [plane_fault((0, -2600), (60, 2600)), plane_fault((-2600, 50), (2600, 10), name="F2")],
        {"tips": 0, "exits": 4, "junctions": 1, "parts": 4},
    ),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_ends_are_what_they_are(shape: str) -> None:
    faults, expected = SHAPES[shape]
    graph, _, cut = opened_mesh(model_of(grid_horizon(flat), *faults))
    kinds = np.bincount(graph.kinds, minlength=5)
    assert kinds[NodeKind.TIP] == expected["tips"]
    assert kinds[NodeKind.EXIT] == expected["exits"]
    assert kinds[NodeKind.JUNCTION] == expected["junctions"]
    assert kinds[NodeKind.LOOSE] == 0
    assert cut.labels.max() + 1 == expected["parts"]


@pytest.mark.parametrize("shape", SHAPES)
def test_copies_by_sector(shape: str) -> None:
    """k cut edges make k sectors inside and k + 1 on the outer boundary; a tip is not copied."""
    faults, _ = SHAPES[shape]
    graph, _, cut = opened_mesh(model_of(grid_horizon(flat), *faults))
    copies = np.bincount(cut.origin, minlength=len(graph.nodes))[: len(graph.nodes)]
    degree = np.bincount(graph.edges.ravel(), minlength=len(graph.nodes))
    assert (copies == degree + (graph.kinds == NodeKind.EXIT)).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_cut_is_open_and_every_subdomain_strongly_connected(shape: str) -> None:
    faults, _ = SHAPES[shape]
    graph, mesh, cut = opened_mesh(model_of(grid_horizon(flat), *faults))
    assert (cut.origin[cut.left] == graph.edges).all()
    assert (cut.origin[cut.right] == graph.edges).all()
    assert not (cut.left == cut.right).all(axis=1).any()
    assert (cut.origin[cut.triangles] == mesh.triangles).all()
    for label in range(cut.labels.max() + 1):
        assert strong_components(cut.triangles[cut.labels == label]).max() == 0


@pytest.mark.parametrize("shape", SHAPES)
def test_nodes_lie_on_horizon_and_fault(shape: str) -> None:
    faults, _ = SHAPES[shape]
    model = model_of(grid_horizon(flat), *faults)
    graph = graph_of(model)
    import igl

    for f, fault in enumerate(model.faults):
        mine = np.unique(graph.edges[graph.faults == f])
        for surface in (fault.surface, model.horizons[0].surface):
            away = igl.point_mesh_squared_distance(
                graph.nodes[mine].copy(), surface.vertices.copy(), surface.triangles.copy()
            )[0]
            assert np.sqrt(away.max()) < 1e-9 * model.size


@pytest.mark.parametrize("shape", SHAPES)
def test_edges_run_with_the_dip_to_the_right(shape: str) -> None:
    faults, _ = SHAPES[shape]
    model = model_of(grid_horizon(flat), *faults)
    graph = graph_of(model)
    for f, fault in enumerate(model.faults):
        low = fault.surface.vertices[np.argmin(fault.surface.vertices[:, 2]), :2]
        for a, b in graph.nodes[graph.edges[graph.faults == f]][:, :, :2]:
            assert (b - a)[1] * (low - a)[0] - (b - a)[0] * (low - a)[1] > 0


def test_mesh_outside_the_zone_is_the_input() -> None:
    model = model_of(grid_horizon(flat), plane_fault((0, -800), (60, 900)))
    _, mesh, _ = opened_mesh(model)
    given = {tuple(p) for p in model.horizons[0].surface.vertices.tolist()}
    far = mesh.points[np.abs(mesh.points[:, 0]) > 800.0]
    assert len(far) > 500
    assert all(tuple(p) in given for p in far.tolist())


def test_area_is_kept_and_every_triangle_is_upright() -> None:
    model = model_of(grid_horizon(flat), *SHAPES["cross through"][0])
    _, mesh, _ = opened_mesh(model)
    a, b, c = (mesh.points[mesh.triangles[:, k], :2] for k in range(3))
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    assert (area > 0).all()
    assert area.sum() == pytest.approx(4000.0**2, rel=1e-12)


def test_no_fault_no_change() -> None:
    horizon = grid_horizon(flat)
    far = plane_fault((0, -800), (60, 900), depth=50.0)
    lifted = Fault(far.surface.moved(np.array([0.0, 0.0, 5000.0])))
    _, mesh, cut = opened_mesh(model_of(horizon, lifted))
    assert (mesh.points == horizon.surface.vertices).all()
    assert (cut.origin == np.arange(len(mesh.points))).all()


def test_short_piece_and_stub_are_dropped_and_said() -> None:
    crossing = [plane_fault((0, -800), (60, 900)), plane_fault((-70, 0), (900, 10), name="F2")]
    graph = graph_of(model_of(grid_horizon(flat), *crossing))
    assert [d.reason for d in graph.dropped] == ["stub beyond a junction"]
    assert graph.dropped[0].fault == 1
    tiny = plane_fault((0, -80), (5, 90))
    graph = graph_of(model_of(grid_horizon(flat), tiny))
    assert len(graph.edges) == 0
    assert [d.reason for d in graph.dropped] == ["piece shorter than two steps"]


def test_refinement_leaves_parents_and_areas() -> None:
    surfaces = [f.surface for f in SHAPES["cross"][0]]
    network = refined(surfaces)
    from graben.surface import triangle_areas

    for k, surface in enumerate(surfaces):
        mine = network.owner == k
        parts = np.bincount(
            network.parent[mine],
            triangle_areas(network.vertices, network.triangles[mine]),
            minlength=len(surface.triangles),
        )
        assert parts == pytest.approx(triangle_areas(surface.vertices, surface.triangles), rel=1e-9)
    edges, sides = edge_table(network.triangles)
    assert (edge_sharing(sides, len(edges)) == 4).any()


def test_trace_does_not_depend_on_vertex_order() -> None:
    model = model_of(grid_horizon(flat), *SHAPES["cross"][0])
    rng = np.random.default_rng(3)
    shuffled = []
    for fault in model.faults:
        order = rng.permutation(len(fault.surface.vertices))
        back = np.argsort(order)
        triangles = back[fault.surface.triangles][rng.permutation(len(fault.surface.triangles))]
        from dataclasses import replace

        shuffled.append(
            Fault(replace(fault.surface, vertices=fault.surface.vertices[order], triangles=triangles))
        )
    lines = []
    for faults in (model.faults, tuple(shuffled)):
        trace = exact_trace(model.horizons[0].surface, refined([f.surface for f in faults]))
        length = np.linalg.norm(np.diff(trace.points[trace.edges], axis=1)[:, 0], axis=1)
        lines.append((np.bincount(trace.faults, length), len(trace.points)))
    assert lines[0][0] == pytest.approx(lines[1][0], rel=1e-12)
