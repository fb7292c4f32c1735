"""The checks on the cut graph: on graphs drawn by hand, and against answers in metres."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from graben.cutgraph import CutGraph, DroppedTrace
from graben.finding import Finding, Profile, Status
from graben.model import Fault, Model
from graben.pipeline import build, check
from graben.settings import Parameters
from graben.validators.acyclic import cycles
from graben.validators.junction import common_edges
from graben.validators.junction_values import difference, junctions
from graben.validators.measuring.measures import components
from graben.validators.measuring.trace_measures import gaps_between, outline, pieces_of
from graben.validators.runner import run_checks
from tests.zoo.networks import around, conforming, cut, field, flat, plane
from tests.zoo.shapes import STEP, Fakes, J, L, N, T, X, anchoring, dipping, faults, graph, level

LINE = [(1, 4), (2, 4), (3, 4), (4, 4), (5, 4)]
CHAIN = [(0, 1), (1, 2), (2, 3), (3, 4)]
SQUARE = [(2, 2), (5, 2), (5, 5), (2, 5)]
ROUND = [(0, 1), (1, 2), (2, 3), (3, 0)]
ALONE = (anchoring(100),)
WITHIN = (3.5 * STEP, 3.5 * STEP, 0.0)
HELD = (anchoring(100), anchoring(7, place=WITHIN, subdomain=1))
LOOSE = (anchoring(100), anchoring(0, place=WITHIN, subdomain=1))
SHORT = DroppedTrace(0, 0.8 * STEP, np.array([7 * STEP, 4 * STEP, 35.0]), "shorter than 2 steps")


@dataclass(frozen=True)
class Drawn:
    """A cut graph by hand, in steps, and what is said of it under extended and paper; "pass" for nothing."""

    check: str
    name: str
    net: CutGraph
    extended: str = "pass"
    paper: str = "pass"
    blocks: bool = False
    objects: tuple[str, ...] = ()
    anchors: tuple = ALONE


def traced(net: CutGraph, anchors=ALONE, profile: Profile = Profile.EXTENDED):
    """What is said of a level horizon with this cut graph; the faults are those its owners ask for."""
    count = int(max([*net.faults, *(d.fault for d in net.dropped), 0])) + 1
    model = faults(*(dipping(60, name="FGK"[k]) for k in range(count)), horizons=[level()])
    return run_checks(model, profile, Fakes(graphs={"H": net}, anchors={"H": anchors}))


def _line(kinds, edges=CHAIN, owners=None, dropped=()) -> CutGraph:
    return graph(LINE, kinds, edges, [0] * len(edges) if owners is None else owners, dropped)


def _square(kinds, owners, nodes=SQUARE, edges=ROUND) -> CutGraph:
    return graph(nodes, kinds, edges, owners)


BOTH = [*CHAIN, (2, 1)]
CROSS = graph(
    [(1, 4), (3, 4), (5, 4), (3, 2), (3, 6)], [T, J, T, T, T], [(0, 1), (1, 2), (3, 1), (1, 4)], [0, 0, 1, 1]
)
STAR = graph(
    [(3, 3), (1, 3), (5, 3), (3, 5), (3, 1)], [J, T, T, T, T], [(0, 1), (0, 2), (0, 3), (0, 4)], [0, 0, 1, 1]
)
LANES = graph([(1, 3), (4, 3), (1, 5), (4, 5), (1, 4), (6, 4)], [X] * 6, [(0, 1), (2, 3), (4, 5)], [0, 1, 2])
TAILED = _square([J] * 4 + [T], [0, 1, 2, 2, 0], [*SQUARE, (7, 2)], [*ROUND, (1, 4)])
ALONG = {"objects": ("H", "F")}
AT = {"objects": ("H", "F", "G"), "extended": "fail", "paper": "fail", "blocks": True}
HERE = {"objects": ("H",)}
SAID = [
    Drawn("trace", "loose end", _line([T, N, N, N, L]), "fail", "fail", True, **ALONG),
    Drawn("trace", "two loose ends", _line([L, N, N, N, L]), "fail", "fail", True, **ALONG),
    Drawn("trace", "two pieces", _line([T, N, T, T, T], [(0, 1), (1, 2), (3, 4)]), "warn", "fail", **ALONG),
    Drawn("trace", "left out", _line([T, N, N, N, T], dropped=[SHORT]), "warn", "warn", **ALONG),
    Drawn("trace", "one line", _line([T, N, N, N, T])),
    Drawn("trace", "leaves the domain", _line([X, N, N, N, T])),
    Drawn("trace", "crosses another", CROSS),
    Drawn("junction", "one common edge", _line([T, J, J, N, T], BOTH, [0, 0, 0, 0, 1]), **AT),
    Drawn("junction", "two", _line([T, J, N, J, T], [*CHAIN, (1, 2), (2, 3)], [0] * 4 + [1] * 2), **AT),
    Drawn("junction", "the same line", _line([T, N, N, N, T], [*CHAIN, *CHAIN], [0] * 4 + [1] * 4), **AT),
    Drawn("junction", "crosses another", CROSS),
    Drawn("acyclic", "not held", _square([J] * 4, [0, 1, 2, 2]), "fail", "fail", anchors=LOOSE, **HERE),
    Drawn("acyclic", "held", _square([J] * 4, [0, 1, 2, 2]), "warn", "fail", anchors=HELD, **HERE),
    Drawn("acyclic", "with a tail", TAILED, "warn", "fail", anchors=HELD, **HERE),
    Drawn("acyclic", "on itself", _square([N] * 4, [0] * 4), "warn", "fail", anchors=HELD, **HERE),
    Drawn("acyclic", "open", graph(SQUARE, [T, J, J, T], ROUND[:3], [0, 1, 2])),
    Drawn("acyclic", "star", STAR),
    Drawn("acyclic", "side by side", LANES),
    Drawn("acyclic", "a common edge is none", _line([T, J, J, N, T], BOTH, [0, 0, 0, 0, 1])),
    Drawn("anchored", "none fixed", _line([T, N, N, N, T]), "fail", "fail", anchors=LOOSE, **HERE),
    Drawn("anchored", "two", _line([T, N, N, N, T]), "fail", "fail", anchors=(anchoring(2, False),), **HERE),
    Drawn(
        "anchored", "in line", _line([T, N, N, N, T]), "fail", "fail", anchors=(anchoring(9, False),), **HERE
    ),
    Drawn("anchored", "three", _line([T, N, N, N, T]), anchors=(anchoring(3), anchoring(90))),
]


@pytest.mark.parametrize("drawn", SAID, ids=lambda d: f"{d.check}: {d.name}")
def test_graphs_by_hand(drawn):
    for profile, status in ((Profile.EXTENDED, drawn.extended), (Profile.PAPER, drawn.paper)):
        result, evidence = traced(drawn.net, drawn.anchors, profile)
        assert [(str(f.status), f.objects) for f in result.of(drawn.check)] == [(status, drawn.objects)]
        assert any(f.check == drawn.check for f in evidence.blocking) == drawn.blocks


def only(result, check_id: str) -> Finding:
    (finding,) = result.of(check_id)
    return finding


def values(finding: Finding, kind: str) -> list[float]:
    return [p.value for p in finding.parts if p.kind == kind]


# --- trace


def test_an_end_at_a_hole_is_as_far_from_the_rim_ahead_as_drawn():
    # a fault of 700 m through a hole of 200 m: each end has 450 m to go, to the rim ahead of it
    model = cut(field(flat, hole=(-2, 2, -2, 2)), plane((-7, 0.3), (7, 0.3)))
    finding = only(check(model), "trace")
    assert values(finding, "loose end") == pytest.approx([450.0, 450.0])
    assert values(finding, "piece") == pytest.approx([250.0, 250.0])
    assert values(finding, "gap") == pytest.approx([200.0])
    assert "450 m short of the rim of F" in finding.message
    assert {tuple(np.round(p.place, 6)) for p in finding.parts if p.kind == "loose end"} == {
        (-100.0, 15.0, 0.0),
        (100.0, 15.0, 0.0),
    }


def test_an_end_at_a_hole_names_the_fault_or_the_boundary_that_is_nearest():
    hole = field(flat, hole=(-2, 2, -2, 2))
    upright = plane((-6, 3), (6, 3), "G", dip=89.99)
    model = cut(hole, plane((-7, 1.5), (1.9, 1.5)), upright)
    (part,) = (p for p in only(check(model), "trace").parts if p.kind == "loose end")
    assert part.objects == ("H", "F", "G")
    assert part.value == pytest.approx(1.5 * STEP, rel=1e-6)
    by_the_edge = cut(field(flat, hole=(-2, 2, 6, 9)), plane((-7, 7.7), (1.9, 7.7)))
    finding = only(check(by_the_edge), "trace")
    assert finding.message.endswith("115 m short of the outer boundary of H.")
    assert values(finding, "loose end") == pytest.approx([2.3 * STEP])


def test_a_hole_is_no_boundary_to_the_gate_but_one_to_the_model():
    model = cut(field(hole=(-2, 2, -2, 2)), plane((-7.1, 0.3), (7.3, -0.2)))
    run = build(model)
    assert not run.passed
    assert run.not_modeled == {}
    assert run["H"].converged


def test_the_outline_tells_holes_from_parts():
    (ring,) = outline(field(flat, hole=(-2, 2, -3, 2)).surface)
    assert ring.area == pytest.approx((400 - 20) * STEP**2)
    assert [shapely.Polygon(hole).area for hole in ring.interiors] == pytest.approx([20 * STEP**2])


def test_gaps_join_each_piece_to_its_next():
    # four pieces in a row, 1, 2 and 3 steps apart, drawn in another order
    nodes = [(9, 4), (11, 4), (0, 4), (1, 4), (2, 4), (4, 4), (6, 4), (6.5, 4)]
    net = graph(nodes, [T] * 8, [(0, 1), (2, 3), (4, 5), (6, 7)], [0] * 4)
    pieces = pieces_of(net, 0)
    assert [p.length / STEP for p in pieces] == pytest.approx([2, 2, 1, 0.5])
    assert [g.width / STEP for g in gaps_between(pieces)] == pytest.approx([1, 2, 2.5])


def test_an_idle_fault_says_by_how_much_it_misses():
    model = cut(field(flat), plane((-5, 0), (5, 0), top=-0.2, bottom=-3.0))
    finding = only(check(model), "trace")
    assert finding.worst.value == pytest.approx(10.0)
    under = cut(field(lambda x, y: 0.3 * x), plane((2, 0), (6, 0), top=0.0, bottom=-3.0, dip=80.0))
    finding = only(check(under), "trace")
    # it ends where the horizon is lowest over it: 30 m above its western end, on a slope of 0.3
    assert finding.message.startswith("F cuts no horizon: it ends 28.7 m before it reaches one.")
    assert finding.worst.value == pytest.approx(30.0 / np.hypot(1.0, 0.3))


# --- junction


def test_three_faults_on_one_edge_are_three_pairs():
    net = _line([T, J, J, N, T], [*CHAIN, (2, 1), (1, 2)], [0] * 4 + [1, 2])
    assert {pair: edges.tolist() for pair, edges in common_edges(net).items()} == {
        (0, 1): [1],
        (0, 2): [1],
        (1, 2): [4],
    }


def test_stretches_have_their_length():
    net = _line([T, J, N, J, T], [*CHAIN, (1, 2), (2, 3)], [0] * 4 + [1] * 2)
    finding = only(traced(net)[0], "junction")
    assert finding.worst.value == pytest.approx(2 * STEP)
    assert values(finding, "common stretch") == pytest.approx([2 * STEP])
    assert finding.elements.tolist() == [1, 3]


# --- junction-values


@pytest.mark.parametrize("dip", [30.0, 60.0, 85.0])
@pytest.mark.parametrize("short", [1e-3, 0.02])
def test_a_gap_counts_by_the_elevation_of_the_fault_it_misses(dip, short):
    main = plane((0, -6), (0, 6), "G", dip=dip)
    splay = plane((-6, 0), (0, 0), dip=70.0, onto=((0, -6), (0, 6), dip), short=short)
    at = np.array([[-short * STEP, 0.0, 0.0]])
    want = short * STEP * np.tan(np.radians(dip))
    assert difference(splay, main, at, 1e-6) == pytest.approx([want], rel=1e-6)
    assert difference(main, splay, at, 1e-6) == pytest.approx([want], rel=1e-6)


def test_short_of_a_vertical_fault_the_distance_counts():
    main = plane((0, -6), (0, 6), "G", dip=90.0)
    splay = plane((-6, 0), (0, 0), onto=((0, -6), (0, 6), 90.0), short=0.01)
    assert difference(splay, main, np.array([[0.0, 0.0, 0.0]]), 1e-6) == pytest.approx([0.5])


def test_two_rims_that_face_each_other_differ_by_their_distance():
    first, second = plane((-6, 0), (-0.01, 0)), plane((0.01, 0), (6, 0), "G")
    assert difference(first, second, np.array([[0.0, 0.0, 0.0]]), 1e-6) == pytest.approx([1.0])


def test_faults_that_cross_do_not_differ_however_far_off_the_node_is():
    # three lines that all but meet: one node stands for three crossings
    star = [plane((-6, -0.3), (6, 0.3)), plane((-6, -6), (6, 6), "G"), plane((1.0006, -8), (-0.9994, 8), "K")]
    result = check(cut(field(flat), *star))
    assert only(result, "junction-values").status is Status.PASS
    loose = Model("zoo", (field(flat),), tuple(Fault(s) for s in star), parameters=Parameters(gamma=2 * STEP))
    assert only(check(loose), "junction-values").status is Status.PASS


def test_each_pair_at_a_junction_is_asked():
    net = graph([(3, 3), (1, 3), (5, 3), (3, 5)], [J, T, T, T], [(0, 1), (0, 2), (0, 3)], [0, 1, 2])
    assert {pair: nodes.tolist() for pair, nodes in junctions(net).items()} == {
        (0, 1): [0],
        (0, 2): [0],
        (1, 2): [0],
    }


def test_where_faults_run_together_there_is_no_junction_to_differ_at():
    slanted = plane((-5, 0.1), (5, 0.3))
    result = check(cut(field(), slanted, plane((-5, 0.1003), (5, 0.3003), "G")))
    assert only(result, "junction").status is Status.FAIL
    assert only(result, "junction-values").status is Status.PASS


# --- acyclic


@pytest.mark.parametrize("count", [3, 4])
@pytest.mark.parametrize("radius", [2.6, 3.2])
def test_a_polygon_of_faults_has_its_area_and_its_faults_in_order(count, radius):
    model = cut(field(flat), *around(radius, count, dips=(70.0,) * 4))
    finding = only(check(model), "acyclic")
    (part,) = finding.parts
    assert part.objects == ("H", *"FGKL"[:count])
    assert part.value == pytest.approx(count * np.tan(np.pi / count) * (radius * STEP) ** 2)
    assert part.place == pytest.approx((0.4 * STEP, 0.3 * STEP, 0.0))
    assert part.unit == "m²"
    (path,) = finding.paths
    assert (path[0] == path[-1]).all()
    assert shapely.Polygon(path[:, :2]).area == pytest.approx(part.value)


def test_the_faults_of_a_cycle_are_named_in_the_order_along_it():
    # the square is closed by F, K, G, F: F is met twice
    net = _square([J] * 4, [0, 2, 1, 0])
    (cycle,) = cycles(net)
    assert cycle.faults == (0, 2, 1)
    assert cycle.face.area == pytest.approx(9 * STEP**2)


def test_a_ring_within_a_ring_has_two_faces():
    outer = [(0, 0), (6, 0), (6, 6), (0, 6)]
    inner = [(2, 2), (4, 2), (4, 4), (2, 4)]
    net = graph([*outer, *inner], [J] * 8, [*ROUND, *(np.array(ROUND) + 4)], [0] * 4 + [1] * 4)
    assert [c.face.area / STEP**2 for c in cycles(net)] == pytest.approx([4, 32])


def test_a_part_elsewhere_that_is_not_held_does_not_count():
    inside = anchoring(7, place=WITHIN, subdomain=1)
    elsewhere = anchoring(0, place=(7 * STEP, 7 * STEP, 0.0), subdomain=2)
    net = _square([J] * 4, [0, 1, 2, 2])
    assert only(traced(net, (inside, elsewhere))[0], "acyclic").status is Status.WARN
    swapped = (replace(inside, fixed=0), replace(elsewhere, fixed=7))
    assert only(traced(net, swapped)[0], "acyclic").status is Status.FAIL


@settings(max_examples=40, deadline=None, derandomize=True, database=None)
@given(st.lists(st.tuples(st.integers(0, 4), st.integers(0, 4), st.booleans()), max_size=40))
def test_there_are_as_many_cycles_as_euler_counts(sides):
    """E - V + C on any part of a square grid, whose edges do not cross; a repeated edge counts once."""
    edges = [(5 * i + j, 5 * i + j + 5 if along else 5 * i + j + 1) for i, j, along in sides]
    edges = [(a, b) for a, b in edges if b < 25 and (b == a + 5 or b % 5)]
    nodes = [(i, j) for i in range(5) for j in range(5)]
    net = graph(nodes, [N] * 25, edges, [k % 3 for k in range(len(edges))])
    pairs = np.unique(np.reshape(edges, (-1, 2)).astype(int), axis=0)
    pieces = len(np.unique(components(25, pairs)))
    assert len(cycles(net)) == len(pairs) - 25 + pieces


# --- anchored


@pytest.mark.parametrize(
    "model",
    [
        cut(field(), plane((5.9, 10.9), (10.9, 6.1))),
        cut(field(), *around(1.8, beyond=3.5)),
    ],
    ids=["corner", "triangle"],
)
def test_the_gamma_that_is_named_holds(model):
    finding = only(check(model), "anchored")
    assert finding.status is Status.FAIL
    gamma = float(finding.remedy.split("below ")[1].split(" m ")[0])
    assert 0 < gamma < 2 * STEP
    less = replace(model, parameters=Parameters(gamma=0.9 * gamma))
    assert only(check(less), "anchored").status is Status.PASS


def test_where_no_gamma_would_do_none_is_named():
    finding = only(check(cut(field(), *around(0.7))), "anchored")
    assert "gamma" not in finding.remedy
    assert [p.objects for p in finding.parts] == [("H", "F", "G", "K")]


# --- the shapes


def test_conforming_faults_share_what_they_share_to_the_bit():
    first, second = conforming(plane((-6, 0), (6, 0)), plane((0, -6), (0.4, 6), "G"))
    both = set(map(tuple, first.vertices)) & set(map(tuple, second.vertices))
    assert len(both) >= 2
