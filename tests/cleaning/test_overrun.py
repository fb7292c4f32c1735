"""contacts: a branch whose rim runs on past the parent's own rim meets it in common edges up to there."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from graben.cleaning.shaping.conforming import stacked
from graben.cleaning.shaping.imprint import imprinted
from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.rim_points import SNAP
from graben.finding import Status
from graben.model import Fault
from graben.pipeline import check
from graben.proximity import nearest
from graben.repairs import RepairResult, repair
from graben.surface import boundary_edges, triangle_areas
from tests.cleaning.branching import MAX_MOVE, STEP, WIDE, Branching
from tests.cleaning.test_contacts import common_edges

#: Branch lines by what of the parent's rim they run past.
PAST = {
    "lateral": ((703.0, 412.0), (2133.0, 412.0)),
    "lateral, slanted": ((703.0, 412.0), (2133.0, 590.0)),
    "lower": ((603.0, 312.0), (1000.0, 1290.0)),
    "upper": ((603.0, 612.0), (900.0, -390.0)),
    "both ends": ((-480.0, 412.0), (2133.0, 460.0)),
    "near a corner": ((703.0, 412.0), (2000.0, 1027.0)),
}
LYING = (
    *(Branching(line) for line in PAST.values()),
    Branching(PAST["lateral"], edge=40.0, strike=118.0, dip=45.0),
    Branching(PAST["lower"], edge=230.0, strike=203.0, angle=115.0),
    Branching(PAST["both ends"], edge=170.0, strike=301.0, dip=75.0, angle=50.0),
    # the digits of a file
    Branching(PAST["lateral, slanted"], off=1e-3, strike=75.0),
    Branching(PAST["near a corner"], off=-1e-3, edge=150.0),
    # a vertex of the rim just past the parent's, and just before it
    Branching(((603.0, 412.0), (2003.0, 412.0))),
    Branching(((597.0, 412.0), (1997.0, 412.0))),
    # edges of the rim that span the parent
    Branching(((-210.0, 380.0), (390.0, 540.0)), edge=310.0, size=(180.0, 900.0)),
)
GAPS = (
    *(Branching(line, off=0.6 * STEP) for line in PAST.values()),
    Branching(PAST["lateral"], off=0.2 * STEP, edge=60.0, strike=160.0),
    Branching(PAST["lateral, slanted"], off=STEP, strike=250.0, dip=70.0),
)
STUBS = tuple(Branching(PAST[name], off=-0.3 * STEP) for name in ("lateral", "lower", "both ends"))


def named(case: Branching) -> str:
    """The name of a case: the line and what sets it apart."""
    line = next((name for name, ends in PAST.items() if ends == case.line), "other line")
    return f"{line}, off {case.off:g}, edges {case.edge:g}, strike {case.strike:g}"


@cache
def mended(case: Branching) -> RepairResult:
    """What a repair makes of a branching under the paper, once."""
    return repair(case.model(), "paper")


def failing(result) -> list[tuple[str, tuple[str, ...]]]:
    return [(f.check, f.objects) for f in result.findings if f.status is Status.FAIL]


def areas(result: RepairResult, case: Branching) -> list[float]:
    """The areas of parent and branch over what they were."""
    pairs = zip(result.model.faults, case.model().faults, strict=True)
    return [
        float(np.divide(*(triangle_areas(f.surface.vertices, f.surface.triangles).sum() for f in pair)))
        for pair in pairs
    ]


@pytest.mark.parametrize("case", LYING, ids=named)
def test_the_rim_of_a_branch_is_edges_of_the_parent_as_far_as_the_parent_goes(case: Branching) -> None:
    assert failing(check(case.model(), "paper")) == [("simplicial-complex", ("P", "B"))]
    result = mended(case)
    assert failing(result.after) == []
    p, b = (fault.surface for fault in result.model.faults)
    assert common_edges(p, b) == pytest.approx(case.shared, rel=0.01)
    assert areas(result, case) == pytest.approx([1.0, 1.0], abs=0.02)
    for made, given in zip((p, b), case.model().faults, strict=True):
        assert distances(made, [given.surface]).max() <= MAX_MOVE


@pytest.mark.parametrize("case", LYING, ids=named)
def test_what_lies_beyond_the_parent_stays_as_it_was(case: Branching) -> None:
    p, b = (fault.surface for fault in case.model().faults)
    rim = b.vertices[np.unique(boundary_edges(b.triangles))]
    far = rim[nearest(rim, p.vertices, p.triangles).distance > STEP]
    made = mended(case).model.faults[1].surface
    left = made.vertices[np.unique(boundary_edges(made.triangles))]
    assert len(far) >= 5
    # but for the rounding of the frame that repairs work in
    assert cKDTree(left).query(far)[0].max() < 1e-9


@pytest.mark.parametrize("case", GAPS, ids=named)
def test_a_branch_that_stops_short_of_the_parent_is_extended_to_it(case: Branching) -> None:
    result = mended(case)
    assert failing(result.after) == []
    assert [note for note in result.left if note.check == "near-miss"] == []
    p, b = (fault.surface for fault in result.model.faults)
    assert common_edges(p, b) == pytest.approx(case.shared, rel=0.1)


@pytest.mark.parametrize("case", STUBS, ids=named)
def test_a_branch_that_passes_the_parent_meets_it_in_common_edges(case: Branching) -> None:
    result = mended(case)
    assert failing(result.after) == []
    p, b = (fault.surface for fault in result.model.faults)
    assert common_edges(p, b) == pytest.approx(case.shared, rel=0.1)
    assert areas(result, case) == pytest.approx([1.0, 1.0], abs=0.02)


@pytest.mark.parametrize("case", (*LYING, *GAPS, *STUBS), ids=named)
def test_repaired_twice_is_repaired_once(case: Branching) -> None:
    once = mended(case)
    twice = repair(once.model, "paper")
    assert twice.actions == ()
    assert all(a.surface is b.surface for a, b in zip(once.model.faults, twice.model.faults, strict=True))


@pytest.mark.parametrize(("edge", "angle"), [(60.0, -80.0), (140.0, -50.0), (90.0, 120.0), (230.0, 110.0)])
def test_two_branches_from_one_line_that_runs_past_the_parent_meet_it_and_each_other(
    edge: float, angle: float
) -> None:
    first = Branching(PAST["lateral, slanted"], angle=65.0)
    second = Branching(PAST["lateral, slanted"], edge=edge, angle=angle)
    model = first.model()
    other = replace(second.model().faults[1].surface, name="C")
    result = repair(replace(model, faults=(*model.faults, Fault(other))), "paper")
    assert failing(result.after) == []
    p, b, c = (fault.surface for fault in result.model.faults)
    assert common_edges(p, b) == pytest.approx(first.shared, rel=0.01)
    assert common_edges(p, c) == pytest.approx(first.shared, rel=0.01)
    assert common_edges(b, c) == pytest.approx(np.linalg.norm(np.diff(first.ends, axis=0)), rel=0.01)
    assert repair(result.model, "paper").actions == ()


def test_a_rim_that_leaves_the_parent_in_the_air_gets_no_vertex_beyond_the_last_that_lies_on_it() -> None:
    case = Branching(((300.0, 450.0), (1300.0, 450.0)))
    p, b = (fault.surface for fault in case.model().faults)
    start, end = case.ends
    way = (end - start) / np.linalg.norm(end - start)
    lifted = b.vertices.copy()
    lifted[(lifted - start) @ way > 650.0] += 0.5 * WIDE * case.beyond
    net = stacked([p, b.with_vertices(lifted)], np.ones((2, 2), dtype=np.bool_))
    made = imprinted(net, 1, 0, 1.0, 1e-3)
    mine, others = (np.unique(made.triangles[made.owner == k]) for k in (1, 0))
    shared = made.vertices[np.intersect1d(mine, others)]
    reached = (shared - start) @ way
    assert reached.min() == pytest.approx(0.0, abs=SNAP * STEP)
    assert reached.max() == pytest.approx(600.0, abs=SNAP * STEP)
