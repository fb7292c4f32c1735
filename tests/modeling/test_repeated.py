import numpy as np
import pytest

from graben.errors import ModelingError
from graben.modeling.algebra import Cholmod, SuperLU
from graben.modeling.energy import Block, EdgePattern, assemble
from graben.modeling.repeated import CHANGE, Repeated
from tests.modeling.meshes import equilateral

ACCURACY = 1e-6


class Counting:
    """A backend that counts its factorizations and remembers which were probed."""

    def __init__(self, backend):
        self.backend, self.probed = backend, []

    def analyse(self, matrix):
        self.analysis = self.backend.analyse(matrix)
        return self

    def factor(self, matrix, *, probe=True):
        self.probed.append(probe)
        return self.analysis.factor(matrix, probe=probe)


def systems(*bends):
    """Matrices of one pattern whose meshes are bent by so much, with a load."""
    points, triangles = equilateral(20)
    pattern = EdgePattern.of(triangles, len(points))
    high = points[:, 1].max()
    free = np.flatnonzero((points[:, 1] > 1.5) & (points[:, 1] < high - 1.5))
    block = Block.of(pattern, free, free)
    wave = np.sin(points[:, ::-1])
    matrices = [block.of_matrix(assemble(points + bend * wave, pattern, 0.5, 3.0)) for bend in bends]
    return matrices, matrices[0] @ np.random.default_rng(0).standard_normal(len(free))


@pytest.mark.parametrize("backend", [Cholmod(), SuperLU()])
def test_solutions_are_those_of_a_new_factor(backend):
    matrices, load = systems(0.0, 0.2, 0.201, 0.2011, 0.2)
    counting = Counting(backend)
    repeated = Repeated(counting, ACCURACY)
    for matrix in matrices:
        exact = backend.analyse(matrix).factor(matrix).solve(load)
        assert np.abs(repeated.solve(matrix, load) - exact).max() < CHANGE * ACCURACY
    assert counting.probed == [True, False]


def test_another_load_is_solved_as_well():
    matrices, load = systems(0.1, 0.101)
    counting = Counting(Cholmod())
    repeated = Repeated(counting, ACCURACY)
    repeated.solve(matrices[0], load)
    other = -3.0 * load[::-1]
    exact = Cholmod().analyse(matrices[1]).factor(matrices[1]).solve(other)
    assert np.abs(repeated.solve(matrices[1], other) - exact).max() < CHANGE * ACCURACY


def test_without_accuracy_each_matrix_is_factored():
    matrices, load = systems(0.1, 0.1, 0.1)
    counting = Counting(Cholmod())
    repeated = Repeated(counting, 0.0)
    for matrix in matrices:
        exact = Cholmod().analyse(matrix).factor(matrix).solve(load)
        assert (repeated.solve(matrix, load) == exact).all()
    assert counting.probed == [True, False, False]


def test_an_accuracy_beyond_rounding_is_reached_by_factors():
    matrices, load = systems(0.1, 0.105)
    counting = Counting(Cholmod())
    repeated = Repeated(counting, 1e-300)
    for matrix in matrices:
        exact = Cholmod().analyse(matrix).factor(matrix).solve(load)
        assert (repeated.solve(matrix, load) == exact).all()
    assert len(counting.probed) == len(matrices)


def test_the_same_system_twice_and_no_load():
    (matrix,), load = systems(0.1)
    repeated = Repeated(Cholmod(), ACCURACY)
    first = repeated.solve(matrix, load)
    assert repeated.solve(matrix, load) == pytest.approx(first, abs=1e-12)
    assert np.abs(repeated.solve(matrix, np.zeros_like(load))).max() < CHANGE * ACCURACY


def test_what_is_not_definite_is_refused_later_too():
    (matrix,), load = systems(0.1)
    repeated = Repeated(Cholmod(), ACCURACY)
    repeated.solve(matrix, load)
    with pytest.raises(ModelingError, match="not positive definite"):
        repeated.solve(-matrix, load)
