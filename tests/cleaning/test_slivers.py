"""Triangles without area and slivers: gone, with rims, shared lines and the shape kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.arrays import ints
from graben.cleaning.shaping.fans import trouble
from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.remeshing import differing, followed, shared_edges
from graben.cleaning.shaping.shared import shared_vertices
from graben.cleaning.shaping.sliver_edits import MOST_TURN, bad_triangles, without_slivers
from graben.cleaning.shaping.sliver_patches import with_patches_remeshed
from graben.cleaning.slivers import REPAIR
from graben.surface import Surface, edge_table, strong_components, triangle_normals
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


def crossing(short: float = 0.4) -> tuple[Surface, Surface]:
    """Two faults that meet along a line of which both have one edge much shorter than all others."""
    main = sheet(8, 6, lambda i, j: (STEP * i, 6 * np.sin(0.5 * i) * (i != 4) + 25 * j, -44 * j))
    cross = sheet(6, 6, lambda i, j: (4 * STEP + 20 * i, 25 * j + 45 * i, 5 * i - 44 * j), "G")
    return split_edge(main, 4 * STEP, short), split_edge(cross, 4 * STEP, short)


def split_edge(surface: Surface, x: float, short: float) -> Surface:
    """The third edge of the line at an x split at a little distance from its start."""
    line = np.flatnonzero(surface.vertices[:, 0] == x)
    line = line[np.argsort(-surface.vertices[line, 2])]
    a, b = line[2], line[3]
    way = surface.vertices[b] - surface.vertices[a]
    new = surface.vertices[a] + short / np.linalg.norm(way) * way
    triangles, n = [], len(surface.vertices)
    for t in surface.triangles.tolist():
        if {a, b} <= set(t):
            triangles += [[n if v == b else v for v in t], [n if v == a else v for v in t]]
        else:
            triangles.append(t)
    return replace(surface, vertices=np.vstack([surface.vertices, new]), triangles=ints(triangles))


def test_needles_at_a_short_edge_that_two_faults_share_go_where_the_patch_is_meshed_anew():
    main, cross = crossing()
    held, lines = shared_vertices(main, [cross]), shared_edges(main, [cross])
    edited = without_slivers(main, held=held, lines=lines)
    assert len(bad_triangles(edited, ANGLE_LIMIT)) > 0
    task, changes, refusals = proposed(faults(main, cross), REPAIR)
    assert refusals == []
    assert "meshed anew" in changes[0].steps[0].reason
    model = task.model
    for change in changes:
        model = applied(model, change)
    assert not found(model, "degenerate", REPAIR)
    made = {f.name: f.surface for f in model.faults}
    for name, old in task.references.items():
        new = made[name]
        assert trouble(new.triangles) == (0, 0)
        assert np.array_equal(outline(new), outline(old))
        assert max(distances(new, [old]).max(), distances(old, [new]).max()) < 0.04 * STEP
        was, now = differing(old, new)
        assert len(was) < 0.25 * len(old.triangles)
        assert len(now) < 4 * len(was)
    assert len(shared_edges(made["F"], [made["G"]])) == len(lines) == 7


def test_meshing_anew_stops_at_its_limits():
    main, cross = crossing()
    held, lines = shared_vertices(main, [cross]), shared_edges(main, [cross])
    assert with_patches_remeshed(main, ANGLE_LIMIT, held, lines, -1.0) is main
    assert with_patches_remeshed(main, ANGLE_LIMIT, held, lines, STEP, lambda made: False) is main
    made = with_patches_remeshed(main, ANGLE_LIMIT, held, lines, STEP)
    assert not len(bad_triangles(made, ANGLE_LIMIT))
    stay, edges = followed(main, made, held, lines)
    assert with_patches_remeshed(made, ANGLE_LIMIT, stay, edges, STEP) is made


def test_an_edge_between_vertices_of_a_line_is_flipped_where_it_is_none_of_the_line():
    # the line runs through the middle vertex, the long edge passes by it
    points = [[0, 0, 0], [9, 0, 0], [4, 0.01, 0], [4, 5, 0], [4, -5, 0]]
    surface = Surface("F", points, [[0, 1, 2], [1, 3, 2], [3, 0, 2], [1, 0, 4]])
    held = np.array([True, True, True, False, False])
    assert without_slivers(surface, held=held) is surface
    made = without_slivers(surface, held=held, lines=ints([[0, 2], [1, 2]]))
    assert not len(bad_triangles(made, ANGLE_LIMIT))
    assert [0, 2] in edge_table(made.triangles)[0].tolist()
    assert [0, 1] not in edge_table(made.triangles)[0].tolist()


def test_an_ear_of_the_rim_goes_where_it_is_no_higher_than_a_sliver():
    # the flip would make a needle of its short side
    points = [[0, 0, 0], [9, 0, 0], [0.04, 0.01, 0], [1, -5, 0]]
    surface = Surface("F", points, [[0, 1, 2], [1, 0, 3]])
    made = without_slivers(surface)
    assert made.vertices.tolist() == [points[k] for k in (0, 1, 3)]
    assert area(made) == pytest.approx(area(surface), rel=2e-3)
    assert without_slivers(surface, held=np.array([False, False, True, False])) is surface
    assert without_slivers(surface, away=0.005) is surface


def test_a_sliver_between_two_lines_of_other_faults_is_left():
    # the two lines leave one vertex at a fifth of a degree
    fan = np.radians([-60, 0, 0.2, 60])
    points = np.concatenate([[[0, 0, 0]], np.c_[50 * np.cos(fan), 50 * np.sin(fan), 0 * fan]])
    main = Surface("F", points, [[0, 1, 2], [0, 2, 3], [0, 3, 4]])
    others = [
        Surface(name, [points[0], points[k], [20, 0, -50]], [[0, 1, 2]]) for name, k in (("G", 2), ("H", 3))
    ]
    _, changes, refusals = proposed(faults(main, *others), REPAIR)
    assert changes == []
    assert [r.objects for r in refusals] == [("F",)]
    assert "a line shared with another fault" in refusals[0].reason
