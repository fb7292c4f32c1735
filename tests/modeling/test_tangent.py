"""Newton's step along the guides."""

from __future__ import annotations

import numpy as np
import pytest

from graben.modeling.tangent import Slopes, tangent_step
from tests.modeling.meshes import irregular

ROUNDING = 1e-12
SLOPE = np.array([0.25, -0.1])


def plane(points: np.ndarray) -> np.ndarray:
    return np.asarray(points @ SLOPE - 7.0)


def test_the_slope_of_a_plane_is_its_own_at_every_node() -> None:
    points, triangles = irregular(120)
    nodes = np.arange(0, len(points), 3)
    slopes = Slopes.of(triangles, nodes).gradients(points, plane(points))
    assert slopes == pytest.approx(np.tile(SLOPE, (len(nodes), 1)), abs=ROUNDING)
    # Turned over as a whole, as the local frame may have it, nothing changes.
    turned = Slopes.of(triangles[:, ::-1], nodes).gradients(points, plane(points))
    assert turned == pytest.approx(slopes, abs=ROUNDING)


@pytest.mark.parametrize("slope", [-0.9, -0.2, 0.0, 0.3, 0.45])
def test_where_the_horizon_is_plane_along_the_guide_one_step_is_enough(slope: float) -> None:
    z = np.array([-50.0, 0.0, 80.0])
    image = -1500.0 + slope * z
    there = tangent_step(z, image, np.full(3, slope))
    assert -1500.0 + slope * there == pytest.approx(there, rel=ROUNDING)


def test_a_horizon_along_its_guide_moves_at_most_twice_as_far_as_it_lies_off() -> None:
    z, image = np.zeros(3), np.full(3, 10.0)
    assert tangent_step(z, image, np.array([1.0, 40.0, -40.0])) == pytest.approx([20.0, 20.0, 5.0])
