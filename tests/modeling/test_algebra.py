import numpy as np
import pytest
from scipy.sparse import csc_array

from graben.errors import ModelingError
from graben.modeling.algebra import Cholmod, SuperLU, residual
from graben.modeling.energy import Block, EdgePattern, assemble
from tests.modeling.meshes import equilateral

BACKENDS = [Cholmod(), SuperLU()]
SMALL = 1e-13


def systems():
    """Two matrices of one pattern, anchored on two sides, and the unanchored whole."""
    points, triangles = equilateral(30)
    pattern = EdgePattern.of(triangles, len(points))
    high = points[:, 1].max()
    free = np.flatnonzero((points[:, 1] > 1.5) & (points[:, 1] < high - 1.5))
    block = Block.of(pattern, free, free)
    whole = assemble(points, pattern, 1.0, 1.0)
    bent = points + 0.1 * np.sin(points[:, ::-1])
    return block.of_matrix(whole), block.of_matrix(assemble(bent, pattern, 0.5, 3.0)), whole


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("columns", [(), (1,), (3,)])
def test_solves_one_and_several_right_hand_sides(backend, columns):
    matrix = systems()[0]
    known = np.random.default_rng(0).random((matrix.shape[0], *columns))
    rhs = matrix @ known
    before = rhs.copy()
    x = backend.analyse(matrix).factor(matrix).solve(rhs)
    assert x.shape == known.shape
    assert x == pytest.approx(known, rel=1e-7)
    assert residual(matrix, x, rhs) < SMALL
    assert (rhs == before).all()


@pytest.mark.parametrize("backend", BACKENDS)
def test_one_analysis_serves_all_matrices_of_its_pattern(backend):
    first, second, _ = systems()
    analysis = backend.analyse(first)
    rhs = np.ones(first.shape[0])
    for matrix in (first, second, first):
        assert residual(matrix, analysis.factor(matrix).solve(rhs), rhs) < SMALL


def test_backends_agree():
    matrix = systems()[1]
    rhs = np.random.default_rng(1).random(matrix.shape[0])
    one, other = (b.analyse(matrix).factor(matrix).solve(rhs) for b in BACKENDS)
    assert one == pytest.approx(other, rel=1e-8)


@pytest.mark.parametrize("backend", BACKENDS)
def test_what_is_not_definite_is_refused(backend):
    matrix, _, whole = systems()
    for unfit in (-matrix, whole):
        with pytest.raises(ModelingError, match="not positive definite"):
            backend.analyse(unfit).factor(unfit)
    # A refusal does no harm to what follows.
    analysis = backend.analyse(matrix)
    with pytest.raises(ModelingError):
        analysis.factor(-matrix)
    rhs = np.ones(matrix.shape[0])
    assert residual(matrix, analysis.factor(matrix).solve(rhs), rhs) < SMALL


@pytest.mark.parametrize("backend", BACKENDS)
def test_another_pattern_is_refused(backend):
    matrix = systems()[0]
    with pytest.raises(ValueError, match="pattern"):
        backend.analyse(matrix).factor(csc_array(np.eye(matrix.shape[0])))


def test_a_factor_ends_with_the_next_and_says_so():
    first, second, _ = systems()
    analysis = Cholmod().analyse(first)
    old = analysis.factor(first)
    analysis.factor(second)
    with pytest.raises(RuntimeError, match="overwritten"):
        old.solve(np.ones(first.shape[0]))


@pytest.mark.parametrize("backend", BACKENDS)
def test_no_unknowns(backend):
    empty = csc_array((0, 0))
    assert backend.analyse(empty).factor(empty).solve(np.zeros(0)).shape == (0,)
    assert residual(empty, np.zeros(0), np.zeros(0)) == 0.0


@pytest.mark.parametrize("backend", BACKENDS)
def test_unsorted_indices_are_read_right(backend):
    matrix = systems()[0]
    order = np.concatenate(
        [np.arange(a, b)[::-1] for a, b in zip(matrix.indptr, matrix.indptr[1:], strict=False)]
    )
    mixed = csc_array((matrix.data[order], matrix.indices[order], matrix.indptr), shape=matrix.shape)
    rhs = np.ones(matrix.shape[0])
    assert residual(matrix, backend.analyse(mixed).factor(mixed).solve(rhs), rhs) < SMALL


def test_the_residual_sees_a_wrong_solution():
    matrix = systems()[0]
    rhs = np.ones(matrix.shape[0])
    x = Cholmod().analyse(matrix).factor(matrix).solve(rhs)
    assert residual(matrix, x * 1.001, rhs) > 1e-9
