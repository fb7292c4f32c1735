"""Faults close to each other, to their junctions and to the outline: the parts that deal with them."""

from __future__ import annotations

import numpy as np
import pytest

from graben.cutgraph import CutGraph, NodeKind
from graben.modeling.courses import courses
from graben.modeling.cutting import opened
from graben.modeling.guides import Guides, branch, sections
from graben.modeling.narrows import narrows
from graben.modeling.resampling import Trace
from graben.modeling.snapping import unlooped
from graben.modeling.triangulation import triangulated
from graben.modeling.zone import zone_of
from tests.models import grid_horizon, plane_fault

STEP = 100.0


def straight(
    *lines: tuple[tuple[float, float], tuple[float, float]], kind: NodeKind = NodeKind.TIP
) -> CutGraph:
    """A cut graph of straight lines, each a fault, with nodes a step apart, at elevation 0."""
    nodes, edges, faults, kinds = [], [], [], []
    for k, (start, end) in enumerate(lines):
        count = round(float(np.hypot(*np.subtract(end, start))) / STEP) + 1
        share = np.linspace(0.0, 1.0, count)[:, None]
        first = sum(map(len, nodes))
        nodes.append(np.column_stack([(1 - share) * start + share * end, np.zeros(count)]))
        edges.append(first + np.stack([np.arange(count - 1), np.arange(1, count)], axis=1))
        faults.append(np.full(count - 1, k))
        kinds.append([kind, *[NodeKind.INTERIOR] * (count - 2), kind])
    return CutGraph(
        "H", np.concatenate(nodes), np.concatenate(kinds), np.concatenate(edges), np.concatenate(faults)
    )


def test_lip_moves_along_strike_as_its_ends_do() -> None:
    """By (1 - t)^2 and t^2 of it: the order along the lip is kept where unit vectors would turn it."""
    lip = np.column_stack([np.zeros(11), np.linspace(0.0, 1000.0, 11)])
    ways, slants = courses(lip, False, np.array([-0.5, 4.0]), np.array([-0.5, 0.0]), 100.0)
    assert ways == pytest.approx(np.tile([-1.0, 0.0], (11, 1)))
    # To the left of up-dip lies the begin of the lip.
    assert slants == pytest.approx(-4.0 * (1.0 - lip[:, 1] / 1000.0) ** 2)
    moved = lip[:, 1] - slants * 100.0
    assert (np.diff(moved) > 0).all()


@pytest.mark.parametrize("dip", [90.0, 60.0])
def test_slanting_section_follows_strike(dip: float) -> None:
    """Also on a vertical fault, which no vertical plane along its strike cuts in a line."""
    fault = plane_fault((0, -1000), (0, 1000), dip=dip).surface
    made = sections(fault, np.zeros((1, 3)), np.array([[-1.0, 0.0]]), np.array([0.75]))
    z = np.array([200.0])
    ((x, y),) = Guides.of(made).places(z)
    assert x == pytest.approx(-z[0] / np.tan(np.radians(dip)), abs=1e-9)
    assert y == pytest.approx(-0.75 * z[0])
    assert Guides.of(made).rates(z)[0, 1] == pytest.approx(-0.75)


def test_guide_of_a_point_beside_a_line_lies_on_the_line() -> None:
    line = np.array([[0.0, 0.0, -100.0], [0.0, 0.0, 0.0], [0.0, 0.0, 100.0]])
    guide = branch(line, np.array([3.0, 4.0, 10.0]), 200.0)
    assert guide[:, :2] == pytest.approx(0.0)
    assert guide[[0, -1], 2].tolist() == [-100.0, 100.0]


def crossing(width: float, outer: bool = False) -> Trace:
    """Three lines around an equilateral triangle of this side; or two that leave so far from each other."""
    a, b, c = np.array([[0.0, 0.0], [width, 0.0], [0.5 * width, np.sqrt(0.75) * width]])
    if outer:
        plan = np.array([c, a, b, c + 5 * (c - a), c + 5 * (c - b)])
        edges, faults = [[1, 0], [0, 3], [2, 0], [0, 4]], [0, 0, 1, 1]
    else:
        plan = np.array(
            [a, b, c, *(p + s * 5 * (q - p) for p, q in ((a, b), (b, c), (c, a)) for s in (-1, 1.2))]
        )
        edges = [[3, 0], [0, 1], [1, 4], [5, 1], [1, 2], [2, 6], [7, 2], [2, 0], [0, 8]]
        faults = [0, 0, 0, 1, 1, 1, 2, 2, 2]
    rim = np.isin(np.arange(len(plan)), [1, 2] if outer else []).astype(np.int64)
    points = np.column_stack([plan, np.zeros(len(plan))])
    return Trace(points, np.array(edges), np.array(faults), rim, np.zeros((len(edges), 2), dtype=np.int64))


@pytest.mark.parametrize("width", [0.05, 0.4, 0.7])
def test_narrow_loop_becomes_a_point(width: float) -> None:
    trace, gone = unlooped(crossing(width * STEP), STEP)
    assert len(gone) == 3
    nodes, count = np.unique(trace.edges, return_counts=True)
    assert sorted(count[np.isin(nodes, [0, 1, 2])].tolist()) == [6]


def test_wide_loop_stays() -> None:
    trace, gone = unlooped(crossing(1.5 * STEP), STEP)
    assert len(gone) == 0
    assert len(trace.edges) == 9


def test_crossing_beside_the_boundary_becomes_an_exit() -> None:
    trace, gone = unlooped(crossing(0.6 * STEP, outer=True), STEP)
    assert gone.tolist() == [0, 2]
    (node,) = np.intersect1d(*trace.edges)
    assert trace.outer[node] == 1


def test_no_triangle_of_outer_nodes_beside_an_exit() -> None:
    horizon = grid_horizon(lambda x, y: 0.0 * x)
    graph = straight(((1993.0, 2000.0), (500.0, 500.0)), kind=NodeKind.EXIT)
    graph.kinds.setflags(write=True)
    graph.kinds[-1] = NodeKind.TIP
    mesh = triangulated(horizon.surface, graph, STEP, np.array([400.0]))
    near = np.hypot(*(mesh.points[mesh.triangles].mean(axis=1)[:, :2] - [2000.0, 2000.0]).T) < 150.0
    assert not mesh.outer[mesh.triangles[near]].all(axis=1).any()


@pytest.mark.parametrize("half", [405.0, 430.0, 460.0])
def test_rim_of_the_zone_takes_nothing_from_beyond_a_fault(half: float) -> None:
    """The corridor between two zones is hardly a row of nodes wide, and lies 500 m lower."""
    horizon = grid_horizon(lambda x, y: np.where(np.abs(x) < half, -500.0, 0.0) + 0.1 * x + 0.05 * y)
    graph = straight(((-half, -1500.0), (-half, 1500.0)), ((half, -1500.0), (half, 1500.0)))
    zone = zone_of(horizon.surface, horizon.surface.triangles, graph, STEP, np.array([400.0, 400.0]))
    x, y, z = zone.ring[np.abs(zone.ring[:, 1]) < 1000.0].T
    assert (np.abs(x) < half).any()
    assert z == pytest.approx(np.where(np.abs(x) < half, -500.0, 0.0) + 0.1 * x + 0.05 * y, abs=1e-6)


def plate(half: float, end: float = 1500.0) -> tuple[CutGraph, np.ndarray, np.ndarray]:
    """Two parallel cuts, and the nodes and triangles of a plane opened along them."""
    graph = straight(((-half, -end), (-half, end)), ((half, -end), (half, end)))
    surface = grid_horizon(lambda x, y: 0.0 * x, size=6000.0).surface
    mesh = triangulated(surface, graph, STEP, np.array([400.0, 400.0]))
    cut = opened(mesh)
    return graph, mesh.points[cut.origin], cut.triangles


def test_strip_within_gamma_is_held_in_its_middle() -> None:
    graph, points, triangles = plate(350.0, 2000.0)
    (narrow,) = narrows(graph, points, triangles, np.array([400.0, 400.0]), np.zeros(2), STEP)
    held = points[narrow.held]
    assert (np.abs(held[:, 0]) <= 350.0 / 2 + STEP / 2).all()
    assert len(held) > 3 * 20
    assert np.abs(held[:, 1]).max() >= 1000.0
    assert narrow.faults.tolist() == [0, 1]
    assert "F1 and F2 the horizon is at most 6" in narrow.warning(["F1", "F2"], "m")


@pytest.mark.parametrize(("width", "least"), [(60.0, 175.0), (80.0, 200.0), (100.0, 250.0), (200.0, 297.5)])
def test_strip_is_held_beyond_the_smear(width: float, least: float) -> None:
    """Between a half and 85 % of its room; a smear that is not seen is that of the other fault."""
    graph, points, triangles = plate(350.0, 2000.0)
    gammas = np.array([400.0, 400.0])
    (narrow,) = narrows(graph, points, triangles, gammas, np.array([width, 0.0]), STEP)
    away = 350.0 - np.abs(points[:, 0])
    inside = np.flatnonzero((away > 0.0) & (np.abs(points[:, 1]) < 1500.0))
    held = np.isin(inside, narrow.held)
    room = away[inside].max() / 350.0
    assert held.any()
    assert away[inside[held]].min() > least * room - 1e-6
    assert away[inside[~held]].max() < least + 1e-6


def test_strip_that_tapers_is_held_all_along() -> None:
    """At its narrow end no node is half as far from the cuts as those in the middle of its wide end."""
    graph = straight(((-380.0, -2000.0), (-160.0, 2000.0)), ((380.0, -2000.0), (160.0, 2000.0)))
    surface = grid_horizon(lambda x, y: 0.0 * x, size=6000.0).surface
    gammas = np.array([400.0, 400.0])
    mesh = triangulated(surface, graph, STEP, gammas)
    cut = opened(mesh)
    (narrow,) = narrows(graph, mesh.points[cut.origin], cut.triangles, gammas, np.zeros(2), STEP)
    held = mesh.points[cut.origin[narrow.held], :2]
    held = held[np.abs(held[:, 1]) < 1800.0]
    half = 270.0 - held[:, 1] * 220.0 / 4000.0
    assert (half - np.abs(held[:, 0]) > 0.4 * half).all()
    assert np.diff(np.sort(held[:, 1]), prepend=-1800.0, append=1800.0).max() < 3.0 * STEP


@pytest.mark.parametrize("half", [600.0, 1000.0])
def test_strip_with_reliable_nodes_is_left_alone(half: float) -> None:
    graph, points, triangles = plate(half)
    assert narrows(graph, points, triangles, np.array([400.0, 400.0]), np.zeros(2), STEP) == []


def test_strip_without_a_node_is_warned_of() -> None:
    graph, points, triangles = plate(20.0, 2400.0)
    (narrow,) = narrows(graph, points, triangles, np.array([400.0, 400.0]), np.zeros(2), STEP)
    assert (len(narrow.held), narrow.width) == (0, 0.0)
    assert "the throws are a guess" in narrow.warning(["F1", "F2"], "m")
