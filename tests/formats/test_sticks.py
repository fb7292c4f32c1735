from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graben.errors import InputError
from graben.formats.stick_surface import sticks_surface
from graben.formats.sticks import read_sticks
from graben.surface import (
    boundary_edges,
    boundary_loops,
    edge_sharing,
    edge_table,
    strong_components,
    triangle_areas,
    triangle_normals,
)

DATA = Path(__file__).parents[3] / "shared" / "data" / "drogon" / "faults"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="shared data are not here")


def fan(count: int = 12, turn: float = 100.0) -> list[np.ndarray]:
    """Sticks of 2 to 4 points on a fault of radius 1000 that turns by ``turn`` degrees, dipping outwards."""
    rng = np.random.default_rng(5)
    sticks = []
    for k, a in enumerate(np.radians(np.linspace(0, turn, count))):
        t = np.sort(np.concatenate([[0, 1], rng.random(k % 3)]))[:, None]
        out = np.array([np.cos(a), np.sin(a), 0])
        sticks.append(1000 * out + t * (300 + 20 * (k % 4)) * (out * 0.7 - [0, 0, 1]))
    return sticks


def assert_is_a_fault(surface, sticks) -> None:  # type: ignore[no-untyped-def]
    vertices, triangles = surface.vertices, surface.triangles
    edges, sides = edge_table(triangles)
    assert edge_sharing(sides, len(edges)).max() <= 2
    assert strong_components(triangles).max() == 0
    assert len(boundary_loops(triangles)) == 1
    # oriented alike: no directed edge is there twice
    directed = {tuple(e) for k in range(3) for e in np.roll(triangles, k, axis=1)[:, :2].tolist()}
    assert len(directed) == 3 * len(triangles)
    longest = max(np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1))
    assert triangle_areas(vertices, triangles).min() > 1e-4 * longest**2
    assert len(np.unique(triangles)) == len(vertices)
    points = {tuple(p) for p in vertices.tolist()}
    assert all(tuple(p) in points for stick in sticks for p in stick.tolist())


def test_a_curved_fault_is_one_surface_in_one_sheet() -> None:
    sticks = fan()
    surface = sticks_surface("F", sticks)
    assert_is_a_fault(surface, sticks)
    assert (triangle_normals(surface.vertices, surface.triangles)[:, 2] > 0).all()


@pytest.mark.parametrize("turn", [20.0, 100.0, 250.0])
def test_order_and_direction_do_not_matter(turn: float) -> None:
    sticks = fan(turn=turn)
    rng = np.random.default_rng(1)
    mixed = [sticks[k][:: rng.choice([1, -1])] for k in rng.permutation(len(sticks))]
    plain, shuffled = sticks_surface("F", sticks), sticks_surface("F", mixed)
    area = [triangle_areas(s.vertices, s.triangles).sum() for s in (plain, shuffled)]
    assert len(plain.triangles) == len(shuffled.triangles)
    assert np.isclose(*area, rtol=1e-3)
    assert_is_a_fault(shuffled, sticks)


def test_a_planar_fault_stays_planar_far_from_the_origin() -> None:
    x = np.linspace(0, 3000, 7)
    far = np.array([5e5, 6e6, -1500])
    sticks = [np.add(far, [[a, 0, 0], [a + 40, 300, -300]]) for a in x]
    surface = sticks_surface("F", sticks)
    off = surface.vertices[:, 1] - 6e6 + surface.vertices[:, 2] + 1500
    assert np.abs(off).max() < 1e-9 * 6e6
    area = triangle_areas(surface.vertices - surface.vertices[0], surface.triangles).sum()
    assert np.isclose(area, 3000 * 300 * np.sqrt(2))


def test_horizontal_sticks_are_joined_down_the_dip() -> None:
    x = np.linspace(0, 1000, 5)[:, None]
    sticks = [x * [1, 0, 0] + [0, 0.6 * z, -z] for z in (300.0, 0.0, 100.0, 200.0)]
    surface = sticks_surface("F", sticks)
    assert_is_a_fault(surface, sticks)
    area = triangle_areas(surface.vertices, surface.triangles).sum()
    assert np.isclose(area, 1000 * 300 * np.hypot(0.6, 1))


def test_sticks_that_cross_exchange_their_ends() -> None:
    tops, bottoms = [0, 100, 200, 300, 400], [0, 100, 320, 280, 400]
    sticks = [np.array([[a, 0, 0], [b, 200, -200]], dtype=float) for a, b in zip(tops, bottoms, strict=True)]
    surface = sticks_surface("F", sticks)
    assert_is_a_fault(surface, sticks)
    normals = triangle_normals(surface.vertices, surface.triangles)
    assert (normals[:, 2] > 0).all()
    assert np.isclose(triangle_areas(surface.vertices, surface.triangles).sum(), 400 * 200 * np.sqrt(2))


def test_sticks_that_meet_in_a_point_share_its_vertex() -> None:
    tip = [500.0, 300.0, -300.0]
    sticks = [np.array([[a, 0, 0], tip]) for a in (0.0, 250.0, 500.0, 750.0)]
    assert_is_a_fault(sticks_surface("F", sticks), sticks)


def test_a_stick_that_runs_back_and_one_that_repeats_count_once() -> None:
    sticks = fan(6)
    noisy = [np.concatenate([sticks[0], sticks[0][:1]]), *sticks[1:], sticks[2][::-1]]
    plain, doubled = sticks_surface("F", sticks), sticks_surface("F", noisy)
    assert np.array_equal(plain.vertices, doubled.vertices)
    assert np.array_equal(plain.triangles, doubled.triangles)


def test_a_pick_that_is_not_finite_is_kept_loose() -> None:
    sticks = fan(6)
    surface = sticks_surface("F", [*sticks, np.array([[np.nan, 1, 2]])])
    assert np.isnan(surface.vertices[-1, 0])
    assert len(boundary_edges(surface.triangles)) and surface.triangles.max() < len(surface.vertices) - 1


@pytest.mark.parametrize(
    "sticks",
    [
        [],
        [np.eye(3)],
        [np.zeros((2, 3)), np.zeros((3, 3))],
        [np.array([[0, 0, k], [0, 0, k + 1.0]]) for k in (0, 1)],
    ],
)
def test_what_makes_no_surface_is_said(sticks: list[np.ndarray]) -> None:
    with pytest.raises(InputError, match="'F'"):
        sticks_surface("F", sticks)


TEXTS = {
    "999": "1 2 3\n4 5 6\n999.0 999.0 999.0\n7 8 9\n1 1 1\n2 2 2\n999 999 999\n",
    "999, the last left out": "1 2 3\n4 5 6\n999.000 999.000 999.000\n7 8 9\n1 1 1\n2 2 2\n",
    "numbers": "1 2 3 8\n4 5 6 8\n7 8 9 2\n1 1 1 2\n2 2 2 2\n",
    "numbers, mixed": "1 2 3 8\n7 8 9 2\n4 5 6 8\n1 1 1 2\n2 2 2 2\n",
    "numbers in a column": "X,Y,Z,POLY_ID\n1,2,3,0\n4,5,6,0\n7,8,9,1\n1,1,1,1\n2,2,2,1\n",
}


@pytest.mark.parametrize("case", TEXTS)
def test_every_form_gives_the_same_sticks(tmp_path: Path, case: str) -> None:
    (tmp_path / "s").write_text(TEXTS[case])
    sticks = read_sticks(tmp_path / "s")
    assert [s.tolist() for s in sticks] == [[[1, 2, 3], [4, 5, 6]], [[7, 8, 9], [1, 1, 1], [2, 2, 2]]]


def test_points_are_no_sticks(tmp_path: Path) -> None:
    (tmp_path / "s").write_text("1 2 3\n4 5 6\n")
    with pytest.raises(InputError, match="999s"):
        read_sticks(tmp_path / "s")


@needs_data
def test_the_faults_of_drogon() -> None:
    total = 0
    for k in range(1, 7):
        sticks = read_sticks(DATA / f"F{k}.pol")
        total += len(sticks)
        surface = sticks_surface(f"F{k}", sticks)
        assert_is_a_fault(surface, sticks)
        assert (triangle_normals(surface.vertices, surface.triangles)[:, 2] > 0).all()
    assert total == 155
