import numpy as np
import pytest

from graben.errors import ModelingError
from graben.modeling.energy import Block, EdgePattern, assemble, dirichlet
from tests.modeling.meshes import area, equilateral, irregular, turned


def energy(points, triangles, u, theta, length=1.0):
    pattern = EdgePattern.of(triangles, len(points))
    return 0.5 * u @ (assemble(points, pattern, theta, length) @ u)


def gaps(points, hinges):
    """Return the gap of each hinge (q, 4) as coefficients, (q, 4), from where the lines ij and kl cross."""
    i, j, k, ell = (points[nodes] for nodes in hinges.T)
    # (1 - t) i + t j = (1 - s) k + s l
    sides = np.stack([j - i, k - ell], axis=2)
    t, s = np.linalg.solve(sides, (k - i)[:, :, None])[:, :, 0].T
    return np.stack([1 - t, t, s - 1, -s], axis=1)


def written_out(points, pattern, u, theta, length):
    """Return the energy as the paper writes it: by cotangents of edges, and by gaps of hinges."""
    e_d = 0.0
    for k in range(3):
        a, b, c = (points[pattern.triangles[:, (k + n) % 3]] for n in range(3))
        across = u[pattern.triangles[:, (k + 1) % 3]] - u[pattern.triangles[:, (k + 2) % 3]]
        p, q = b - a, c - a
        cotangents = (p * q).sum(axis=1) / np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])
        e_d += 0.25 * cotangents @ across**2
    i, j, k, ell = (points[nodes] for nodes in pattern.hinges.T)
    edge = np.hypot(*(j - i).T)
    h_k, h_l = (
        np.abs((j - i)[:, 0] * (tip - i)[:, 1] - (j - i)[:, 1] * (tip - i)[:, 0]) / edge for tip in (k, ell)
    )
    weights = 3 * edge / (h_k + h_l) * ((h_k + h_l) / (h_k * h_l)) ** 2
    opened = (gaps(points, pattern.hinges) * u[pattern.hinges]).sum(axis=1)
    return (1 - theta) * e_d + theta * length**2 * 0.5 * weights @ opened**2


@pytest.mark.parametrize("theta", [0.0, 0.3, 1.0])
def test_the_energy_is_the_paper_s(theta):
    points, triangles = irregular(12)
    pattern = EdgePattern.of(triangles, len(points))
    u = np.random.default_rng(2).random(len(points))
    assert energy(points, triangles, u, theta, 0.7) == pytest.approx(
        written_out(points, pattern, u, theta, 0.7), rel=1e-9
    )


def test_e_h_is_zero_on_planes():
    points, triangles = irregular(17)
    plane = 3.0 + points @ [0.7, -1.3]
    pattern = EdgePattern.of(triangles, len(points))
    matrix = assemble(points, pattern, 1.0, 1.0)
    assert np.abs(matrix @ plane).max() < 1e-13 * np.abs(matrix.data).max()


def test_e_d_of_a_plane_is_half_its_squared_slope_times_the_area():
    points, triangles = irregular(17)
    plane = 3.0 + points @ [0.7, -1.3]
    expected = 0.5 * (0.7**2 + 1.3**2) * area(points, triangles)
    assert energy(points, triangles, plane, 0.0) == pytest.approx(expected, rel=1e-10)
    pattern = EdgePattern.of(triangles, len(points))
    assert 0.5 * plane @ (dirichlet(points, pattern) @ plane) == pytest.approx(expected, rel=1e-10)


def test_e_h_of_the_three_quadratics_on_equilateral_triangles():
    # Per unit of area, 2 : 0.75 : 0.75 for x y and the squares along the axes halved; each edge with one
    # triangle costs its diamond, hence the rim.
    count = 150
    points, triangles = equilateral(count)
    x, y = points.T
    whole = area(points, triangles)
    values = [
        energy(points, triangles, u, 1.0) / whole for u in (x * y, 0.5 * (x**2 - y**2), x**2 / 2, y**2 / 2)
    ]
    assert values == pytest.approx([2.0, 2.0, 0.75, 0.75], rel=4.0 / count)


def test_the_matrix_is_symmetric_and_semidefinite_with_the_planes_as_kernel():
    points, triangles = irregular(8)
    pattern = EdgePattern.of(triangles, len(points))
    for theta, kernel in ((0.0, 1), (0.5, 1), (1.0, 3)):
        matrix = assemble(points, pattern, theta, 0.3).toarray()
        assert (matrix == matrix.T).all()
        values = np.linalg.eigvalsh(matrix) / np.abs(matrix).max()
        assert values[0] > -1e-12
        assert (values < 1e-11).sum() == kernel


@pytest.mark.parametrize("degrees", [17.0, 45.0, 180.0])
def test_turning_shifting_and_scaling(degrees):
    points, triangles = irregular(14)
    pattern = EdgePattern.of(triangles, len(points))
    moved = 25.0 * turned(points, degrees) + [300.0, -700.0]
    # E_D has no length in it, E_H one over its square, which l takes away.
    assert dirichlet(moved, pattern).data == pytest.approx(
        dirichlet(points, pattern).data, rel=1e-8, abs=1e-8
    )
    one, other = assemble(points, pattern, 0.5, 0.2), assemble(moved, pattern, 0.5, 25.0 * 0.2)
    assert other.data == pytest.approx(one.data, rel=1e-7, abs=1e-9 * np.abs(one.data).max())


def test_mirrored_triangles_have_the_same_energy():
    points, triangles = irregular(14)
    u = np.sin(5 * points[:, 0]) * points[:, 1]
    mirrored = points * [-1.0, 1.0]
    assert energy(mirrored, triangles, u, 0.5) == pytest.approx(energy(points, triangles, u, 0.5), rel=1e-10)


def test_the_order_of_nodes_triangles_and_corners_does_not_matter():
    points, triangles = irregular(14)
    rng = np.random.default_rng(1)
    order = rng.permutation(len(points))
    place = np.argsort(order)
    other = np.array([np.roll(t, rng.integers(3)) for t in place[rng.permutation(triangles)]])
    u = np.sin(5 * points[:, 0]) * points[:, 1]
    assert energy(points[order], other, u[order], 0.5) == pytest.approx(
        energy(points, triangles, u, 0.5), rel=1e-12
    )


def test_the_matrix_is_the_slope_of_the_energy():
    points, triangles = irregular(6)
    pattern = EdgePattern.of(triangles, len(points))
    theta, length = 0.3, 0.7

    def whole(u):
        return written_out(points, pattern, u, theta, length)

    u = np.random.default_rng(2).random(len(points))
    gradient = assemble(points, pattern, theta, length) @ u
    h = 1e-3
    for node in range(0, len(points), 7):
        step = h * np.eye(len(points))[node]
        assert (whole(u + step) - whole(u - step)) / (2 * h) == pytest.approx(
            gradient[node], rel=1e-6, abs=1e-6
        )


def test_the_pattern_is_the_same_at_each_call():
    points, triangles = equilateral(12)
    pattern = EdgePattern.of(triangles, len(points))
    first = assemble(points, pattern, 0.0, 1.0)
    bent = points + 0.1 * np.random.default_rng(3).random(points.shape)
    for theta in (0.0, 0.5, 1.0):
        second = assemble(bent, pattern, theta, 2.0)
        assert (second.indices == first.indices).all() and (second.indptr == first.indptr).all()
    assert first.has_canonical_format
    # Changing a result must not change the pattern.
    first.indices[:] = 0
    assert (assemble(points, pattern, 0.5, 1.0).indices == second.indices).all()


def test_overlapping_sheets_are_as_good_as_separate_ones():
    points, triangles = irregular(9)
    u = points[:, 0] * points[:, 1]
    both = np.concatenate([triangles, triangles + len(points)])
    doubled = energy(np.tile(points, (2, 1)), both, np.tile(u, 2), 0.5)
    assert doubled == pytest.approx(2 * energy(points, triangles, u, 0.5), rel=1e-12)


def test_a_block_is_the_matrix_part():
    points, triangles = irregular(10)
    pattern = EdgePattern.of(triangles, len(points))
    matrix = assemble(points, pattern, 0.5, 0.1)
    rows, columns = np.arange(0, 100, 2), np.arange(1, 100, 3)
    block = Block.of(pattern, rows, columns)
    assert (block.of_matrix(matrix).toarray() == matrix.toarray()[np.ix_(rows, columns)]).all()


@pytest.mark.parametrize("bad", ["turned over", "without area"])
def test_unfit_triangles_are_refused(bad):
    points, triangles = equilateral(4)
    pattern = EdgePattern.of(triangles, len(points))
    inner = 5
    points[inner] += [3.0, 0.0] if bad == "turned over" else points[inner + 1] - points[inner]
    with pytest.raises(ModelingError, match="no area or are turned over"):
        assemble(points, pattern, 0.5, 1.0)


def test_an_edge_with_three_triangles_is_refused():
    with pytest.raises(ModelingError, match="nodes 0 and 1"):
        EdgePattern.of(np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]]), 5)
