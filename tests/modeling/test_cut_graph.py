"""What is kept of a trace, and where its nodes stand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from graben.cutgraph import NodeKind
from graben.model import Fault, Model
from graben.modeling.preparation import prepared
from graben.modeling.tracing import cut_graph
from graben.refinement import refined
from graben.surface import Surface
from tests.zoo.networks import around, cut, field, pipe, plane
from tests.zoo.shapes import STEP


def graph_of(model: Model):
    return cut_graph(model, model.horizons[0], refined([f.surface for f in model.faults]))


def test_a_fault_ends_at_its_own_tip_where_what_it_met_there_is_left_out() -> None:
    # G, less than a step long, crosses F a third of a step before its tip: with G gone that is no stub
    long, short = plane((-7, 0.3), (0, 0.3)), plane((-0.35, 0.7), (-0.35, -0.1), "G")
    graph = graph_of(cut(field(), long, short))
    alone = graph_of(cut(field(), long))
    assert [(d.fault, d.reason) for d in graph.dropped] == [(1, "piece shorter than two steps")]
    assert (graph.kinds == NodeKind.TIP).sum() == 2
    assert not (graph.kinds == NodeKind.LOOSE).any()
    ends = [g.nodes[g.kinds == NodeKind.TIP] for g in (graph, alone)]
    assert np.sort(ends[0], axis=0) == pytest.approx(np.sort(ends[1], axis=0))


def test_both_stubs_of_a_corner_are_left_out() -> None:
    first, second = plane((-7, 0.3), (0.4, 0.3)), plane((0, -6), (0, 0.7), "G")
    graph = graph_of(cut(field(), first, second))
    assert [d.reason for d in graph.dropped] == ["stub beyond a junction"] * 2
    kinds = np.bincount(graph.kinds, minlength=5)
    assert kinds[[NodeKind.TIP, NodeKind.JUNCTION, NodeKind.LOOSE]].tolist() == [2, 1, 0]


def test_no_end_of_random_faults_lies_nowhere() -> None:
    rng = np.random.default_rng(5)
    for _ in range(60):
        made, last = [], np.zeros(2)
        for k in range(rng.integers(2, 5)):
            start = last + rng.normal(0, 0.4, 2)
            angle, length = rng.uniform(0, 2 * np.pi), rng.choice([1.2, 2.4, 6.0])
            end = start + length * np.array([np.cos(angle), np.sin(angle)])
            made.append(plane(start, end, f"F{k}", dip=rng.uniform(40, 85)))
            last = end if rng.random() < 0.5 else start
        model = Model("random", (field(),), tuple(Fault(f) for f in made))
        assert not (graph_of(model).kinds == NodeKind.LOOSE).any()


def test_a_ring_keeps_its_sharpest_corner_and_its_way_round_whatever_the_order_of_its_vertices() -> None:
    ring = pipe(4.0)
    order = np.random.default_rng(2).permutation(len(ring.vertices))
    triangles = np.argsort(order)[ring.triangles][::-1, ::-1]
    found = []
    for surface in (ring, Surface("F", ring.vertices[order], triangles)):
        graph = graph_of(cut(field(), surface))
        (face,) = shapely.get_parts(
            shapely.polygonize(shapely.linestrings(graph.nodes[graph.edges][:, :, :2]))
        )
        found.append(graph.nodes[np.lexsort(graph.nodes.T)])
        a, b = np.moveaxis(graph.nodes[graph.edges][:, :, :2], 1, 0)
        left = a + 0.5 * (b - a) + 1e-3 * np.column_stack([a[:, 1] - b[:, 1], b[:, 0] - a[:, 0]])
        assert shapely.contains_xy(face, left).all()
    assert found[0] == pytest.approx(found[1], abs=1e-9 * STEP)
    tip = np.argmax(found[0][:, 1])
    assert found[0][tip, :2] == pytest.approx([0.3 * STEP, (0.2 + 1.2 * 4.4) * STEP], abs=0.2 * STEP)


def test_the_place_of_a_subdomain_lies_in_it() -> None:
    # the middle of what surrounds a pipe lies in the pipe
    model = cut(field(), pipe(4.0))
    graph = graph_of(model)
    (face,) = shapely.get_parts(shapely.polygonize(shapely.linestrings(graph.nodes[graph.edges][:, :, :2])))
    anchors = prepared(model, model.horizons[0], graph).anchors
    assert [a.faults for a in anchors] == [("F",), ("F",)]
    assert sorted(face.contains(shapely.Point(a.place[:2])) for a in anchors) == [False, True]


def test_the_gamma_that_would_hold_a_part_leaves_three_nodes_beyond_it() -> None:
    model = cut(field(), *around(1.8, beyond=3.5))
    ready = prepared(model, model.horizons[0], graph_of(model))
    (loose,) = (a for a in ready.anchors if not a.holds)
    assert 0 < loose.gamma < 2 * STEP
    mine = ready.first[ready.cut.node_labels == loose.subdomain]
    lines = shapely.multilinestrings(shapely.linestrings(ready.graph.nodes[ready.graph.edges][:, :, :2]))
    away = shapely.distance(shapely.points(mine[:, :2]), lines)
    assert (away >= loose.gamma - 1e-9).sum() >= 3
    assert (away > loose.gamma + 1e-9).sum() < 3


def test_a_gamma_of_few_steps_is_told_once_with_what_to_do() -> None:
    model = cut(field(), pipe(4.0))
    (fault,) = model.faults
    few = replace(model, faults=(replace(fault, gamma=1.5 * STEP),))
    (said,) = [w for w in prepared(few, few.horizons[0], graph_of(few)).warnings if "less than 2 steps" in w]
    assert f"at F ({1.5 * STEP:g}" in said and "To do: nothing, where the horizon" in said
    assert f"else set gamma to at least {2 * STEP:g}" in said and said.endswith("or give a finer grid.")
    assert not [w for w in prepared(model, model.horizons[0], graph_of(model)).warnings if "steps of" in w]
