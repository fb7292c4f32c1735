import numpy as np
import pytest

from graben.arrays import floats
from graben.formats.irap import grid_surface
from graben.model import Fault, GridGeometry, Horizon
from graben.modeling.filling import filled
from graben.surface import Surface

GAMMA = 60.0


def plane(plan):
    return 100.0 + 0.2 * plan[..., 0] - 0.1 * plan[..., 1]


def horizon(holes, rotation=0.0, value=plane):
    grid = GridGeometry(30, 20, 10.0, 12.0, (5.0, -7.0), rotation)
    values = value(grid.nodes()).copy()
    for i, j in holes:
        values[i, j] = np.nan
    return Horizon("H", grid_surface("H", grid, floats(values)), grid.step, grid), int(np.isnan(values).sum())


def fault_through(target, i, j, low=-1000.0, high=1000.0):
    """A vertical fault along y through the middle of grid node (i, j)."""
    x, y = target.grid.nodes()[i, j]
    corners = [[x, y - 500, low], [x, y + 500, low], [x, y + 500, high], [x, y - 500, high]]
    return Fault(Surface("F", corners, [[0, 1, 2], [0, 2, 3]]))


@pytest.mark.parametrize("rotation", [0.0, 30.0])
def test_a_hole_crossed_by_a_fault_is_filled_and_a_plane_kept(rotation):
    target, missing = horizon([(slice(8, 12), slice(6, 9))], rotation)
    result, count = filled(target, (fault_through(target, 9, 7),), GAMMA)
    assert count == missing == 12
    assert len(result.surface.vertices) == 600
    assert result.surface.vertices[:, 2] == pytest.approx(plane(result.surface.vertices), abs=1e-9)
    assert "12 undefined" in result.notes[-1]
    assert len(target.surface.vertices) == 600 - missing


def test_a_curved_surface_is_bridged_smoothly():
    def dome(plan):
        return -((plan[..., 0] - 150.0) ** 2 + (plan[..., 1] - 100.0) ** 2) / 2000.0

    target, _ = horizon([(slice(12, 15), slice(6, 9))], value=dome)
    result, _ = filled(target, (fault_through(target, 13, 7),), GAMMA)
    assert np.abs(result.surface.vertices[:, 2] - dome(result.surface.vertices)).max() < 0.3


def test_the_other_nodes_keep_their_values_to_the_bit():
    target, _ = horizon([(slice(8, 12), slice(6, 9))], value=lambda plan: np.sin(plan[..., 0]))
    result, _ = filled(target, (fault_through(target, 9, 7),), GAMMA)
    before = {tuple(v) for v in target.surface.vertices}
    assert before < {tuple(v) for v in result.surface.vertices}


@pytest.mark.parametrize(
    ("hole", "at", "gamma", "band"),
    [
        ((slice(8, 12), slice(6, 9)), (20, 7), GAMMA, (-1000, 1000)),
        ((slice(8, 12), slice(6, 9)), (9, 7), GAMMA, (300, 1000)),
        ((slice(8, 12), slice(6, 9)), (9, 7), 15.0, (-1000, 1000)),
        ((slice(0, 3), slice(6, 9)), (1, 7), GAMMA, (-1000, 1000)),
    ],
    ids=["fault elsewhere", "fault far above", "hole too wide", "open to the outside"],
)
def test_other_holes_stay(hole, at, gamma, band):
    target, _ = horizon([hole])
    result, count = filled(target, (fault_through(target, *at, *band),), gamma)
    assert count == 0
    assert result is target


def test_of_two_holes_only_the_crossed_one_is_filled():
    target, missing = horizon([(slice(4, 6), slice(6, 9)), (slice(20, 22), slice(6, 9))])
    result, count = filled(target, (fault_through(target, 4, 7),), GAMMA)
    assert count == missing // 2 == 6
    assert len(result.surface.vertices) == 600 - 6


def test_without_grid_or_hole_nothing_happens():
    whole, _ = horizon([])
    fault = fault_through(whole, 9, 7)
    assert filled(whole, (fault,), GAMMA) == (whole, 0)
    loose = Horizon("H", whole.surface, 10.0)
    assert filled(loose, (fault,), GAMMA) == (loose, 0)
