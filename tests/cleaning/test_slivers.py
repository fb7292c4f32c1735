"""Triangles without area and slivers: gone, with rims, shared lines and the shape kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.arrays import ints
from graben.cleaning.shaping.fans import trouble
from graben.cleaning.shaping.limits import distances
from graben.cleaning.slivers import MOST_TURN, REPAIR, bad_triangles, without_slivers
from graben.surface import Surface, strong_components, triangle_normals
from graben.validators.degenerate import ANGLE_LIMIT
from tests.cleaning.cracked import area, outline, rim_length
from tests.cleaning.tasks import applied, found, proposed
from tests.zoo.degenerate import FAILING, PASSING
from tests.zoo.shapes import F60, STEP, faults, sheet

HOPELESS = ("no area at all", "no triangles")
REPAIRABLE = [c for c in FAILING if c.objects == ("F",) and c.name not in HOPELESS]


def bent(columns: int = 12, rows: int = 10) -> Surface:
    return sheet(
        columns, rows, lambda i, j: (STEP * i, 25 * j + 12 * np.sin(0.6 * i), -44 * j + 9 * np.cos(0.5 * j))
    )


def split_at(surface: Surface, triangles, weights) -> Surface:
    """Each of some triangles split in three at a point given by barycentric weights."""
    vertices, kept, new = list(surface.vertices), np.ones(len(surface.triangles), dtype=bool), []
    for t, w in zip(triangles, weights, strict=True):
        a, b, c = surface.triangles[t]
        p = len(vertices)
        vertices.append(np.asarray(w) @ surface.vertices[[a, b, c]])
        kept[t] = False
        new += [[a, b, p], [b, c, p], [c, a, p]]
    return replace(
        surface, vertices=np.array(vertices), triangles=ints(np.concatenate([surface.triangles[kept], new]))
    )


def shaken(seed: int, share: float) -> Surface:
    """A bent fault, a share of its triangles split close to an edge, a corner, or on an edge."""
    rng = np.random.default_rng(seed)
    whole = bent()
    chosen = np.sort(rng.choice(len(whole.triangles), int(share * len(whole.triangles)), replace=False))
    kinds = ([0.5, 0.4999, 1e-4], [0.998, 1e-3, 1e-3], [0.3, 0.7, 0.0], [1e-3, 0.001, 0.998])
    weights = [rng.permutation(kinds[k]) for k in rng.integers(len(kinds), size=len(chosen))]
    return split_at(whole, chosen, weights)


def good(made: Surface, old: Surface) -> None:
    """Assert a manifold in one piece with the rim of the old one, near to it, none of it turned over."""
    assert len(bad_triangles(made, ANGLE_LIMIT)) == 0
    assert trouble(made.triangles) == (0, 0)
    assert not strong_components(made.triangles).any()
    assert np.array_equal(outline(made), outline(old))
    assert rim_length(made) == pytest.approx(rim_length(old), rel=1e-12)
    assert area(made) == pytest.approx(area(old), rel=2e-3)
    assert distances(old, [made]).max() < 5e-3 * STEP


@pytest.mark.parametrize("case", REPAIRABLE, ids=lambda case: case.name)
def test_what_fails_passes_and_keeps_area_and_rim(case):
    task, (change,), refusals = proposed(case.model, REPAIR)
    assert not refusals
    (made,), old = change.surfaces["F"], task.references["F"]
    assert not found(applied(task.model, change), "degenerate", REPAIR)
    assert area(made) == pytest.approx(area(old), rel=1e-9)
    assert rim_length(made) == pytest.approx(1000 if len(old.triangles) > 4 else 200, rel=1e-9)
    assert trouble(made.triangles) == (0, 0)
    assert without_slivers(made) is made


@pytest.mark.parametrize("name", HOPELESS)
def test_what_has_no_area_is_refused(name):
    (case,) = (c for c in FAILING if c.name == name)
    _, changes, refusals = proposed(case.model, REPAIR)
    assert changes == []
    assert [r.objects for r in refusals] == [("F",)]


@pytest.mark.parametrize("case", PASSING, ids=lambda case: case.name)
def test_what_passes_is_the_same_surface(case):
    for fault in case.model.faults:
        assert without_slivers(fault.surface) is fault.surface


@pytest.mark.parametrize("share", [0.03, 0.1, 0.3])
@pytest.mark.parametrize("seed", range(4))
def test_many_slivers_go(seed, share):
    old = shaken(seed, share)
    assert len(bad_triangles(old, ANGLE_LIMIT)) > 2
    made = without_slivers(old)
    good(made, old)
    assert without_slivers(made) is made
    whole = {tuple(p) for p in old.vertices}
    assert all(tuple(p) in whole for p in made.vertices)


@pytest.mark.parametrize("seed", range(3))
def test_normals_turn_little_and_what_is_far_stays(seed):
    old = shaken(seed, 0.05)
    made = without_slivers(old)
    up = triangle_normals(bent().vertices, bent().triangles)[:, 2]
    assert (np.sign(triangle_normals(made.vertices, made.triangles)[:, 2]) == np.sign(up[0])).all()
    assert MOST_TURN < 45
    far = ~np.isin(old.triangles, np.unique(old.triangles[bad_triangles(old, ANGLE_LIMIT)])).any(axis=1)
    corners = {tuple(np.sort(c, axis=0).ravel()) for c in made.vertices[made.triangles]}
    assert all(tuple(np.sort(c, axis=0).ravel()) in corners for c in old.vertices[old.triangles[far]])


def test_a_needle_on_the_rim_is_merged_along_it_where_the_rim_is_straight():
    whole = sheet(6, 4, lambda i, j: (STEP * i, 30 * j, -40 * j))
    vertices = np.vstack([whole.vertices, whole.vertices[10] + [0.2, 0, 0]])
    triangles = whole.triangles.tolist()
    k = next(k for k, t in enumerate(triangles) if {10, 15} <= set(t))
    tip = next(iter(set(triangles[k]) - {10, 15}))
    triangles[k] = [35, 15, tip]
    needle = Surface("F", vertices, [*triangles, [10, 35, tip]])
    made = without_slivers(needle)
    assert len(made.vertices) == len(whole.vertices)
    assert rim_length(made) == pytest.approx(rim_length(whole), rel=1e-12)
    assert area(made) == pytest.approx(area(whole), rel=1e-12)
    assert not len(bad_triangles(made, ANGLE_LIMIT))


def test_a_needle_between_two_corners_of_the_rim_is_left():
    rim = [[-35, -35, 0], [0, 0, 0], [0.3, 0, 0], [35, -35, 0], [0, 50, 0]]
    needle = Surface("F", rim, [[4, 0, 1], [4, 1, 2], [4, 2, 3]])
    assert without_slivers(needle) is needle
    _, changes, (refusal,) = proposed(faults(needle), REPAIR)
    assert changes == []
    assert "1 triangle of F" in refusal.reason


def test_a_needle_at_a_corner_of_the_rim_does_not_take_the_corner():
    corner = Surface(
        "F",
        [[0, 0, 0], [0.2, -0.05, 0], [50, 0, 0], [50, 50, 40], [0, 50, 40]],
        [[0, 1, 3], [1, 2, 3], [0, 3, 4]],
    )
    made = without_slivers(corner)
    assert {tuple(p) for p in corner.vertices[[0, 2, 3, 4]]} <= {tuple(p) for p in made.vertices}


def test_what_is_held_stays():
    whole = bent()
    close = split_at(whole, [40], [[0.996, 0.002, 0.002]])
    corner = int(whole.triangles[40][0])
    held = np.zeros(len(close.vertices), dtype=bool)
    held[corner] = True
    made = without_slivers(close, held=held)
    assert (made.vertices == close.vertices[corner]).all(axis=1).any()
    good(made, close)
    held[:] = True
    assert without_slivers(close, held=held) is close
    shared = replace(close, name="G")
    _, changes, refusals = proposed(faults(close, shared), REPAIR)
    assert changes == []
    assert {r.objects for r in refusals} == {("F",), ("G",)}
    assert refusals[0].needed > 0


def test_nothing_moves_further_than_allowed():
    old = shaken(1, 0.2)
    assert without_slivers(old, away=-1.0) is old
    made = without_slivers(old, away=1e-3)
    assert distances(old, [made]).max() < 5e-3


def test_a_ridge_stays():
    roof = sheet(8, 6, lambda i, j: (STEP * i, STEP * j, -60 * np.abs(j - 3)))
    broken = split_at(roof, [20, 21, 60], [[0.5, 0.4995, 5e-4], [5e-4, 0.5, 0.4995], [0.9985, 1e-3, 5e-4]])
    made = without_slivers(broken)
    good(made, broken)
    ridge = {tuple(p) for p in roof.vertices[roof.vertices[:, 2] == 0]}
    assert ridge <= {tuple(p) for p in made.vertices}
    assert area(made) == pytest.approx(area(roof), rel=1e-6)


def test_lines_rotation_shift_and_order():
    old = shaken(2, 0.1)
    made = without_slivers(replace(old, lines=np.arange(1, len(old.triangles) + 1)))
    assert len(made.lines) == len(made.triangles)
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    moved = without_slivers(old.with_vertices(old.vertices @ turn.T + [5e5, 6e6, 0]))
    assert np.array_equal(moved.triangles, made.triangles)
    order = np.random.default_rng(3).permutation(len(old.triangles))
    mixed = without_slivers(replace(old, triangles=old.triangles[order]))
    good(mixed, old)


def test_a_flat_spike_on_the_rim_goes():
    ends = F60.vertices[[5, 0]]
    spike = replace(
        F60,
        vertices=np.vstack([F60.vertices, 2 * ends[1] - ends[0]]),
        triangles=np.concatenate([F60.triangles, [[5, 0, len(F60.vertices)]]]),
    )
    made = without_slivers(spike)
    assert len(bad_triangles(made, ANGLE_LIMIT)) == 0
    assert area(made) == pytest.approx(area(F60))


def test_a_sliver_along_the_rim_goes_where_its_third_corner_is_held():
    # a line that another fault shares ends a hair below the rim
    points = [[0, 0, 0], [9, 0, 0], [4, 0, -0.01], [4, 0, -5], [0, 0, -5], [9, 0, -5]]
    surface = Surface("F", points, [[0, 2, 1], [0, 4, 2], [2, 4, 3], [2, 3, 5], [2, 5, 1]])
    held = np.array([False, False, True, True, False, False])
    made = without_slivers(surface, held=held)
    assert len(made.triangles) == 4
    assert np.array_equal(made.vertices, surface.vertices)
    assert without_slivers(surface, held=held, away=0.001) is surface
    assert without_slivers(made, held=held) is made
