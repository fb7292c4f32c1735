"""Guides: lines of growing elevation on a fault."""

from __future__ import annotations

import numpy as np
import pytest

from graben.modeling.guides import Guides, branch, sections
from graben.surface import Surface
from tests.models import grid_triangles, plane_fault


def listric(overturned: bool = False) -> Surface:
    """A fault that flattens downwards, or one that overhangs in its upper part."""
    s, t = np.meshgrid(np.linspace(-1000, 1000, 21), np.linspace(0, 1, 41), indexing="ij")
    angle = np.radians((20 + 60 * t) if not overturned else (60 + 60 * t))
    step = 800.0 / 40
    x = np.cumsum(np.cos(angle) * step, axis=1)
    z = np.cumsum(np.sin(angle) * step, axis=1)
    return Surface("L", np.stack([-x, s, z - z.mean()], axis=-1).reshape(-1, 3), grid_triangles(21, 41))


def test_section_of_a_plane_is_its_dip_line() -> None:
    fault = plane_fault((0, -1000), (0, 1000), dip=50.0).surface
    points = np.array([[0.0, 0.0, 0.0], [0.0, 123.0, 0.0], [-100 / np.tan(np.radians(50)), -77.7, 100.0]])
    guides = Guides.of(sections(fault, points, np.tile([-1.0, 0.0], (3, 1))))
    z = np.array([250.0, -321.0, 0.0])
    assert guides.places(z)[:, 0] == pytest.approx(-z / np.tan(np.radians(50)), abs=1e-9)
    assert guides.places(z)[:, 1] == pytest.approx(points[:, 1], abs=1e-9)
    assert guides.low == pytest.approx([-400] * 3)
    assert guides.high == pytest.approx([400] * 3)


def test_section_through_a_vertex_goes_both_ways() -> None:
    fault = plane_fault((0, -1000), (0, 1000), parts=(21, 9)).surface
    middle = fault.vertices[
        np.flatnonzero((np.abs(fault.vertices[:, 2]) < 1) & (np.abs(fault.vertices[:, 1]) < 1))
    ]
    for angle in np.radians(np.arange(5, 180, 10)):
        guides = Guides.of(sections(fault, middle, np.array([[-np.sin(angle), np.cos(angle)]])))
        assert guides.low[0] < -1
        assert guides.high[0] > 1


@pytest.mark.parametrize("offset", [1e-2, 1e-4, 1e-6, 1e-9])
def test_section_close_to_a_vertex_goes_both_ways(offset: float) -> None:
    fault = plane_fault((0, -1000), (0, 1000), dip=30.0, parts=(21, 9)).surface
    for angle in np.radians(np.arange(0, 360, 30)):
        z = offset * np.sin(angle)
        point = np.array([[-z / np.tan(np.radians(30.0)), offset * np.cos(angle), z]])
        guides = Guides.of(sections(fault, point, np.array([[-1.0, 0.0]])))
        assert (guides.low[0], guides.high[0]) == pytest.approx((-400.0, 400.0))


@pytest.mark.parametrize("overturned", [False, True])
def test_section_of_a_curved_fault_stays_on_it(overturned: bool) -> None:
    import igl

    fault = listric(overturned)
    triangles = fault.triangles[::37]
    points = fault.vertices[triangles].mean(axis=1)
    guides = Guides.of(sections(fault, points, np.tile([-0.96, 0.28], (len(points), 1))))
    for share in (0.1, 0.5, 0.9):
        z = guides.low + share * (guides.high - guides.low)
        at = np.column_stack([guides.places(z), z])
        away = igl.point_mesh_squared_distance(at, fault.vertices.copy(), fault.triangles.copy())[0]
        assert np.sqrt(away).max() < 1e-7
    assert guides.places(points[:, 2]) == pytest.approx(points[:, :2], abs=1e-9)


def test_vertical_fault_does_not_move_in_plan() -> None:
    fault = plane_fault((0, -1000), (0, 1000), dip=90.0).surface
    points = np.array([[0.0, 10.0, 20.0]])
    guides = Guides.of(sections(fault, points, np.array([[1.0, 0.0]])))
    assert guides.places(np.array([333.0])) == pytest.approx(np.array([[0.0, 10.0]]), abs=1e-9)
    assert guides.high[0] == pytest.approx(400.0)


def test_branch_stops_where_the_elevation_turns() -> None:
    line = np.array([[0, 0, 0], [1, 0, 1], [2, 0, 3], [3, 0, 2], [4, 0, 5]], dtype=float)
    found = branch(line, np.array([1.5, 0.0, 2.0]), 5.0)
    assert found[:, 2].tolist() == [0.0, 1.0, 2.0, 3.0]


def test_branch_of_a_closed_rim_passes_its_seam() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0.1], [1, 0, 2], [0, 0, 2.1], [0, 0, 0]], dtype=float)
    found = branch(square, np.array([0.0, 0.0, 1.0]), 2.0)
    assert found[0].tolist() == [0, 0, 0]
    assert found[-1, 2] == pytest.approx(2.1)


def test_clipping_says_by_how_much() -> None:
    guides = Guides.of([np.array([[0.0, 0, 0], [1, 0, 1]]), np.array([[0.0, 0, 0], [1, 0, 1], [3, 0, 2]])])
    assert guides.excess(np.array([1.5, -0.25])).tolist() == [0.5, -0.25]
    assert guides.places(np.array([9.0, 1.5])).tolist() == [[1.0, 0.0], [2.0, 0.0]]


def test_continued_guides_go_straight_on() -> None:
    guides = Guides.of([np.array([[0.0, 0, 0], [1, 0, 1], [1, 2, 2]]), np.array([[5.0, 5, 5]])])
    longer = guides.continued(3.0)
    assert longer.lines[0].tolist() == [[-3, 0, -3], [0, 0, 0], [1, 0, 1], [1, 2, 2], [1, 8, 5]]
    assert longer.places(np.array([1.5, 5.0])) == pytest.approx(guides.places(np.array([1.5, 5.0])))
    assert (longer.low[1], longer.high[1]) == (5.0, 5.0), "a point has no way to go on"
