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

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.errors import ModelingError
from graben.surface import edge_sharing, edge_table

# Pairs of columns of a hinge (i, j, k, l) with different nodes; the four equal pairs go to the diagonal.
_PAIRS = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
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
    sides : (m, 3) array
        Edge opposite to each corner of each triangle.
    hinges : (q, 4) array
        Nodes (i, j, k, l) of each edge ij with two triangles, k and l opposite.
    pair_slots : (q, 6) array
        Number of each unordered node pair of a hinge among the off-diagonal pairs of A.
    edge_slots : (e,) array
        The same of each edge.
    pair_count : int
        Number p of off-diagonal pairs of A.
    indptr, indices : (n + 1,) and (n + 2 p,) arrays
        The pattern of A, compressed by columns, row indices ascending, int32.
    source : (n + 2 p,) array
        For each entry of A the index of its value in (diagonal, off-diagonal pairs).
    """

    node_count: int
    triangles: IntArray
    edges: IntArray
    sides: IntArray
    hinges: IntArray
    pair_slots: IntArray
    edge_slots: IntArray
    pair_count: int
    indptr: Int32Array
    indices: Int32Array
    source: IntArray

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
        hinges, hinge_sides = _hinges(triangles, edges, sides)
        # Five of the six pairs of a hinge are edges, known already; only the pair of its tips is looked up.
        keys = [edges[:, 0] * node_count + edges[:, 1]]
        keys.append(hinges[:, 2:].min(axis=1) * node_count + hinges[:, 2:].max(axis=1))
        pairs, slots = np.unique(np.concatenate(keys), return_inverse=True)
        edge_slots, tip_slots = slots[: len(edges)], slots[len(edges) :]
        indptr, indices, source = _columns(pairs // node_count, pairs % node_count, node_count)
        return EdgePattern(
            node_count=node_count,
            triangles=triangles,
            edges=edges,
            sides=sides,
            hinges=hinges,
            pair_slots=ints(np.concatenate([edge_slots[hinge_sides], tip_slots[:, None]], axis=1)),
            edge_slots=ints(edge_slots),
            pair_count=len(pairs),
            indptr=indptr,
            indices=indices,
            source=source,
        )

    def matrix(self, diagonal: FloatArray, pairs: FloatArray) -> csc_array:
        """Return the symmetric matrix with these values, shapes (n,) and (p,), in the pattern of A."""
        data = np.concatenate([diagonal, pairs])[self.source]
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
        count = np.arange(len(pattern.source), dtype=np.float64)
        numbers = csc_array(
            (count, pattern.indices.copy(), pattern.indptr.copy()), shape=(pattern.node_count,) * 2
        )
        part = csc_array(numbers[:, columns][rows, :])
        part.sort_indices()
        return Block(ints(part.data), part)

    def of_matrix(self, matrix: csc_array) -> csc_array:
        """Return the block of a matrix that :func:`assemble` made; its own pattern is always the same."""
        part = self.pattern
        result = csc_array(
            (matrix.data[self.entries], part.indices.copy(), part.indptr.copy()), shape=part.shape
        )
        result.has_canonical_format = True
        return result


def hinge_coefficients(points: FloatArray, pattern: EdgePattern) -> tuple[FloatArray, FloatArray]:
    """Return the gap d_e of each hinge as four coefficients, and its weight c_e in E_H.

    The lines ij and kl cross at X = (1-t) P_i + t P_j = (1-s) P_k + s P_l, and
    d_e(u) = (1-t) u_i + t u_j - (1-s) u_k - s u_l; with h_k, h_l the distances of P_k, P_l from line ij,
    c_e = 3 |e| / (h_k + h_l) ((h_k + h_l) / (h_k h_l))^2.

    Parameters
    ----------
    points : (n, 2) array
        Node positions in plan, model units.
    pattern : EdgePattern
        The triangulation.

    Returns
    -------
    coefficients : (q, 4) array
        Of u_i, u_j, u_k, u_l, without unit.
    weights : (q,) array
        c_e, one over square model units.

    Raises
    ------
    ModelingError
        When a triangle has no area or is turned over against the others.
    """
    _oriented_areas(points, pattern)
    i, j, k, ell = (points[pattern.hinges[:, c]] for c in range(4))
    along, to_k, to_l = j - i, k - i, ell - i
    square = (along * along).sum(axis=1)
    length = np.sqrt(square)
    height_k = np.abs(_cross(along, to_k)) / length
    height_l = np.abs(_cross(along, to_l)) / length
    height = height_k + height_l
    s = height_k / height
    t = ((1.0 - s) * (to_k * along).sum(axis=1) + s * (to_l * along).sum(axis=1)) / square
    weights = 3.0 * length / height * (height / (height_k * height_l)) ** 2
    return floats(np.stack([1.0 - t, t, s - 1.0, -s], axis=1)), floats(weights)


def cotangent_weights(points: FloatArray, pattern: EdgePattern) -> FloatArray:
    """Return the weight w_e = (cot a_k + cot a_l) / 2 of each edge, shape (e,), without unit.

    a_k, a_l are the angles opposite to the edge; an edge with one triangle has one of them. Raises
    ModelingError as :func:`hinge_coefficients` does. ``points``: (n, 2), model units.
    """
    areas = _oriented_areas(points, pattern)
    corners = [points[pattern.triangles[:, c]] for c in range(3)]
    weights = np.zeros(len(pattern.edges))
    for c in range(3):
        a, b = corners[(c + 1) % 3] - corners[c], corners[(c + 2) % 3] - corners[c]
        half_cotangent = (a * b).sum(axis=1) / (4.0 * areas)
        weights += np.bincount(pattern.sides[:, c], half_cotangent, minlength=len(weights))
    return floats(weights)


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
    diagonal, pairs = np.zeros(pattern.node_count), np.zeros(pattern.pair_count)
    if theta < 1.0:
        weights = (1.0 - theta) * cotangent_weights(points, pattern)
        pairs[pattern.edge_slots] -= weights
        for c in range(2):
            diagonal += np.bincount(pattern.edges[:, c], weights, minlength=len(diagonal))
    if theta > 0.0:
        coefficients, weights = hinge_coefficients(points, pattern)
        weighted = (theta * length**2 * weights)[:, None] * coefficients
        for c in range(4):
            own = weighted[:, c] * coefficients[:, c]
            diagonal += np.bincount(pattern.hinges[:, c], own, minlength=len(diagonal))
        for slot, (a, b) in enumerate(_PAIRS):
            product = weighted[:, a] * coefficients[:, b]
            pairs += np.bincount(pattern.pair_slots[:, slot], product, minlength=len(pairs))
    return pattern.matrix(diagonal, pairs)


def dirichlet(points: FloatArray, pattern: EdgePattern) -> csc_array:
    """Return L, so that E_D(u) = 1/2 u^T L u, shape (n, n), with the pattern of the edges alone.

    ``points``: (n, 2), model units; the pattern is the same at each call. Raises ModelingError as
    :func:`assemble` does.
    """
    weights = cotangent_weights(points, pattern)
    a, b = pattern.edges.T
    diagonal = np.bincount(a, weights, minlength=pattern.node_count)
    diagonal += np.bincount(b, weights, minlength=pattern.node_count)
    nodes = np.arange(pattern.node_count)
    rows, columns = np.concatenate([nodes, a, b]), np.concatenate([nodes, b, a])
    values = np.concatenate([diagonal, -weights, -weights])
    return coo_array((values, (rows, columns)), shape=(pattern.node_count,) * 2).tocsc()


def _hinges(triangles: IntArray, edges: IntArray, sides: IntArray) -> tuple[IntArray, IntArray]:
    """Return the hinges (q, 4) and the edges ij, ik, il, jk, jl of each, (q, 5)."""
    sharing = edge_sharing(sides, len(edges))
    if len(sharing) and sharing.max() > 2:
        a, b = edges[int(np.argmax(sharing))]
        raise ModelingError(f"More than two triangles share the edge between nodes {a} and {b}.")
    inner = np.flatnonzero(sharing == 2)
    first = np.concatenate([[0], np.cumsum(sharing)])[inner]
    order = np.argsort(sides.ravel(), kind="stable")
    start = edges[inner, 0]
    opposite, at_start, at_end = [], [], []
    for corner in (order[first], order[first + 1]):
        base, c = corner - corner % 3, corner % 3
        after, before = base + (c + 1) % 3, base + (c + 2) % 3
        forward = triangles.ravel()[after] == start
        opposite.append(triangles.ravel()[corner])
        at_start.append(sides.ravel()[np.where(forward, before, after)])
        at_end.append(sides.ravel()[np.where(forward, after, before)])
    hinges = np.concatenate([edges[inner], np.stack(opposite, axis=1)], axis=1)
    return ints(hinges, -1, 4), ints(np.stack([inner, *at_start, *at_end], axis=1), -1, 5)


def _columns(low: IntArray, high: IntArray, node_count: int) -> tuple[Int32Array, Int32Array, IntArray]:
    """Return indptr, indices and source of the symmetric pattern with a full diagonal and these pairs."""
    nodes = np.arange(node_count)
    rows = np.concatenate([nodes, low, high])
    columns = np.concatenate([nodes, high, low])
    values = np.concatenate([nodes, np.tile(node_count + np.arange(len(low)), 2)])
    # By rows, then by columns: two countings, after which the row indices of each column ascend.
    numbers = coo_array((values, (rows, columns)), shape=(node_count,) * 2).tocsr().tocsc()
    indptr, indices = numbers.indptr.astype(np.int32), numbers.indices.astype(np.int32)
    indptr.flags.writeable = indices.flags.writeable = False
    return indptr, indices, ints(numbers.data)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], dtype=np.float64)


def _oriented_areas(points: FloatArray, pattern: EdgePattern) -> FloatArray:
    """Return the areas of the triangles, positive; raise ModelingError where one is not."""
    a, b, c = (points[pattern.triangles[:, k]] for k in range(3))
    areas = 0.5 * _cross(b - a, c - a)
    if areas.sum() < 0:
        areas = -areas
    unfit = np.flatnonzero(~(areas > 0))
    if len(unfit):
        x, y = (a[unfit[0]] + b[unfit[0]] + c[unfit[0]]) / 3.0
        raise ModelingError(
            f"{len(unfit)} of {len(areas)} plan triangles have no area or are turned over, the first at "
            f"x {x:.6g}, y {y:.6g}."
        )
    return floats(areas)
