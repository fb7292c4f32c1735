"""Which triangles of a surface cross, against exact arithmetic, and what is only a touch."""

from __future__ import annotations

from pathlib import Path

import igl.copyleft.cgal
import numpy as np
import pytest

from graben.finding import Status
from graben.formats.tsurf import read_tsurf
from graben.model import Fault, Model
from graben.pipeline import check
from graben.surface import Surface
from graben.validators.measuring.crossings import crossings
from tests.strategies import Motion
from tests.zoo.cases import Case
from tests.zoo.self_intersection import DOWN, FAILING, PASSING, across, folded, hanging, rolled
from tests.zoo.shapes import F60, STEP, faults, joined, sheet

BIG_BEAR = (
    Path(__file__).parents[2].parent / "shared" / "data" / "cfm" / "ETRA-BBFS-1992-Big_Bear_rupture-CFM6.ts"
)
TOUCH = 1e-6


def pairs(surface: Surface, touch: float = TOUCH) -> set[tuple[int, int]]:
    return set(map(tuple, crossings(surface, touch).pairs.tolist()))


def exact(surface: Surface) -> set[tuple[int, int]]:
    """The pairs that meet in more than common corners and sides, by exact arithmetic."""
    found = igl.copyleft.cgal.remesh_self_intersections(
        np.ascontiguousarray(surface.vertices),
        np.ascontiguousarray(surface.triangles),
        True,
        False,
        False,
        False,
        10**6,
    )[2]
    return set(map(tuple, np.sort(found, axis=1).tolist()))


def soup(count: int, vertices: int, seed: int) -> Surface:
    """Random triangles, of which many share corners and sides where the vertices are few."""
    rng = np.random.default_rng(seed)
    triangles = rng.integers(0, vertices, size=(3 * count, 3))
    triangles = triangles[np.all(np.diff(np.sort(triangles, axis=1)) > 0, axis=1)]
    once = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)[1]
    return Surface("F", rng.normal(size=(vertices, 3)) * STEP, triangles[np.sort(once)][:count])


def crumpled(seed: int) -> Surface:
    rng = np.random.default_rng(seed)
    flat = sheet(20, 20, lambda i, j: (STEP * i, STEP * j, 0 * i))
    return flat.with_vertices(flat.vertices + rng.normal(size=flat.vertices.shape) * STEP * [0.5, 0.5, 2])


@pytest.mark.parametrize("vertices", [12, 30, 100, 300])
@pytest.mark.parametrize("seed", range(3))
def test_random_triangles_cross_where_exact_arithmetic_says_so(vertices: int, seed: int) -> None:
    surface = soup(100, vertices, seed)
    assert len(exact(surface)) > 50
    assert pairs(surface, 1e-9) == exact(surface)


@pytest.mark.parametrize("seed", range(3))
def test_a_crumpled_sheet_crosses_where_exact_arithmetic_says_so(seed: int) -> None:
    assert len(exact(crumpled(seed))) > 100
    assert pairs(crumpled(seed), 1e-9) == exact(crumpled(seed))


@pytest.mark.parametrize("surface", [rolled(), across(-30, 0.3), across(-50, 0.5)])
def test_rolled_and_crossing_sheets_do_so_too(surface: Surface) -> None:
    # as they are they also touch in corners; with noise they do not
    assert set() != pairs(surface) <= exact(surface)
    noise = np.random.default_rng(0).normal(size=surface.vertices.shape)
    rough = surface.with_vertices(surface.vertices + noise)
    assert pairs(rough, 1e-9) == exact(rough) != set()


def test_a_bent_sheet_of_many_triangles_does_not() -> None:
    bent = sheet(100, 100, lambda i, j: (10 * i, 300 * np.sin(j / 20), -10 * j))
    assert pairs(bent) == exact(bent) == set()


def test_a_line_of_crossing_has_its_length_and_its_places_lie_on_it() -> None:
    (finding,) = check(faults(across(-30, 0.3))).of("self-intersection")
    assert finding.worst is not None
    # the second sheet is four steps wide, and crosses F60 halfway down
    assert np.isclose(finding.worst.value, 4 * STEP)
    (part,) = finding.parts
    assert np.isclose(part.value, 4 * STEP)
    assert np.allclose(finding.places[:, 1:], 2 * DOWN[1:])
    (path,) = finding.paths
    assert np.isclose(np.linalg.norm(np.diff(path, axis=0), axis=1).sum(), 4 * STEP)
    assert np.allclose(np.sort(path[[0, -1], 0]), [0.3 * STEP, 4.3 * STEP])


def test_an_overlap_has_its_area() -> None:
    (finding,) = check(faults(folded(0.0))).of("self-intersection")
    # the lower limb shifts along strike by 0.1 steps a row: six by four steps less what hangs out
    assert finding.worst is not None
    assert np.isclose(finding.worst.value, (6 - 0.2) * 4 * STEP**2)


@pytest.mark.parametrize("height", [0.0, 1e-10, -1e-10, 0.5 * TOUCH, -0.5 * TOUCH])
def test_a_corner_on_a_triangle_to_the_rounding_is_a_touch(height: float) -> None:
    corner = F60.vertices[F60.triangles[7]].mean(axis=0)
    normal = np.array([0.0, np.sin(np.radians(60)), np.cos(np.radians(60))])
    tip = corner + height * normal + np.array([[0.0, 0, 0], STEP * normal, STEP * normal + [20, 0, 0]])
    assert pairs(joined(F60, Surface("F", tip, [[0, 1, 2]]))) == set()


@pytest.mark.parametrize(("through", "crosses"), [(-1e-3, False), (0.0, False), (1e-9, False), (1e-3, True)])
def test_a_rim_on_a_sheet_crosses_when_it_reaches_further_than_a_touch(through: float, crosses: bool) -> None:
    assert bool(pairs(hanging(through))) == crosses


def test_a_crack_and_a_triangle_twice_belong_to_duplicate() -> None:
    loose = Surface("F", F60.vertices[F60.triangles].reshape(-1, 3), np.arange(3 * len(F60.triangles)))
    twice = Surface("F", F60.vertices, np.concatenate([F60.triangles, F60.triangles[[5, 9]][:, [2, 1, 0]]]))
    assert pairs(loose) == pairs(twice) == set()


def test_a_sheet_a_touch_away_lies_upon_the_other_and_one_further_away_does_not() -> None:
    normal = np.array([0.0, np.sin(np.radians(60)), np.cos(np.radians(60))])
    lower = F60.moved(np.array([20.0, 0, 0]))
    assert len(pairs(joined(F60, lower.moved(0.5 * TOUCH * normal)))) > len(F60.triangles)
    assert pairs(joined(F60, lower.moved(3 * TOUCH * normal))) == set()


@pytest.mark.parametrize("case", [*FAILING, *PASSING], ids=lambda case: case.name)
def test_pairs_do_not_depend_on_north_on_the_origin_or_on_order(case: Case) -> None:
    (surface,) = case.model.surfaces
    touch = 1e-8 * case.model.size
    before = crossings(surface, touch)
    for k, angle in enumerate(np.linspace(0, 2 * np.pi, 24, endpoint=False) + 0.1):
        moved = Motion(angle, (2.1e4 * k, -5.3e6 + k, 0.3 * k), k).surface(surface)
        moved = moved.moved(-Model("m", (), (Fault(moved),)).local_origin())
        after = crossings(moved, touch)
        assert len(after.pairs) == len(before.pairs)
        assert np.isclose(after.areas.sum(), before.areas.sum(), rtol=1e-6)
        assert np.isclose(after.depths.sum(), before.depths.sum(), rtol=1e-6)


def test_a_tolerance_in_checks_makes_a_crossing_a_touch() -> None:
    model = faults(hanging(0.5))
    assert check(model).of("self-intersection")[0].status is Status.FAIL
    loose = faults(hanging(0.5), checks={"self-intersection": 1.0})
    assert check(loose).of("self-intersection")[0].status is Status.PASS


def test_no_more_than_a_bound_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graben.validators.measuring.crossings.MOST_PAIRS", 100)
    monkeypatch.setattr("graben.validators.measuring.crossings.CHUNK", 10)
    (finding,) = check(faults(crumpled(0))).of("self-intersection")
    assert "at least" in finding.message


@pytest.mark.skipif(not BIG_BEAR.is_file(), reason="shared data are not here")
def test_a_real_fault_that_passes_through_itself_by_centimetres_is_found() -> None:
    surface = read_tsurf(BIG_BEAR)[0].surface
    local = surface.moved(-Model("m", (), (Fault(surface),)).local_origin())
    assert pairs(local, 1e-4) <= exact(local)
    # two pairs meet so near to a corner that they go no deeper than a few millimetres
    assert len(exact(local)) - len(pairs(local, 5e-3)) == 3
    assert 0.01 < crossings(local, 1e-4).depths.max() < 0.1
