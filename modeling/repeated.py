"""Systems of one pattern that change less and less from one to the next.

An old factor is an excellent preconditioner as long as the matrix has hardly changed: the error falls by a
factor of 5 to 50 with each step of conjugate gradients, whose cost is about that of one solve. On 52,000
unknowns of a zone a numeric factorization costs as much as six solves, on fewer less, on more still more.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array

from graben.arrays import FloatArray
from graben.modeling.algebra import Analysis, Backend, Factor

#: Where an entry of the diagonal has changed by more than this share since the factor was made, a new one
#: is made: it then takes about as many steps as a factorization costs.
CHANGE = 0.25
#: Steps after which a new factor is made all the same.
_MOST_STEPS = 5


class Repeated:
    """The solutions of successive systems with symmetric positive definite matrices of one pattern.

    Parameters
    ----------
    backend : Backend
        Linear algebra.
    accuracy : float
        How large the last correction of a solution may be, in units of the solution. The correction is then
        made, and since the factor that gave it is that of a matrix within CHANGE of the present one, the
        error left is about a tenth of it. 0: each matrix is factored anew.
    """

    def __init__(self, backend: Backend, accuracy: float) -> None:
        self._backend, self._accuracy = backend, accuracy
        self._analysis: Analysis | None = None
        self._factor: Factor | None = None
        self._diagonal = self._last = np.zeros(0)

    def solve(self, matrix: csc_array, rhs: FloatArray) -> FloatArray:
        """Return x with A x = rhs, (n,); the first matrix, (n, n), both halves stored, gives the pattern.

        Raises
        ------
        ModelingError
            When the matrix is not positive definite; see :meth:`Analysis.factor`.
        """
        diagonal = matrix.diagonal()
        solution = self._corrected(matrix, diagonal, rhs)
        if solution is None:
            first = self._analysis is None
            self._analysis = self._analysis or self._backend.analyse(matrix)
            # What a pattern lacks, its first matrix shows.
            self._factor = self._analysis.factor(matrix, probe=first)
            self._diagonal = diagonal
            solution = self._factor.solve(rhs)
        self._last = solution
        return solution

    def _corrected(self, matrix: csc_array, diagonal: FloatArray, rhs: FloatArray) -> FloatArray | None:
        """Return the solution by conjugate gradients from the last one; None where a factor is better."""
        if self._factor is None or self._accuracy <= 0.0:
            return None
        if (np.abs(diagonal - self._diagonal) > CHANGE * self._diagonal).any():
            return None
        solution = self._last.copy()
        residual = rhs - matrix @ solution
        way, before = np.zeros(len(rhs)), np.inf
        for _ in range(_MOST_STEPS):
            correction = self._factor.solve(residual)
            if np.abs(correction).max(initial=0.0) <= self._accuracy:
                return np.asarray(solution + correction, dtype=np.float64)
            now = residual @ correction
            way = correction + now / before * way
            image = matrix @ way
            share = now / (way @ image)
            solution += share * way
            residual -= share * image
            before = now
        return None
