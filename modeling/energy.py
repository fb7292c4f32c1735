"""The energy of a horizon and its edge-based discretization (paper Sect. 2).

On a plan triangulation with values u at its nodes,

    E(u) = (1 - theta) E_D(u) + theta l^2 E_H(u),
    E_D(u) = 1/2 sum over edges of w_e (u_i - u_j)^2,
    E_H(u) = 1/2 sum over edges with two triangles of c_e d_e(u)^2,

E_D the Dirichlet energy with cotangent weights w_e, E_H the Hessian-like energy made of the jumps of slope
across the edges, zero exactly on planes; theta in [0, 1] and the length l, model units, are parameters. The
matrix of E is A = (1 - theta) L + theta l^2 B. Everything here is made from single triangles and pairs of
neighbours, so that a triangulation which overlaps itself in plan is as good as any other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array

from graben.arrays import FloatArray, IntArray, ints
from graben.errors import ModelingError
from graben.modeling.assembly import add_jumps, add_slopes, fill
from graben.modeling.hinges import Hinges
from graben.surface import edge_table

Int32Array = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class EdgePattern:
    """What depends on the adjacency of a triangulation alone, made once and used for every assembly.

    Use :meth:`of` to make one.

    Parameters
    ----------
    node_count : int
        Number n of nodes.
    triangles : (m, 3) array
        Node indices, consistently oriented.
    edges : (e, 2) array
        Node indices of all edges, the smaller first.
    edge_slots : (e,) array
        Number of each edge among the off-diagonal pairs of A.
    side_slots : (m, 3) array
        The same of the side opposite to each corner of each triangle.
    hinges, hinge_slots : (q, 4) and (q, 6) arrays
        Nodes i, j, k, l of each edge ij with two triangles, and the numbers of ij, ik, jk, il, jl and kl.
    pair_count : int
        Number p of off-diagonal pairs of A.
    indptr, indices : (n + 1,) and (n + 2 p,) arrays
        The pattern of A, compressed by columns, row indices ascending.
    pairs_at : (2, p) array
        Where in those entries each pair stands, below and above the diagonal.
    diagonal_at : (n,) array
        Where the diagonal stands.
    """

    node_count: int
    triangles: IntArray
    edges: IntArray
    edge_slots: IntArray
    side_slots: Int32Array
    hinges: Int32Array
    hinge_slots: Int32Array
    pair_count: int
    indptr: Int32Array
    indices: Int32Array
    pairs_at: Int32Array
    diagonal_at: Int32Array

    @staticmethod
    def of(triangles: IntArray, node_count: int) -> EdgePattern:
        """Return the pattern of a triangulation of ``node_count`` nodes, triangles of shape (m, 3).

        Raises
        ------
        ModelingError
            When an edge has more than two triangles.
        """
        triangles = ints(triangles, -1, 3)
        edges, sides = edge_table(triangles)
        hinges = Hinges.of(triangles, edges, sides)
        # Of the six pairs of a hinge five are edges, known already; only the pair of its tips is looked up.
        tips = np.sort(hinges.nodes[:, 2:], axis=1)
        keys = np.concatenate([edges, tips]) @ [node_count, 1]
        pairs, slots = _numbered(keys)
        edge_slots = slots[: len(edges)]
        hinge_slots = np.concatenate([edge_slots[hinges.edges], slots[len(edges) :, None]], axis=1)
        indptr, indices, source = _columns(pairs // node_count, pairs % node_count, node_count)
        at = np.argsort(source, kind="stable")
        return EdgePattern(
            node_count=node_count,
            triangles=triangles,
            edges=edges,
            edge_slots=ints(edge_slots),
            side_slots=_int32(edge_slots[sides]),
            hinges=_int32(hinges.nodes),
            hinge_slots=_int32(hinge_slots),
            pair_count=len(pairs),
            indptr=_int32(indptr),
            indices=_int32(indices),
            pairs_at=_int32(at[node_count:].reshape(-1, 2).T),
            diagonal_at=_int32(at[:node_count]),
        )

    def matrix(self, diagonal: FloatArray, pairs: FloatArray) -> csc_array:
        """Return the symmetric matrix with these values, shapes (n,) and (p,), in the pattern of A."""
        data = np.empty(len(self.indices))
        data[self.diagonal_at] = diagonal
        data[self.pairs_at] = pairs
        return self._filled(data)

    def matrix_without_constants(self, pairs: FloatArray) -> csc_array:
        """Return the same whose diagonal makes its product with a constant zero."""
        data = np.empty(len(self.indices))
        fill(self.indptr, self.pairs_at, self.diagonal_at, pairs, data)
        return self._filled(data)

    def _filled(self, data: FloatArray) -> csc_array:
        # A matrix owns its indices, since scipy may sort or prune them in place.
        result = csc_array(
            (data, self.indices.copy(), self.indptr.copy()), shape=(self.node_count, self.node_count)
        )
        result.has_canonical_format = True
        return result


@dataclass(frozen=True, eq=False)
class Block:
    """Rows and columns taken out of matrices that share one pattern: ``Block.of(pattern, rows, columns)``.

    ``entries`` holds where each value of the block stands in the data of the whole matrix.
    """

    entries: IntArray
    pattern: csc_array

    @staticmethod
    def of(pattern: EdgePattern, rows: IntArray, columns: IntArray) -> Block:
        """Return the block of the given rows and columns (node indices) of every A of this pattern."""
        count = np.arange(len(pattern.indices), dtype=np.float64)
        numbers = csc_array(
            (count, pattern.indices.copy(), pattern.indptr.copy()), shape=(pattern.node_count,) * 2
        )
        part = csc_array(numbers[:, columns][rows, :])
        part.sort_indices()
        return Block(ints(part.data), part)

    def of_matrix(self, matrix: csc_array) -> csc_array:
        """Return the block of a matrix that :func:`assemble` made; its own pattern is always the same."""
        # Canonical, and shared as it is: scipy has nothing to sort or prune in it.
        part = self.pattern
        result = csc_array((matrix.data[self.entries], part.indices, part.indptr), shape=part.shape)
        result.has_canonical_format = True
        return result


def assemble(points: FloatArray, pattern: EdgePattern, theta: float, length: float) -> csc_array:
    """Return A = (1 - theta) L + theta length^2 B, so that E(u) = 1/2 u^T A u.

    Parameters
    ----------
    points : (n, 2) array
        Node positions in plan, model units.
    pattern : EdgePattern
        The triangulation.
    theta : float
        Share of E_H, in [0, 1]; 0 is the Dirichlet energy alone, 1 the Hessian-like energy alone.
    length : float
        The length l, model units.

    Returns
    -------
    csc_array, (n, n)
        Symmetric, both halves stored; ``indptr`` and ``indices`` are the same at each call, zeros included.

    Raises
    ------
    ModelingError
        When a triangle has no area or is turned over against the others.
    """
    return system(points, pattern, theta, length)[0]


def system(
    points: FloatArray, pattern: EdgePattern, theta: float, length: float, bend: FloatArray | None = None
) -> tuple[csc_array, FloatArray]:
    """Return A of :func:`assemble` and the load of surfaces that are bent, zero without ``bend``, (n,).

    With g_e = d_e(1/2 P^T K P) taken from each d_e, the minimum of E_H is at surfaces with the second
    derivatives K; A u = b becomes A u = b + load, load = theta l^2 times the sum of c_e g_e grad d_e.

    Parameters
    ----------
    points, pattern, theta, length
        As of :func:`assemble`, which says what is raised.
    bend : (n, 3) array, optional
        K_xx, K_xy and K_yy, one over model units; a hinge has the mean of its edge's two nodes.
    """
    pairs, load = _pairs(points, pattern, theta, length, bend)
    return pattern.matrix_without_constants(pairs), load


def _pairs(
    points: FloatArray, pattern: EdgePattern, theta: float, length: float, bend: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return the off-diagonal values of A, (p,), and the load; parameters as of :func:`system`."""
    x, y = (np.ascontiguousarray(column) for column in points.T)
    pairs, load = np.zeros(pattern.pair_count), np.zeros(pattern.node_count)
    if add_slopes(x, y, pattern.triangles, pattern.side_slots, 1.0 - theta, pairs) > 0:
        raise _unfit(points, pattern)
    if theta > 0.0:
        bent = np.zeros((3, 0)) if bend is None else np.ascontiguousarray(bend.T)
        scale = theta * length**2
        add_jumps(x, y, pattern.hinges, pattern.hinge_slots, scale, bent, pairs, load)
    return pairs, load


def dirichlet(points: FloatArray, pattern: EdgePattern) -> csc_array:
    """Return L, so that E_D(u) = 1/2 u^T L u, shape (n, n), with the pattern of the edges alone.

    ``points``: (n, 2), model units; the pattern is the same at each call. Raises ModelingError as
    :func:`assemble` does.
    """
    # Those of the pairs that are no edges are zero.
    weights = -_pairs(points, pattern, 0.0, 0.0)[0][pattern.edge_slots]
    a, b = pattern.edges.T
    diagonal = np.bincount(a, weights, minlength=pattern.node_count)
    diagonal += np.bincount(b, weights, minlength=pattern.node_count)
    nodes = np.arange(pattern.node_count)
    rows, columns = np.concatenate([nodes, a, b]), np.concatenate([nodes, b, a])
    values = np.concatenate([diagonal, -weights, -weights])
    return coo_array((values, (rows, columns)), shape=(pattern.node_count,) * 2).tocsc()


def _numbered(keys: IntArray) -> tuple[IntArray, IntArray]:
    """Return the different keys, ascending, and the number of each among them."""
    # A stable sort uses the runs in which they come: several times as fast as np.unique.
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    new = np.ones(len(keys), dtype=bool)
    new[1:] = ordered[1:] != ordered[:-1]
    numbers = np.empty(len(keys), dtype=np.int64)
    numbers[order] = np.cumsum(new) - 1
    return ordered[new], numbers


def _columns(low: IntArray, high: IntArray, node_count: int) -> tuple[IntArray, IntArray, IntArray]:
    """Return the symmetric pattern with a full diagonal and these pairs: indptr, indices and source.

    ``source`` tells which value stands where: 0 to n - 1 for the diagonal, then two in turn for each pair.
    """
    nodes = np.arange(node_count)
    rows = np.concatenate([nodes, high, low])
    columns = np.concatenate([nodes, low, high])
    below = node_count + 2 * np.arange(len(low))
    values = np.concatenate([nodes, below, below + 1])
    # By rows, then by columns: two countings, after which the row indices of each column ascend.
    numbers = coo_array((values, (rows, columns)), shape=(node_count,) * 2).tocsr().tocsc()
    return ints(numbers.indptr), ints(numbers.indices), ints(numbers.data)


def _int32(values: IntArray) -> Int32Array:
    result = np.ascontiguousarray(values, dtype=np.int32)
    result.flags.writeable = False
    return result


def _unfit(points: FloatArray, pattern: EdgePattern) -> ModelingError:
    a, b, c = (points[pattern.triangles[:, k]] for k in range(3))
    doubled = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    unfit = ~(doubled * np.sign(doubled.sum()) > 0.0)
    x, y = points[pattern.triangles[np.argmax(unfit)]].mean(axis=0)
    return ModelingError(
        f"{np.count_nonzero(unfit)} of {len(unfit)} plan triangles have no area or are turned over, the "
        f"first at x {x:.6g}, y {y:.6g}."
    )
