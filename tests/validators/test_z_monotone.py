"""Stationary points inside faults: known ones, against a walk by hand, and on real faults."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from graben.finding import Element
from graben.formats.tsurf import read_tsurf
from graben.surface import Surface
from graben.validators.context import CheckContext
from graben.validators.measuring.measures import smallest_angles
from graben.validators.z_monotone import CHECK, KINDS, SLIVER, critical_points
from tests.strategies import motions
from tests.zoo.shapes import F60, MIDDLE, STEP, dipping, faults, joined, moved_vertex, sheet

CFM = Path(__file__).parents[2].parent / "shared" / "data" / "cfm"
EASY = settings(max_examples=60, deadline=None, derandomize=True, database=None)
RISE = STEP * np.sin(np.radians(60))


def found(*surfaces: Surface):
    model = faults(*surfaces)
    return CHECK.run(CheckContext(model, frozenset(s.name for s in model.surfaces)))


def kinds(surface: Surface) -> dict[str, int]:
    """How many points of each kind, plateaus counted once."""
    critical = critical_points(surface)
    counts = {k: len(set(critical.plateau[critical.kind == n].tolist())) for n, k in enumerate(KINDS)}
    return {k: n for k, n in counts.items() if n}


def by_hand(surface: Surface) -> dict[int, int]:
    """How often the sign changes around each inner vertex, walked one by one."""
    star: dict[int, list[tuple[int, int]]] = {}
    for a, b, c in surface.triangles.tolist():
        for v, p, q in ((a, b, c), (b, c, a), (c, a, b)):
            star.setdefault(v, []).append((p, q))
    z, changes = surface.vertices[:, 2], {}
    for v, edges in star.items():
        around: dict[int, list[int]] = {}
        for p, q in edges:
            around.setdefault(p, []).append(q)
            around.setdefault(q, []).append(p)
        if any(len(n) != 2 for n in around.values()):
            continue
        way = [edges[0][0]]
        while len(way) < 2 or way[-1] != way[0]:
            before = way[-2] if len(way) > 1 else None
            way.append(next(n for n in around[way[-1]] if n != before))
        if len(way) - 1 < len(around):
            continue
        signs = [s for s in np.sign(z[way[:-1]] - z[v]).tolist() if s]
        changes[v] = sum(a != b for a, b in zip(signs, signs[1:] + signs[:1], strict=True))
    return changes


def rough(seed: int, count: int = 120, turned: bool = True) -> Surface:
    """A surface over random points with random elevations on a few levels, its triangles turned at random."""
    rng = np.random.default_rng(seed)
    plan = 1000 * rng.random((count, 2))
    triangles = Delaunay(plan).simplices
    made = Surface("F", np.c_[plan, 100.0 * rng.integers(0, 6, count)], triangles)
    keep = smallest_angles(made.vertices, triangles) > SLIVER
    swap = rng.random(len(triangles)) < (0.5 if turned else 0.0)
    return Surface("F", made.vertices, np.where(swap[:, None], triangles[:, ::-1], triangles)[keep])


@pytest.mark.parametrize("seed", range(12))
def test_all_links_at_once_are_the_walk_by_hand(seed):
    surface = rough(seed)
    level = np.flatnonzero(np.ptp(surface.vertices[surface.triangles][..., 2], axis=1) == 0)
    spoken = set(surface.triangles[level].ravel().tolist())
    want = {v for v, changes in by_hand(surface).items() if changes != 2 and v not in spoken}
    critical = critical_points(surface)
    assert len(want) > 10
    assert set(critical.vertices.tolist()) == want
    assert critical.level.tolist() == level.tolist()


def test_a_sheet_too_many_hides_nothing_but_its_own_edge():
    surface = rough(3)
    edge = surface.triangles[0, :2]
    extra = Surface("F", np.vstack([surface.vertices, [500, 500, 5000]]), surface.triangles)
    extra = Surface("F", extra.vertices, np.vstack([extra.triangles, [*edge, len(surface.vertices)]]))
    before, after = (set(critical_points(s).vertices.tolist()) for s in (surface, extra))
    assert after == before - set(edge.tolist())


@pytest.mark.parametrize(
    ("rows", "kind", "excess"), [(1.4, "summit", 0.4), (-1.4, "pit", 0.4), (3.0, "summit", 2.0)]
)
def test_the_size_is_what_must_change_until_the_vertex_is_regular(rows, kind, excess):
    lifted = F60.vertices[MIDDLE] + [0, 0, rows * RISE]
    (defect,) = found(moved_vertex(F60, MIDDLE, lifted))
    (part,) = defect.parts
    assert (part.kind, part.count, part.unit) == (kind, 1, "m")
    assert np.isclose(part.value, excess * RISE)
    assert np.allclose(defect.place, lifted)
    assert (defect.element, defect.elements.tolist()) == (Element.VERTEX, [MIDDLE])
    back = lifted - np.sign(rows) * np.array([0, 0, 1.001 * part.value])
    assert found(moved_vertex(F60, MIDDLE, back)) == []


def test_a_saddle_needs_the_least_of_its_runs():
    turn = np.radians(60 * np.arange(6))
    ring = np.c_[np.cos(turn), np.sin(turn), [3.0, -2, 1, -4, 5, -6]]
    fan = Surface("F", np.vstack([[0, 0, 0], ring]), [[0, k + 1, (k + 1) % 6 + 1] for k in range(6)])
    critical = critical_points(fan)
    assert [KINDS[k] for k in critical.kind] == ["saddle"]
    assert critical.excess.tolist() == [1.0]


def test_a_cone_of_level_rings_has_its_top_alone():
    cone = sheet(12, 4, lambda i, j: (j * np.cos(np.pi * i / 6), j * np.sin(np.pi * i / 6), -2.0 * j))
    points, index = np.unique(np.round(cone.vertices, 9) + 0.0, axis=0, return_inverse=True)
    whole = index.reshape(-1)[cone.triangles]
    whole = whole[[len(set(t)) == 3 for t in whole.tolist()]]
    assert kinds(Surface("F", points, whole)) == {"summit": 1}
    ring = whole[(np.linalg.norm(points[whole][:, :, :2], axis=2) > 0.5).all(axis=1)]
    assert kinds(Surface("F", points, ring)) == {}


def test_a_crest_is_one_summit_and_a_closed_valley_one_pit():
    roof = sheet(6, 4, lambda i, j: (STEP * i, 25 * (j - 2), -RISE * np.abs(j - 2)))
    assert kinds(roof) == {"summit": 1}
    assert kinds(roof.with_vertices(roof.vertices * [1, 1, -1])) == {"pit": 1}
    two = joined(roof, roof.moved(np.array([0, 500.0, 0])))
    (defect,) = found(two)
    assert "2 summits" in defect.message
    assert len(defect.places) == 2 * 5


def test_levels_are_told_with_their_area():
    terrace = sheet(6, 3, lambda i, j: (STEP * i, 25 * j, -RISE * np.array([0, 1, 1, 2])[j.astype(int)]))
    (defect,) = found(terrace)
    (part,) = defect.parts
    assert (part.kind, part.count, part.unit) == ("level triangle", 12, "m²")
    assert np.isclose(part.value, 6 * STEP * 25)
    assert (defect.value, defect.unit) == (part.value, part.unit)
    assert defect.element is Element.TRIANGLE
    assert len(defect.elements) == 12


@pytest.mark.parametrize(("angle", "level"), [(0.005, True), (0.02, False)])
def test_how_level_is_level(angle, level):
    assert bool(found(dipping(angle))) == level


@pytest.mark.parametrize("dip", [75, 60, 45, 30])
@pytest.mark.parametrize("decimals", [2, 1])
def test_rounding_makes_no_stationary_point_of_a_steep_fault(dip, decimals):
    rng = np.random.default_rng(dip)
    u, v = 2000 * rng.random((2, 6000))
    c, s = np.cos(np.radians(dip)), np.sin(np.radians(dip))
    plane = np.c_[u, c * v, -s * v]
    triangles = Delaunay(np.c_[u, v]).simplices
    rounded = Surface("F", np.round(plane, decimals), triangles)
    assert (smallest_angles(rounded.vertices, triangles) < SLIVER).any()
    assert found(rounded) == []


@EASY
@given(st.integers(0, 20), motions())
def test_stationary_points_move_with_the_fault(seed, motion):
    surface = rough(seed, 60)
    (before,), (after,) = found(surface), found(motion.surface(surface))
    assert sorted((p.kind, p.count) for p in before.parts) == sorted((p.kind, p.count) for p in after.parts)
    places = motion.points(before.places)
    assert np.allclose(places[np.lexsort(places.T)], after.places[np.lexsort(after.places.T)], atol=1e-6)
    assert np.isclose(before.value, after.value)


def test_real_faults_with_treads():
    if not CFM.is_dir():
        pytest.skip(f"no {CFM}")
    surfaces = [read_tsurf(file)[0].surface for file in sorted(CFM.glob("*.ts"))]
    defects = {d.objects[0][:14]: [(p.kind, p.count) for p in d.parts] for d in found(*surfaces)}
    # a bench that dips 0.1 to 3 degrees between ramps of 30 and 45, and a flat-lying fault
    assert list(defects) == ["CRFA-SCMZ-SCYM", "SAFS-SGPR-SJMT"]
    for surface in surfaces:
        slivers = surface.triangles[smallest_angles(surface.vertices, surface.triangles) < SLIVER]
        want = {v for v, n in by_hand(surface).items() if n != 2} - set(slivers.ravel().tolist())
        assert set(critical_points(surface).vertices.tolist()) == want
