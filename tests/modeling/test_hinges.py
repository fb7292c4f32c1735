import numpy as np

from graben.modeling.hinges import Hinges
from graben.surface import edge_table
from tests.modeling.meshes import irregular


def made():
    _, triangles = irregular(9)
    edges, sides = edge_table(triangles)
    return triangles, edges, sides, Hinges.of(triangles, edges, sides)


def test_each_edge_with_two_triangles_is_a_hinge():
    _, edges, sides, hinges = made()
    sharing = np.bincount(sides.ravel(), minlength=len(edges))
    assert (hinges.edges[:, 0] == np.flatnonzero(sharing == 2)).all()
    assert (sharing == 1).any()


def test_its_tips_are_the_third_nodes_of_its_triangles():
    triangles, _, _, hinges = made()
    known = {tuple(sorted(t)) for t in triangles.tolist()}
    for i, j, k, ell in hinges.nodes.tolist():
        assert k != ell
        assert tuple(sorted((i, j, k))) in known and tuple(sorted((i, j, ell))) in known


def test_its_edges_are_those_of_its_nodes():
    _, edges, _, hinges = made()
    ends = hinges.nodes[:, [[0, 1], [0, 2], [1, 2], [0, 3], [1, 3]]]
    assert (edges[hinges.edges] == np.sort(ends, axis=2)).all()
