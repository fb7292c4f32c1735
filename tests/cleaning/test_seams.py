"""Faults that were cut through are sewn together where the vertices of both sides match."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.cleaning.components import REPAIR as COMPONENTS
from graben.cleaning.seams import pieces_by_size, sewn
from graben.cleaning.stitch import REPAIR
from graben.settings import RepairSettings
from graben.surface import Surface, boundary_edges, boundary_loops, strong_components, triangle_areas
from tests.cleaning.tasks import applied, found, proposed
from tests.cleaning.test_components import uneven
from tests.zoo.shapes import STEP, faults

MOVE = 0.4 * STEP
#: The vertices of the sheet, 21 by 15, by column and row.
AT = np.arange(21 * 15).reshape(21, 15)
ROOM = RepairSettings(max_move=MOVE, max_extension=3 * STEP)


def cut(apart: float, ragged: bool = True) -> tuple[Surface, Surface]:
    """An uneven sheet, and the same cut through at column 9 and drawn apart along strike by so much."""
    whole = uneven()
    column, row = np.divmod(np.arange(560) % 280, 14)
    side = column >= 9 + (np.isin(row % 4, (1, 2)) if ragged else 0)
    seam = np.intersect1d(whole.triangles[side], whole.triangles[~side])
    copy = np.arange(len(whole.vertices))
    copy[seam] = len(copy) + np.arange(len(seam))
    triangles = np.where(side[:, None], copy[whole.triangles], whole.triangles)
    move = np.array([0.5 * apart, 0, 0])
    vertices = np.concatenate([whole.vertices, whole.vertices[seam] + move])
    vertices[seam] -= move
    assert strong_components(triangles).max() == 1
    return whole, replace(whole, vertices=vertices, triangles=triangles)


def area(surface: Surface) -> float:
    return float(triangle_areas(surface.vertices, surface.triangles).sum())


def halves(surface: Surface):
    label = pieces_by_size(surface).label
    return label == 0, label == 1


def sew(surface: Surface, held=None, move=MOVE):
    held = np.zeros(len(surface.vertices), dtype=bool) if held is None else held
    return sewn(surface, *halves(surface), held, move, 1e-8)


@pytest.mark.parametrize("ragged", [False, True])
@pytest.mark.parametrize("apart", [0.02, 0.2, 0.5])
def test_what_was_cut_comes_back(apart, ragged):
    whole, parted = cut(apart * STEP, ragged)
    seam = sew(parted)
    made = seam.surface
    assert len(made.vertices) == len(whole.vertices)
    assert area(made) == pytest.approx(area(whole), rel=1e-9)
    assert len(boundary_loops(made.triangles)) == 1
    assert len(boundary_edges(made.triangles)) == len(boundary_edges(whole.triangles))
    apart_now = np.linalg.norm(made.vertices[:, None] - whole.vertices, axis=2)
    assert np.allclose(apart_now.min(axis=0), 0, atol=1e-9 * STEP)
    assert seam.gap == pytest.approx(apart * STEP)


def test_a_half_that_is_turned_over_is_turned_back():
    whole, parted = cut(0.2 * STEP)
    _, second = halves(parted)
    turned = np.where(second[:, None], parted.triangles[:, ::-1], parted.triangles)
    seam = sew(replace(parted, triangles=turned))
    assert seam.flipped
    assert len(boundary_edges(seam.surface.triangles)) == len(boundary_edges(whole.triangles))


def test_limits_are_kept_and_held_vertices_stay():
    _, parted = cut(0.3 * STEP)
    assert sew(parted, move=0.14 * STEP) is None
    rim = np.setdiff1d(np.arange(len(parted.vertices)), AT)
    held = np.zeros(len(parted.vertices), dtype=bool)
    held[rim] = True
    assert sew(parted, held, move=0.2 * STEP) is None
    made = sew(parted, held).surface
    assert {tuple(v) for v in parted.vertices[rim]} <= {tuple(v) for v in made.vertices}
    held[:] = True
    assert sew(parted, held) is None


def test_a_missing_row_is_not_sewn():
    whole = uneven()
    gone = np.isin(whole.triangles, AT[9]).any(axis=1) & np.isin(whole.triangles, AT[10]).any(axis=1)
    parted = replace(whole, triangles=whole.triangles[~gone])
    assert strong_components(parted.triangles).max() == 1
    assert sew(parted, move=10 * STEP) is None


def test_rims_that_match_along_a_part_only_are_not_sewn():
    _, parted = cut(0.2 * STEP, ragged=False)
    rim = boundary_edges(parted.triangles)
    a, b = next(e for e in rim.tolist() if set(e) == {AT[9, 7], AT[9, 8]})
    t = int(np.flatnonzero(np.isin(parted.triangles, [a, b]).sum(axis=1) == 2)[0])
    (c,) = set(parted.triangles[t].tolist()) - {a, b}
    middle = len(parted.vertices)
    vertices = np.concatenate([parted.vertices, parted.vertices[[a, b]].mean(axis=0)[None]])
    kept = np.delete(parted.triangles, t, axis=0)
    triangles = np.concatenate([kept, [[a, middle, c], [middle, b, c]]])
    assert sew(replace(parted, vertices=vertices, triangles=triangles)) is None


@pytest.mark.parametrize("repair", [REPAIR, COMPONENTS], ids=lambda r: r.id)
def test_the_repairs_sew_and_leave_nothing(repair):
    whole, parted = cut(0.3 * STEP)
    task, (change,), refusals = proposed(faults(parted, repair=ROOM), repair)
    assert not refusals
    after = applied(task.model, change)
    assert not found(after, "strongly-connected", repair)
    assert area(change.surfaces["F"][0]) == pytest.approx(area(whole), rel=1e-9)
    (step,) = change.steps
    assert "sewn together" in step.reason
    assert step.size == pytest.approx(0.3 * STEP)
    assert not change.declared
    assert proposed(after, repair)[1] == []


def test_order_turn_and_shift_do_not_matter():
    _, parted = cut(0.3 * STEP)
    made = sew(parted).surface
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    away = np.array([5e5, 6e6, 0])
    turned = sew(replace(parted, vertices=parted.vertices @ turn.T + away)).surface
    assert np.allclose(turned.vertices, made.vertices @ turn.T + away, atol=1e-7)
    order = np.random.default_rng(2).permutation(len(parted.triangles))
    mixed = sew(replace(parted, triangles=parted.triangles[order])).surface
    assert area(mixed) == pytest.approx(area(made), rel=1e-12)
