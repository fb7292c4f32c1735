import numpy as np
import pytest
from scipy.spatial import cKDTree

from graben.modeling.lattice import edge_of, hexagonal


@pytest.mark.parametrize("angle", [0.0, 17.0, 90.0])
def test_each_node_has_its_square_of_the_step(angle):
    low, high = np.array([-3.0, 2.0]), np.array([97.0, 82.0])
    nodes = hexagonal(low, high, edge_of(1.0), angle)
    assert len(nodes) == pytest.approx(100 * 80, rel=0.02)
    assert (nodes >= low - 1e-6).all() and (nodes <= high + 1e-6).all()


@pytest.mark.parametrize("angle", [0.0, 17.0])
def test_inner_nodes_have_six_neighbours_one_edge_away(angle):
    nodes = hexagonal(np.zeros(2), np.full(2, 20.0), 1.5, angle)
    inner = nodes[(np.abs(nodes - 10.0) < 7.0).all(axis=1)]
    distances = cKDTree(nodes).query(inner, k=8)[0]
    assert distances[:, 1:7] == pytest.approx(1.5)
    assert (distances[:, 7] > 1.5 * 1.7).all()


def test_the_origin_is_a_node_and_the_rows_are_mirrored_about_it():
    nodes = hexagonal(np.array([-5.0, -4.0]), np.array([5.0, 4.0]), 1.0)
    tree = cKDTree(nodes)
    assert tree.query([0.0, 0.0])[0] < 1e-9
    for signs in ([-1, 1], [1, -1], [-1, -1]):
        assert tree.query(nodes * signs)[0].max() < 1e-9
    moved = hexagonal(np.zeros(2), np.full(2, 9.0), 1.0, 30.0, origin=np.array([2.2, 3.3]))
    assert cKDTree(moved).query([2.2, 3.3])[0] < 1e-9
