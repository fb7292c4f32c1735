"""Anderson acceleration of a fixed-point iteration (docs/method.md)."""

from __future__ import annotations

import numpy as np

from graben.arrays import FloatArray


class Anderson:
    """The next iterate from the last ``depth`` steps; depth 0 is the plain iteration.

    Reference: D. G. Anderson, Iterative procedures for nonlinear integral equations, J. ACM 12 (1965).
    """

    def __init__(self, depth: int) -> None:
        self._depth = depth
        self._z: list[FloatArray] = []
        self._f: list[FloatArray] = []

    def following(self, z: FloatArray, image: FloatArray) -> FloatArray:
        """Return the next iterate, shape (n,), from an iterate and its image under the map."""
        residual = image - z
        self._z = [*self._z, z][-(self._depth + 1) :]
        self._f = [*self._f, residual][-(self._depth + 1) :]
        if self._depth == 0 or len(self._f) == 1:
            return image
        change_z = np.diff(np.array(self._z), axis=0).T
        change_f = np.diff(np.array(self._f), axis=0).T
        share = np.linalg.lstsq(change_f, residual, rcond=None)[0]
        return np.asarray(image - (change_z + change_f) @ share, dtype=np.float64)
