"""Symmetric positive definite systems behind one small interface: analyse, factor, solve.

``backend.analyse(matrix).factor(matrix).solve(rhs)``: the analysis depends on the pattern alone and serves
every matrix of that pattern. :class:`Cholmod` is the default; :class:`SuperLU` is the paper's (Sect. 8).
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from graben.arrays import FloatArray, floats, ints
from graben.errors import ModelingError

# A factor that returns a known solution with a larger relative error than this has lost it to rounding.
PROBE_ERROR = 1e-3
_PROBE_SEED = 0

_NOT_DEFINITE = (
    "The surface is not determined by its fixed nodes (the matrix is not positive definite): each connected "
    "part needs three or more fixed nodes that are not in one line, and a cut that keeps clear of itself and "
    "of the boundary."
)


class Factor(Protocol):
    """A factored matrix."""

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Return x with A x = rhs; both of shape (n,) or (n, k)."""


class Analysis(Protocol):
    """What is known of a pattern before any value is."""

    def factor(self, matrix: csc_array, *, probe: bool = True) -> Factor:
        """Return the factor of a symmetric positive definite matrix of the analysed pattern.

        Without ``probe``, which costs one solve, a matrix that is nearly singular may pass, and one that is
        not positive definite may show on the first solve only.

        Raises
        ------
        ModelingError
            When the matrix is not positive definite, or so nearly singular that a solution has no digits.
        """


class Backend(Protocol):
    """A linear algebra library."""

    def analyse(self, matrix: csc_array) -> Analysis:
        """Return the analysis of the pattern of a symmetric matrix, both halves stored (values unread)."""


def residual(matrix: csc_array, x: FloatArray, rhs: FloatArray) -> float:
    """Return the backward error max|A x - b| / (|A| max|x| + max|b|), without unit; |A| the greatest row sum.

    About 1e-16 to 1e-14 after a sound solve, whatever the condition of A.
    """
    if x.size == 0:
        return 0.0
    norm = float(abs(matrix).sum(axis=1).max())
    scale = norm * float(np.abs(x).max()) + float(np.abs(rhs).max())
    return float(np.abs(matrix @ x - rhs).max()) / scale if scale > 0 else 0.0


@dataclass(frozen=True)
class Cholmod:
    """CHOLMOD through kvxopt: supernodal Cholesky of the lower half, ordered by minimum degree."""

    def analyse(self, matrix: csc_array) -> CholmodAnalysis:
        """Return the symbolic factorization of the pattern of ``matrix``, (n, n), both halves stored."""
        return CholmodAnalysis(matrix)


class CholmodAnalysis:
    """The symbolic factorization of one pattern, and the memory of one numeric factor.

    CHOLMOD writes the numeric factor into the symbolic one. Each new factor therefore ends the one before:
    its ``solve`` raises RuntimeError from then on. Whoever needs two at a time makes two analyses.
    """

    def __init__(self, matrix: csc_array) -> None:
        kvxopt = _kvxopt()
        matrix = _sorted(matrix)
        self._indptr, self._indices = matrix.indptr.copy(), matrix.indices.copy()
        columns = np.repeat(np.arange(matrix.shape[1], dtype=matrix.indices.dtype), np.diff(self._indptr))
        self._lower = ints(np.flatnonzero(self._indices >= columns))
        self._live: CholmodFactor | None = None
        self._symbolic: Any = None
        if matrix.shape[0] > 0:
            rows, columns = ints(self._indices[self._lower]), ints(columns[self._lower])
            self._values = kvxopt.spmatrix(
                kvxopt.matrix(np.ones(len(rows))), kvxopt.matrix(rows), kvxopt.matrix(columns), matrix.shape
            )
            self._symbolic = kvxopt.cholmod.symbolic(self._values)

    def factor(self, matrix: csc_array, *, probe: bool = True) -> CholmodFactor:
        """Return the Cholesky factor; see :meth:`Analysis.factor`. The factor made before ends."""
        kvxopt = _kvxopt()
        matrix = _sorted(matrix)
        _require_pattern(matrix, self._indptr, self._indices)
        if self._live is not None:
            self._live.end()
        factor = CholmodFactor(self._symbolic)
        self._live = factor
        if matrix.shape[0] > 0:
            self._values.V = kvxopt.matrix(np.ascontiguousarray(matrix.data[self._lower], dtype=np.float64))
            # kvxopt reads the status of the factorization before it is made; a failure shows on solving.
            kvxopt.cholmod.numeric(self._values, self._symbolic)
            if probe:
                _probe(factor, matrix)
        return factor


class CholmodFactor:
    """A numeric Cholesky factor, good until its analysis makes the next."""

    def __init__(self, handle: Any) -> None:
        self._handle = handle
        self._ended = False

    def end(self) -> None:
        """Mark the factor as overwritten by the next."""
        self._ended = True

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Return x with A x = rhs, shape (n,) or (n, k)."""
        kvxopt = _kvxopt()
        if self._ended:
            raise RuntimeError("This factor was overwritten: its analysis has made another one since.")
        if rhs.size == 0:
            return floats(rhs)
        x = kvxopt.matrix(np.asfortranarray(rhs.reshape(len(rhs), -1), dtype=np.float64))
        try:
            kvxopt.cholmod.solve(self._handle, x)
        except ArithmeticError:
            raise ModelingError(_NOT_DEFINITE) from None
        return floats(np.array(x), *rhs.shape)


@dataclass(frozen=True)
class SuperLU:
    """SuperLU through scipy, in its symmetric mode: minimum degree on A + A^T, pivots on the diagonal."""

    def analyse(self, matrix: csc_array) -> SuperLUAnalysis:
        """Return an analysis that only remembers the pattern: scipy's interface keeps no symbolic factor."""
        return SuperLUAnalysis(matrix)


class SuperLUAnalysis:
    """The pattern of a matrix; every factor is independent of the others."""

    def __init__(self, matrix: csc_array) -> None:
        matrix = _sorted(matrix)
        self._indptr, self._indices = matrix.indptr.copy(), matrix.indices.copy()

    def factor(self, matrix: csc_array, *, probe: bool = True) -> SuperLUFactor:
        """Return the factor; see :meth:`Analysis.factor`."""
        from scipy.sparse.linalg import splu

        matrix = _sorted(matrix)
        _require_pattern(matrix, self._indptr, self._indices)
        if matrix.shape[0] == 0:
            return SuperLUFactor(None)
        try:
            handle = splu(
                matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError:
            raise ModelingError(_NOT_DEFINITE) from None
        factor = SuperLUFactor(handle)
        # Without row exchanges the pivots have the signs of the eigenvalues.
        if not (handle.U.diagonal() > 0).all():
            raise ModelingError(_NOT_DEFINITE)
        if probe:
            _probe(factor, matrix)
        return factor


class SuperLUFactor:
    """A numeric LU factor."""

    def __init__(self, handle: Any) -> None:
        self._handle = handle

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Return x with A x = rhs, shape (n,) or (n, k)."""
        return floats(rhs) if rhs.size == 0 else floats(self._handle.solve(np.asarray(rhs)))


def _kvxopt() -> Any:
    """Return the module, untyped: its stubs do not know that it takes numpy's arrays."""
    import_module("kvxopt.cholmod")
    return import_module("kvxopt")


def _sorted(matrix: csc_array) -> csc_array:
    """Return the matrix with ascending row indices, a copy where they are not."""
    return matrix if matrix.has_sorted_indices else matrix.sorted_indices()


def _require_pattern(matrix: csc_array, indptr: NDArray[Any], indices: NDArray[Any]) -> None:
    if not (np.array_equal(matrix.indptr, indptr) and np.array_equal(matrix.indices, indices)):
        raise ValueError("The matrix has another pattern than the one that was analysed.")


def _probe(factor: Factor, matrix: csc_array) -> None:
    """Raise ModelingError when the factor does not give a known solution back."""
    known = np.random.default_rng(_PROBE_SEED).standard_normal(matrix.shape[0])
    error = np.abs(factor.solve(floats(matrix @ known)) - known).max()
    if not error <= PROBE_ERROR * np.abs(known).max():
        raise ModelingError(_NOT_DEFINITE)
