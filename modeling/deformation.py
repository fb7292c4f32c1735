"""How the mesh follows the cut: two Laplace problems for the plan displacement (paper Sect. 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array

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
        factor, coupling = _parts(dirichlet(points, pattern), free, at, backend)
        return Deformation(points, free, at, factor, coupling, runs)

    @property
    def moving(self) -> BoolArray:
        """Which nodes may move, shape (n,)."""
        result = np.zeros(len(self.points), dtype=bool)
        result[self.free] = result[self.held] = True
        return result

    def stiffened(self, pattern: EdgePattern, backend: Backend) -> Deformation:
        """Return the same with an interior that is the stiffer the smaller its triangles are.

        The conductivity of each triangle in the Laplacian is one over its area, so that the large triangles
        further away take up a move, and not the small ones beside the cut: T. E. Tezduyar et al.,
        Computation of unsteady incompressible flows, ASME AMD 143 (1992).
        """
        factor, coupling = _parts(_by_size(self.points, pattern), self.free, self.held, backend)
        return replace(self, factor=factor, coupling=coupling)

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


def _parts(
    matrix: csc_array, free: IntArray, held: IntArray, backend: Backend
) -> tuple[Factor | None, csr_array]:
    """Return the factor of the block of the free nodes, None without any, and their coupling to the held."""
    factor = None
    if len(free):
        inner = matrix[:, free].tocsr()[free].tocsc()
        factor = backend.analyse(inner).factor(inner)
    return factor, matrix[:, held].tocsr()[free]


def _by_size(points: FloatArray, pattern: EdgePattern) -> csc_array:
    """Return the Laplacian in which each triangle weighs the mean area over its own, shape (n, n)."""
    corners = [points[pattern.triangles[:, k]] for k in range(3)]
    ways = [corners[(k + 2) % 3] - corners[(k + 1) % 3] for k in range(3)]
    twice = np.abs(ways[0][:, 0] * ways[1][:, 1] - ways[0][:, 1] * ways[1][:, 0])
    weight = twice.mean() / twice
    rows, columns, values = [], [], []
    for i in range(3):
        for j in range(3):
            rows.append(pattern.triangles[:, i])
            columns.append(pattern.triangles[:, j])
            values.append(weight * (ways[i] * ways[j]).sum(axis=1) / (2.0 * twice))
    data = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return coo_array(data, shape=(pattern.node_count,) * 2).tocsc()
