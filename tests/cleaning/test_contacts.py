"""contacts: gaps closed, stubs cut back, rims on other faults, crossings in common edges."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from graben.cleaning.shaping.limits import distances
from graben.finding import Status
from graben.model import Fault, Model
from graben.repairs import RepairResult, repair
from graben.settings import ContactRule, RepairSettings
from graben.surface import Surface, edge_table, triangle_areas
from graben.validators.measuring.measures import smallest_angles
from tests.models import plane_fault
from tests.strategies import NASTY
from tests.zoo import FAILING
from tests.zoo.cases import Case
from tests.zoo.near_miss import G, splay
from tests.zoo.shapes import dipping, faults, scene
from tests.zoo.simplicial_complex import CONTACT, strayed

SOLVED = {
    "simplicial-complex": {
        "proper crossing",
        "T-contact",
        "a rim that strays to both sides",
        "rim and crossing",
    },
    "near-miss": {
        "30 m short",
        "30 m short at 45 degrees",
        "30 m short at 30 degrees",
        "stub of 40 m",
        "stub at 45 degrees",
        "ends below",
    },
    "junction-values": {"splay stops 3 cm short", "splay stops 3 mm short"},
}
CASES = [c for c in FAILING if c.name in SOLVED.get(c.check, ())]


@cache
def mended(case: Case) -> RepairResult:
    """What a repair makes of a case under the paper, once."""
    return repair(case.model, "paper")


def said(result, *statuses: Status) -> list[tuple[str, tuple[str, ...]]]:
    return [(f.check, f.objects) for f in result.findings if f.status in statuses]


def common_edges(first: Surface, second: Surface) -> float:
    """The length of the edges that two surfaces share, equal to the bit."""
    sets = []
    for surface in (first, second):
        ends = np.sort(surface.vertices[edge_table(surface.triangles)[0]].view("f8,f8,f8")[..., 0], axis=1)
        sets.append({tuple(map(tuple, pair)) for pair in ends.tolist()})
    return sum(float(np.linalg.norm(np.subtract(*pair))) for pair in sets[0] & sets[1])


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
def test_a_network_of_the_zoo_passes_under_the_paper_without_a_near_miss(case) -> None:
    result = mended(case)
    assert said(result.after, Status.FAIL) == []
    assert [s for s in said(result.after, Status.WARN) if s[0] == "near-miss"] == []
    assert result.actions


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
def test_the_result_does_not_depend_on_north_or_on_the_order_of_the_file(case) -> None:
    plain, moved = mended(case), repair(NASTY.model(case.model), "paper")
    assert moved.passed
    for a, b in zip(plain.model.faults, moved.model.faults, strict=True):
        areas = [triangle_areas(f.surface.vertices, f.surface.triangles).sum() for f in (a, b)]
        assert areas[1] == pytest.approx(areas[0], rel=2e-3)


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
def test_repaired_twice_is_repaired_once(case) -> None:
    once = mended(case)
    twice = repair(once.model, "paper")
    assert twice.actions == ()
    assert all(a.surface is b.surface for a, b in zip(once.model.faults, twice.model.faults, strict=True))


def test_a_splay_that_ends_short_is_extended_to_the_other_and_ends_in_its_edges() -> None:
    model = faults(splay(30), G)
    f, g = (fault.surface for fault in repair(model, "paper").model.faults)
    line = np.linalg.norm(splay(0).vertices[8] - splay(0).vertices[0])  # the rim of a splay that ends on G
    assert common_edges(f, g) == pytest.approx(line, rel=2e-3)
    area = triangle_areas(f.vertices, f.triangles).sum()
    # splays are all of one size, and begin the nearer to the other
    whole = triangle_areas(splay(30).vertices, splay(30).triangles).sum()
    assert area == pytest.approx(whole + 30 * line, rel=1e-3)


def test_a_stub_is_cut_back_to_the_other() -> None:
    model = faults(splay(-40), G)
    f = repair(model, "paper").model.faults[0].surface
    area = triangle_areas(f.vertices, f.triangles).sum()
    line = np.linalg.norm(splay(0).vertices[8] - splay(0).vertices[0])
    whole = triangle_areas(splay(-40).vertices, splay(-40).triangles).sum()
    assert area == pytest.approx(whole - 40 * line, rel=1e-3)
    assert distances(f, [splay(-40)]).max() < 1e-6


def test_a_crossing_gets_common_edges_and_good_triangles_without_a_vertex_off_the_surfaces() -> None:
    first = plane_fault((-2000, 30), (2000, -60), 60.0, name="F")
    second = plane_fault((40, -2000), (-70, 2000), 75.0, name="G")
    model = Model("cross", (), (first, second))
    result = repair(model, "paper")
    f, g = (fault.surface for fault in result.model.faults)
    assert result.passed
    for made, given in ((f, first.surface), (g, second.surface)):
        assert distances(made, [given]).max() < 1e-6
        assert smallest_angles(made.vertices, made.triangles).min() > 8.0
        before, after = (triangle_areas(s.vertices, s.triangles).sum() for s in (given, made))
        assert after == pytest.approx(before, rel=1e-9)
    assert common_edges(f, g) > 0.0


def test_a_rim_within_the_contact_distance_is_moved_no_further() -> None:
    model = faults(strayed(lambda row: 0.8 * CONTACT * np.cos(2.3 * row)), G)
    f, g = (fault.surface for fault in repair(model, "paper").model.faults)
    assert common_edges(f, g) == pytest.approx(400.0, rel=0.02)
    rim = f.vertices[distances(f, [G]) < 10 * CONTACT]
    assert len(rim) >= 9


def test_an_accepted_gap_stays_and_a_forced_one_is_closed_even_of_a_part_of_a_side() -> None:
    rule = ContactRule(faults=("F", "G"), rule="accept")
    assert repair(faults(splay(30), G, contacts=(rule,)), "paper").actions == ()
    case = next(c for c in FAILING if c.name == "misses the end of the other")
    left = repair(case.model, "paper")
    assert left.actions == ()
    assert any(note.check == "near-miss" and "force" in note.advice for note in left.left)


def test_warnings_can_be_left_alone() -> None:
    model = faults(splay(30), G, repair=RepairSettings(warnings=False))
    assert repair(model, "paper").actions == ()


def test_what_passes_is_left_to_the_bit() -> None:
    model = scene(dipping(60.0))
    result = repair(model, "paper")
    assert result.actions == ()
    assert result.model is model


def test_other_faults_keep_their_surfaces() -> None:
    third = Fault(dipping(60, name="K").moved(np.array([9e3, 0.0, 0.0])))
    model = faults(splay(30), G)
    result = repair(replace(model, faults=(*model.faults, third)), "paper")
    assert result.model.faults[2].surface is third.surface


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
def test_a_fault_that_is_only_divided_is_told_its_own_move(case) -> None:
    """The ledger gives each fault how far its own vertices went, not the largest move of the change."""
    result = mended(case)
    given = {f.name: f.surface for f in case.model.faults}
    for fault in result.model.faults:
        own = [a for a in result.actions if fault.name in a.objects]
        if len(own) == 1 and own[0].objects == (fault.name,) and "divided anew" in own[0].reason:
            away = float(distances(fault.surface, [given[fault.name]]).max())
            assert own[0].max_move == pytest.approx(away, abs=1e-9)
