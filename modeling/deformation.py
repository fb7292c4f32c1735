"""How the mesh follows the cut: two Laplace problems for the plan displacement (paper Sect. 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.modeling.algebra import Backend, Factor
from graben.modeling.energy import EdgePattern, dirichlet
from graben.modeling.outline import Run


@dataclass(frozen=True, eq=False)
class Deformation:
    """The positions of a mesh as a function of those of its cut nodes.

    The matrix is that of the first mesh on the nodes that are free to move, so it is factored once
    (the map has no memory and the triangles do not drift).

    Parameters
    ----------
    points : (n, 2) array
        The first mesh, model units.
    free, held : (a,), (b,) arrays
        Nodes that follow, and nodes of the cut and of the outer boundary, whose moves are given.
    factor : Factor or None
        Of the Laplacian on the free nodes.
    coupling : (a, b) sparse array
        Of the free nodes with the held ones.
    runs : sequence of Run
        Stretches of the outer boundary that slide with the exits.
    """

    points: FloatArray
    free: IntArray
    held: IntArray
    factor: Factor | None
    coupling: csr_array
    runs: Sequence[Run]

    @staticmethod
    def of(
        points: FloatArray,
        pattern: EdgePattern,
        unknown: BoolArray,
        fixed_border: BoolArray,
        cut: IntArray,
        runs: Sequence[Run],
        backend: Backend,
    ) -> Deformation:
        """Prepare the deformation; ``fixed_border`` (n,) marks the outer boundary, ``cut`` (c,) the cut."""
        held = fixed_border.copy()
        held[cut] = True
        held &= unknown
        free = np.flatnonzero(unknown & ~held)
        at = np.flatnonzero(held)
        matrix = dirichlet(points, pattern)
        factor = None
        if len(free):
            inner = matrix[:, free].tocsr()[free].tocsc()
            factor = backend.analyse(inner).factor(inner)
        return Deformation(points, free, at, factor, matrix[:, at].tocsr()[free], runs)

    def deformed(self, cut: IntArray, places: FloatArray) -> FloatArray:
        """Return the positions of all nodes, (n, 2), when the nodes ``cut`` (c,) lie at ``places`` (c, 2)."""
        result = self.points.copy()
        result[cut] = places
        for run in self.runs:
            first, last = run.arc_of(result[run.nodes[0]]), run.arc_of(result[run.nodes[-1]])
            result[run.nodes[1:-1]] = run.slid(first, last - run.arcs[-1])
        if self.factor is not None:
            given = result[self.held] - self.points[self.held]
            result[self.free] += self.factor.solve(-(self.coupling @ given))
        return result
