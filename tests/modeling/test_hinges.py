import numpy as np

from graben.modeling.hinges import Hinges
from graben.surface import edge_table
from tests.modeling.meshes import irregular


def made():
    _, triangles = irregular(9)
    edges, sides = edge_table(triangles)
    return triangles, edges, Hinges.of(triangles, edges, sides)


def test_angles_and_faces_are_those_of_the_nodes():
    triangles, edges, hinges = made()
    i, j, k, ell = hinges.nodes
    corner = triangles.ravel()
    assert (edges[hinges.edges] == hinges.nodes[:2].T).all()
    assert (corner[hinges.angles] == [i, j, i, j]).all()
    assert (hinges.angles // 3 == hinges.faces[[0, 0, 1, 1]]).all()
    assert (corner[hinges.opposite[:, hinges.edges]] == [k, ell]).all()


def test_an_edge_with_one_triangle_has_one_opposite_angle():
    triangles, edges, hinges = made()
    single = np.setdiff1d(np.arange(len(edges)), hinges.edges)
    assert len(single)
    assert (hinges.opposite[0] < triangles.size).all()
    assert (hinges.opposite[1, single] == triangles.size).all()


def test_rims_are_all_the_other_sides_of_all_hinges():
    _, edges, hinges = made()
    count = len(hinges.edges)
    place, edge = hinges.rims, np.broadcast_to(np.arange(len(edges)), hinges.rims.shape)
    there = place < 4 * count
    role, hinge = place[there] // count, place[there] % count
    # ik, jk, il, jl: each role of each hinge once.
    assert (np.sort(place[there]) == np.arange(4 * count)).all()
    ends = np.array([[0, 2], [1, 2], [0, 3], [1, 3]])[role]
    nodes = np.take_along_axis(hinges.nodes.T[hinge], ends, axis=1)
    assert (np.sort(nodes, axis=1) == edges[edge[there]]).all()
