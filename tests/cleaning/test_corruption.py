"""The generator of corrupted networks: clean ones pass the gate, and corruptions are what they say."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from graben.cleaning.ledger import RepairAction
from graben.cleaning.shaping.shared import shared_vertices
from graben.finding import Profile, Status
from graben.model import Fault, Model
from graben.pipeline import check
from graben.proximity import nearest
from graben.surface import (
    Surface,
    boundary_edges,
    boundary_loops,
    edge_sharing,
    edge_table,
    strong_components,
    triangle_areas,
    triangle_normals,
)
from graben.validators.measuring.crossings import crossings
from graben.validators.measuring.measures import smallest_angles
from graben.validators.z_monotone import critical_points
from tests.cleaning.clean_networks import STEP, clean_network
from tests.cleaning.corrupt_networks import OPEN, STRAY, ends_on, line_of
from tests.cleaning.corrupt_shapes import OVERTURNED, turned_over
from tests.cleaning.corrupt_sheets import CannotCorruptError, Corrupted, branch_points, sheet_of
from tests.cleaning.corruption import (
    KINDS,
    Case,
    cases,
    corrupted,
    differences,
    family,
    judged,
    kind_sets,
    union,
)
from tests.cleaning.network_list import NETWORKS

#: Least angle of a clean triangle, degrees, and the least and greatest number of triangles of a network.
ANGLE, TRIANGLES = 8.0, (600, 3000)
#: How far a corruption may move a surface, m: 0.8 of max_move, which is half a step.
MOVED = 0.8 * 0.5 * STEP


@cache
def examples(kind: str) -> tuple[Corrupted, ...]:
    """One corruption of a kind on each network that has a place for it, and on the next where it has none."""
    made = []
    for seed, name in enumerate(NETWORKS):
        try:
            made.append(Case(name, (kind,), seed).built())
        except CannotCorruptError:
            continue
    return tuple(made)


def changed(state: Corrupted) -> tuple[Surface, Surface]:
    """The first fault that a corruption names, before and after."""
    name = state.done[0].faults[0]
    return next(f.surface for f in state.clean.faults if f.name == name), state.surface(name)


@pytest.mark.parametrize("name", NETWORKS)
def test_clean_networks_pass_the_gate_without_a_warning(name: str) -> None:
    model = clean_network(name)
    found = check(model, Profile.PAPER).findings
    assert [f.message for f in found if f.status in (Status.FAIL, Status.WARN)] == []
    assert 2 <= len(model.faults) <= 8
    assert TRIANGLES[0] <= sum(len(f.surface.triangles) for f in model.faults) <= TRIANGLES[1]
    assert min(smallest_angles(f.surface.vertices, f.surface.triangles).min() for f in model.faults) > ANGLE


def test_there_are_twelve_networks_with_what_faults_do() -> None:
    assert len(NETWORKS) == 12
    plans = [p for n in NETWORKS.values() for p in n.faults]
    assert any(n.crossings for n in NETWORKS.values())
    assert any(p.hung for p in plans)
    assert any(p.shape.listric for p in plans)
    assert {len(n.faults) for n in NETWORKS.values()} >= {2, 3, 4, 5, 6, 7, 8}
    dips = [p.shape.dip for p in plans]
    assert min(dips) < 40
    assert max(dips) >= 75


@pytest.mark.parametrize("kind", KINDS)
def test_a_corruption_changes_the_faults_it_names_and_no_other(kind: str) -> None:
    assert len(examples(kind)) >= 6
    for state in examples(kind):
        assert state.kinds == (kind,)
        for before, after in zip(state.clean.faults, state.model.faults, strict=True):
            same = np.array_equal(before.surface.vertices, after.surface.vertices) and np.array_equal(
                before.surface.triangles, after.surface.triangles
            )
            assert same or before.name in state.done[0].faults
        clean = {f.name: f.surface for f in state.clean.faults}
        assert any(state.surface(name) is not clean[name] for name in state.done[0].faults)
        assert np.isfinite(state.done[0].places).all()
        assert state.clean is clean_network(state.clean.name)


@pytest.mark.parametrize("kind", ["holes", "self-intersection", "fins", "t-vertices", "slivers", "bumps"])
def test_corruptions_inside_a_fault_leave_rim_and_branch_lines(kind: str) -> None:
    for state in examples(kind):
        before, after = changed(state)
        rim = before.vertices[np.unique(boundary_edges(before.triangles))]
        for points in (rim, branch_points(state.clean)[before.name]):
            assert shared_vertices(replace(before, vertices=points), [after]).all()


@pytest.mark.parametrize("kind", ["bumps", "overturned"])
def test_a_surface_is_moved_by_less_than_a_repair_may_move_it(kind: str) -> None:
    for state in examples(kind):
        before, after = changed(state)
        away = nearest(before.vertices, after.vertices, after.triangles).distance.max()
        back = nearest(after.vertices, before.vertices, before.triangles).distance.max()
        assert 0 < max(away, back) <= MOVED


def test_not_finite() -> None:
    for state in examples("not-finite"):
        before, after = changed(state)
        lost = ~(np.abs(after.vertices) < 1e20).all(axis=1)
        assert 1 <= lost.sum() <= 0.10 * len(before.triangles)


def test_unwelded() -> None:
    for state in examples("unwelded"):
        before, after = changed(state)
        assert len(np.unique(after.vertices, axis=0)) == len(before.vertices) < len(after.vertices)


def test_slivers() -> None:
    for state in examples("slivers"):
        before, after = changed(state)
        assert smallest_angles(after.vertices, after.triangles).min() < 0.5
        areas = [triangle_areas(s.vertices, s.triangles).sum() for s in (before, after)]
        assert areas[0] == pytest.approx(areas[1], rel=1e-9)


def test_t_vertices() -> None:
    for state in examples("t-vertices"):
        before, after = changed(state)
        more = len(boundary_edges(after.triangles)) - len(boundary_edges(before.triangles))
        assert more == 3 * len(state.done[0].places)


def test_specks() -> None:
    for state in examples("specks"):
        before, after = changed(state)
        assert np.array_equal(after.vertices[: len(before.vertices)], before.vertices)
        assert strong_components(after.triangles).max() == len(state.done[0].places)
        new = triangle_areas(after.vertices, after.triangles[len(before.triangles) :]).sum()
        assert new < 0.05 * triangle_areas(before.vertices, before.triangles).sum()


def test_fins() -> None:
    for state in examples("fins"):
        before, after = changed(state)
        count = len(after.triangles) - len(before.triangles)
        assert count == len(state.done[0].places)
        edges, sides = edge_table(after.triangles)
        crowded = (edge_sharing(sides, len(edges)) == 3).sum()
        assert 0 <= crowded <= count


def test_flipped() -> None:
    for state in examples("flipped"):
        before, after = changed(state)
        turned = triangle_normals(before.vertices, before.triangles)
        now = triangle_normals(after.vertices, after.triangles)
        assert ((turned * now).sum(axis=1) < 0).sum() == len(state.done[0].places)


def test_holes() -> None:
    for state in examples("holes"):
        before, after = changed(state)
        count = len(state.done[0].places)
        assert (
            3 <= len(before.triangles) - len(after.triangles) <= max(3 * count, 0.1 * len(before.triangles))
        )
        assert len(boundary_loops(after.triangles)) == 1 + count


def test_parted() -> None:
    for state in examples("parted"):
        _, after = changed(state)
        label = strong_components(after.triangles)
        assert label.max() == 1
        first, second = (after.triangles[label == k] for k in (0, 1))
        widest = state.clean.max_extension(state.clean.faults[0])
        assert 0 < nearest(after.vertices[np.unique(first)], after.vertices, second).distance.min() < widest


def test_self_intersection() -> None:
    for state in examples("self-intersection"):
        before, after = changed(state)
        assert len(crossings(after, 1e-8 * state.clean.size).pairs)
        assert not len(crossings(before, 1e-8 * state.clean.size).pairs)
        assert np.array_equal(after.triangles[: len(before.triangles)], before.triangles)


def test_overturned() -> None:
    for state in examples("overturned"):
        before, after = changed(state)
        turned = turned_over(after, sheet_of(Corrupted(state.clean, state.clean), before.name))
        areas = triangle_areas(before.vertices, before.triangles)
        assert OVERTURNED[0] <= areas[turned].sum() / areas.sum() <= OVERTURNED[1]


def test_bumps() -> None:
    for state in examples("bumps"):
        before, after = changed(state)
        found = critical_points(after)
        assert len(found.vertices) + len(found.level) >= len(state.done[0].places)
        assert not len(critical_points(before).vertices)


def sides(splay: Surface, main: Surface, normal: np.ndarray) -> np.ndarray:
    """The signed distance of the vertices of a fault from another."""
    near = nearest(splay.vertices, main.vertices, main.triangles)
    return near.distance * np.sign((splay.vertices - near.place) @ normal)


@pytest.mark.parametrize("kind", ["gaps", "stubs"])
def test_gaps_and_stubs_are_of_the_size_they_are_meant_to_be(kind: str) -> None:
    for state in examples(kind):
        main = state.done[0].faults[1]
        before, after = changed(state)
        other = state.surface(main)
        line = state.done[0].places
        near = np.linalg.norm(other.vertices[other.triangles].mean(axis=1)[:, None] - line, axis=2).min(
            axis=1
        )
        n = triangle_normals(other.vertices, other.triangles)[near < 2 * STEP].sum(axis=0)
        n = n / np.linalg.norm(n)
        inwards = np.sign(np.median(sides(before, other, n)))
        reached = inwards * sides(after, other, n)
        least = 0.25 * OPEN[0] * STEP  # a fault leaves another at an angle, and both dip
        if kind == "gaps":
            assert least < reached.min() < OPEN[1] * STEP
        else:
            assert -OPEN[1] * STEP < reached.min() < -least


def test_non_conforming() -> None:
    for state in examples("non-conforming"):
        a, b = state.done[0].faults
        clean = {f.name: f.surface for f in state.clean.faults}
        before = shared_vertices(clean[a], [clean[b]]).sum()
        assert shared_vertices(state.surface(a), [state.surface(b)]).sum() <= 2 < before
        for one, other in ((a, b), (b, a)):
            # a rim that ends there still lies on the other fault, but for what it strays
            if ends_on(clean[one], clean[other]):
                line = line_of(clean[one], clean[other])
                own, on = state.surface(one).vertices[line], state.surface(other)
                assert nearest(own, on.vertices, on.triangles).distance.max() < 1.5 * STRAY * STEP


def test_tangency() -> None:
    for state in examples("tangency"):
        a, b = (state.surface(name) for name in state.done[0].faults)
        away = nearest(a.vertices, b.vertices, b.triangles).distance
        assert away.min() <= STRAY * STEP
        assert 1 <= (away <= 2 * STRAY * STEP).sum() <= 3
        before, other = (next(f.surface for f in state.clean.faults if f.name == s.name) for s in (a, b))
        n = triangle_normals(b.vertices, b.triangles).sum(axis=0)
        side = np.sign(np.median(sides(before, other, n / np.linalg.norm(n))))
        assert (side * sides(a, b, n / np.linalg.norm(n))).min() >= -1.5 * STRAY * STEP
        for name in state.done[0].faults:
            before = next(f.surface for f in state.clean.faults if f.name == name)
            after = state.surface(name)
            if not shared_vertices(before, [f.surface for f in state.clean.faults]).any():
                move = nearest(before.vertices, after.vertices, after.triangles).distance
                assert move.max() <= MOVED


def test_every_pair_of_kinds_can_be_made() -> None:
    order = list(KINDS)
    for number, kinds in enumerate(kind_sets()):
        for name in np.roll(list(NETWORKS), number):
            try:
                state = Case(str(name), kinds, 0).built()
            except CannotCorruptError:
                continue
            assert state.kinds == tuple(sorted(kinds, key=order.index))
            finite = all(np.isfinite(f.surface.vertices).all() for f in state.model.faults)
            assert finite or "not-finite" in kinds
            break
        else:
            pytest.fail(f"no network has a place for {kinds}")


def test_cases_are_reproducible_and_do_not_depend_on_what_was_built_before() -> None:
    some = cases(30)
    assert cases.__wrapped__(30, 0) == some
    assert cases.__wrapped__(10, 0) == some[:10]
    assert cases(30, 1) != some
    assert len({c.name for c in some}) == 30
    assert {len(c.kinds) for c in some} == {1, 2}
    first = [c.built() for c in some]
    for case, state in zip(some[::-1], first[::-1], strict=True):
        again = case.built()
        for a, b in zip(state.model.faults, again.model.faults, strict=True):
            assert np.array_equal(a.surface.vertices, b.surface.vertices, equal_nan=True)
            assert np.array_equal(a.surface.triangles, b.surface.triangles)


def test_the_clean_network_is_a_repair_of_every_case() -> None:
    adds = dict.fromkeys(("gaps", "tangency"), "contacts")
    adds |= {"holes": "holes", "parted": "holes", "not-finite": "unfit"}
    for case in cases(90):
        state = case.built()
        actions = [
            RepairAction(adds[d.kind], "", d.faults, 1, 0.0, None, "") for d in state.done if d.kind in adds
        ]
        assert differences(state.clean, state.model, state.clean, actions) == []


def with_faults(model: Model, *surfaces: Surface) -> Model:
    return replace(model, faults=tuple(Fault(s) for s in surfaces))


def test_the_judge_passes_a_clean_network_and_names_what_is_wrong_with_others() -> None:
    clean = clean_network("isolated")
    first, second = (f.surface for f in clean.faults)
    assert judged(clean, clean, clean).passed
    assert judged(clean, clean, with_faults(clean, first)).criteria == {"missing"}
    lifted = first.moved(np.array([0.0, 0.0, 150.0]))
    assert "move" in judged(clean, clean, with_faults(clean, lifted, second)).criteria
    held = corrupted(clean, ["holes"], np.random.default_rng(3))
    verdict = judged(clean, held.model, held.model)
    assert "area" in verdict.criteria
    assert {fault for _, fault, _ in verdict.failed if fault in ("F1", "F2")} == {held.done[0].faults[0]}
    stretched = first.with_vertices(first.vertices * [1.0, 1.0, 1.06])
    assert (
        "dip"
        in judged(
            clean, with_faults(clean, stretched, second), with_faults(clean, stretched, second)
        ).criteria
    )


def test_the_judge_takes_the_parts_of_a_fault_together() -> None:
    clean = clean_network("isolated")
    first, second = (f.surface for f in clean.faults)
    half = len(first.triangles) // 2
    parts = [
        replace(first, triangles=first.triangles[:half]),
        replace(first, name="F1 (2)", triangles=first.triangles[half:]),
    ]
    verdict = judged(clean, clean, with_faults(clean, *parts, second))
    assert not verdict.criteria & {"missing", "area", "dip", "move"}
    assert len(union(parts).triangles) == len(first.triangles)
    assert family("F1 (2) (3)") == "F1"
