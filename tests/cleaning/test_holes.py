"""Holes filled: nothing of the fault moves, and the patch continues it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.cleaning.holes import REPAIR, WANTED_ANGLE, filled, hole_width
from graben.cleaning.shaping.limits import distances
from graben.settings import RepairSettings
from graben.surface import Surface, boundary_loops, strong_components, triangle_areas, triangle_normals
from graben.validators.manifold import HOLE
from graben.validators.measuring.openings import openings
from tests.cleaning.tasks import applied, found, proposed, result_of
from tests.zoo import manifold as zoo
from tests.zoo.manifold import hanging, perforated, pipe
from tests.zoo.shapes import STEP, dipping, faults, sheet, without

NONE = np.array([], dtype=np.int64)
FAR = np.array([5e5, 5e6, -3e3])


def corrugated(s, t):
    """A fault that dips at 60 degrees and undulates by a step over 14 of them, in m."""
    c, d = np.cos(np.radians(60)), np.sin(np.radians(60))
    off = STEP * np.sin(2 * np.pi * s / (14 * STEP))
    return s, t * c + off * d, -t * d + off * c


def listric(s, t):
    """A fault that flattens from 70 degrees with a radius of 1000 m."""
    start, bend = np.radians(70), np.radians(70) - t / 1000
    return s, 1000 * (np.sin(start) - np.sin(bend)), 1000 * (np.cos(start) - np.cos(bend))


def off_truth(points, place) -> float:
    """How far points lie off a surface, at most, in m: off its tangent planes at the nearest places."""
    s, t = np.meshgrid(np.linspace(0, 20 * STEP, 801), np.linspace(0, 14 * STEP, 561), indexing="ij")
    s, t = s.ravel(), t.ravel()
    dense = np.stack(place(s, t), axis=1)
    far = 0.0
    for point in points:
        k = np.argmin(((dense - point) ** 2).sum(axis=1))
        a, b = np.subtract(place(s[k] + 1, t[k]), dense[k]), np.subtract(place(s[k], t[k] + 1), dense[k])
        normal = np.cross(a, b)
        far = max(far, abs((point - dense[k]) @ normal) / np.linalg.norm(normal))
    return far


def ragged(surface: Surface, size: int, seed: int) -> Surface:
    """A sheet of 20 by 14 cells without some connected triangles in its middle that leave one hole."""
    draw = np.random.default_rng(seed)
    shared = surface.triangles[:, None, :, None] == surface.triangles[None, :, None, :]
    beside = shared.any(axis=3).sum(axis=2) == 2
    while True:
        chosen = [14 * int(draw.integers(8, 12)) + int(draw.integers(5, 9))]
        while len(chosen) < size:
            options = np.setdiff1d(np.flatnonzero(beside[chosen].any(axis=0)), chosen)
            chosen.append(int(draw.choice(options)))
        cut = without(surface, chosen)
        loops = boundary_loops(cut.triangles)
        one = strong_components(cut.triangles).max() == 0
        if len(loops) == 2 and one and all(loop[0] == loop[-1] for loop in loops):
            return cut


def fill(surface: Surface):
    (hole,) = openings(surface)
    return filled(surface, hole, 1e-8, NONE)


@pytest.mark.parametrize("place", [corrugated, listric], ids=lambda p: p.__name__)
@pytest.mark.parametrize("size", [3, 6, 11, 18, 30])
def test_a_patch_continues_a_curved_fault(place, size):
    whole = sheet(20, 14, lambda i, j: place(STEP * i, STEP * j))
    for seed in range(3):
        cut = ragged(whole, size, seed)
        made = fill(cut)
        assert not made.problem
        assert made.angle >= WANTED_ANGLE
        assert np.array_equal(made.surface.vertices[: len(cut.vertices)], cut.vertices)
        assert np.array_equal(made.surface.triangles[: len(cut.triangles)], cut.triangles)
        assert off_truth(made.surface.vertices[len(cut.vertices) :], place) < 0.03 * STEP
        assert not openings(made.surface)
        areas = [triangle_areas(x.vertices, x.triangles).sum() for x in (whole, made.surface)]
        assert areas[1] == pytest.approx(areas[0], rel=2e-3)


def test_a_patch_of_a_plane_lies_in_it_and_turns_as_the_fault():
    whole = dipping(60, 20, 14)
    made = fill(ragged(whole, 18, 5))
    normals = triangle_normals(made.surface.vertices, made.surface.triangles)
    assert (normals[:, 2] > 0).all()
    off = made.surface.vertices @ normals[0] / np.linalg.norm(normals[0])
    assert np.ptp(off) < 1e-9 * STEP
    assert np.linalg.norm(normals, axis=1).sum() == pytest.approx(14 * 20 * 2 * STEP**2)


def test_a_patch_moves_with_the_fault():
    cut = ragged(sheet(20, 14, lambda i, j: corrugated(STEP * i, STEP * j)), 18, 1)
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    here = fill(cut).surface
    there = fill(cut.with_vertices(cut.vertices @ turn.T + FAR)).surface
    back = (there.vertices - FAR) @ turn
    assert len(here.vertices) == len(there.vertices)
    far = np.linalg.norm(here.vertices[:, None] - back[len(cut.vertices) :], axis=2).min(axis=0)
    assert far.max() < 1e-4 * STEP


def test_the_width_of_a_hole_is_that_of_its_widest_place():
    cut = perforated((2, 2), (3, 2), (4, 2))
    (hole,) = openings(cut)
    assert hole_width(cut, hole.loop) == pytest.approx(STEP, rel=0.01)


@pytest.mark.parametrize("case", zoo.FAILING, ids=lambda case: case.name)
def test_zoo(case):
    model = replace(case.model, repair=RepairSettings(max_extension=0.55 * STEP))
    task, changes, refusals = proposed(model, REPAIR)
    holes = any(part.kind == HOLE for f in task.findings for part in f.parts)
    assert not refusals
    assert len(changes) == holes
    for change in changes:
        after = applied(task.model, change)
        assert not found(after, "manifold", REPAIR)
        before = {(f.check, f.objects) for f in result_of(task.model, REPAIR).findings if f.status == "fail"}
        assert {
            (f.check, f.objects) for f in result_of(after, REPAIR).findings if f.status == "fail"
        } <= before
        for name, (made,) in change.surfaces.items():
            old = task.fault(name).surface
            assert np.array_equal(made.vertices[: len(old.vertices)], old.vertices)
            assert distances(made, [old, change.declared[name]]).max() == 0.0


@pytest.mark.parametrize("case", zoo.PASSING, ids=lambda case: case.name)
def test_what_has_no_hole_is_left(case):
    assert proposed(case.model, REPAIR)[1:] == ([], [])


def test_a_crack_without_width_is_closed_by_new_triangles_along_it():
    cracked = hanging()
    task, (change,), _ = proposed(faults(cracked), REPAIR)
    made = change.surfaces["F"][0]
    assert np.array_equal(made.vertices, task.fault("F").surface.vertices)
    assert not openings(made)
    areas = [triangle_areas(x.vertices, x.triangles) for x in (cracked, made)]
    assert areas[1].sum() == pytest.approx(areas[0].sum())
    assert areas[1].min() > 0.1 * STEP**2
    assert "along its rim" in change.steps[0].reason


def test_a_crack_on_a_branch_line_is_left():
    cracked = hanging()
    other = replace(cracked, name="G", vertices=cracked.vertices * [1, 1, -1])
    on_line = replace(
        other, vertices=np.vstack([other.vertices, cracked.vertices[np.unique(cracked.triangles[40:])]])
    )
    _, changes, refusals = proposed(faults(cracked, on_line), REPAIR)
    assert not [c for c in changes if "F" in c.surfaces]
    assert "F" in {name for r in refusals for name in r.objects}


def test_a_wide_hole_is_left_with_numbers():
    wide = perforated(*((i, j) for i in (2, 3, 4) for j in (1, 2, 3)))
    model = faults(wide, repair=RepairSettings(max_extension=STEP))
    _, changes, (refusal,) = proposed(model, REPAIR)
    assert not changes
    assert refusal.needed == pytest.approx(STEP / 2, rel=0.02)
    assert "over twice max_extension, 100 m" in refusal.reason


def test_some_holes_are_filled_and_others_left():
    mixed = perforated((0, 0), (1, 4), *((i, j) for i in (3, 4, 5) for j in (2, 3, 4)))
    model = faults(mixed, repair=RepairSettings(max_extension=STEP))
    task, (change,), (refusal,) = proposed(model, REPAIR)
    assert len(change.steps) == 1
    assert change.steps[0].size == pytest.approx(STEP, rel=0.02)
    assert len(openings(change.surfaces["F"][0])) == 1
    assert refusal.needed is not None
    again = proposed(applied(task.model, change), REPAIR)
    assert not again[1]


def test_a_hole_is_not_filled_by_a_patch_that_crosses_the_fault():
    cut = perforated((3, 3))
    middle = cut.vertices[openings(cut)[0].loop[:-1]].mean(axis=0)
    count = len(cut.vertices)
    # a spike of the fault itself, hung on its rim, that goes through the hole
    spike = replace(
        cut,
        vertices=np.vstack([cut.vertices, np.add(middle, [5, 40, 30]), np.add(middle, [0, -40, -30])]),
        triangles=np.concatenate([cut.triangles, [[1, 0, count], [1, count, count + 1]]]),
    )
    made = fill(spike)
    assert "cross" in made.problem


def test_a_pipe_has_no_hole_and_a_pipe_with_one_has_one():
    tube = pipe()
    assert not openings(tube)
    (hole,) = openings(without(tube, [9]))
    assert hole.edges == 3


def test_a_vetoed_fault_is_left():
    task, _, _ = proposed(faults(perforated((1, 3))), REPAIR)
    assert not REPAIR.propose(replace(task, vetoed=frozenset([frozenset(["F"])])))
