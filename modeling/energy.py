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

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.errors import ModelingError
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
    sides : (m, 3) array
        Edge opposite to each corner of each triangle.
    corners : (3, m) array
        The triangles once more, in the order of their least nodes.
    hinges : Hinges
        The q edges with two of these triangles.
    edge_slots : (e,) array
        Number of each edge among the off-diagonal pairs of A.
    tip_slots : (q,) array
        The same of the pair kl of each hinge.
    pair_count : int
        Number p of off-diagonal pairs of A.
    indptr, indices : (n + 1,) and (n + 2 p,) arrays
        The pattern of A, compressed by columns, row indices ascending, int32.
    source : (n + 2 p,) array
        For each entry of A the index of its value in (diagonal, off-diagonal pairs).
    diagonal_at : (n,) array
        Where in those entries the diagonal stands.
    """

    node_count: int
    triangles: IntArray
    edges: IntArray
    sides: IntArray
    corners: IntArray
    hinges: Hinges
    edge_slots: IntArray
    tip_slots: IntArray
    pair_count: int
    indptr: Int32Array
    indices: Int32Array
    source: IntArray
    diagonal_at: IntArray

    @staticmethod
    def of(triangles: IntArray, node_count: int) -> EdgePattern:
        """Return the pattern of a triangulation of ``node_count`` nodes, triangles of shape (m, 3).

        Raises
        ------
        ModelingError
            When an edge has more than two triangles.
        """
        triangles = ints(triangles, -1, 3)
        # Triangles in the order of their nodes, for which all that is looked up lies close by in memory.
        order = np.argsort(np.minimum.reduce([*triangles.T]), kind="stable")
        ordered = ints(triangles[order])
        edges, ordered_sides = edge_table(ordered)
        sides = np.empty_like(ordered_sides)
        sides[order] = ordered_sides
        hinges = Hinges.of(ordered, edges, ordered_sides)
        # Of the six pairs of a hinge five are edges, known already; only the pair of its tips is looked up.
        keys = [edges[:, 0] * node_count + edges[:, 1]]
        keys.append(hinges.nodes[2:].min(axis=0) * node_count + hinges.nodes[2:].max(axis=0))
        pairs, slots = _numbered(np.concatenate(keys))
        indptr, indices, source = _columns(pairs // node_count, pairs % node_count, node_count)
        return EdgePattern(
            node_count=node_count,
            triangles=triangles,
            edges=edges,
            sides=ints(sides),
            corners=ints(np.ascontiguousarray(ordered.T)),
            hinges=hinges,
            edge_slots=ints(slots[: len(edges)]),
            tip_slots=ints(slots[len(edges) :]),
            pair_count=len(pairs),
            indptr=indptr,
            indices=indices,
            source=source,
            diagonal_at=ints(np.flatnonzero(source < node_count)),
        )

    def matrix(self, diagonal: FloatArray, pairs: FloatArray) -> csc_array:
        """Return the symmetric matrix with these values, shapes (n,) and (p,), in the pattern of A."""
        return self._filled(np.concatenate([diagonal, pairs])[self.source])

    def matrix_without_constants(self, pairs: FloatArray) -> csc_array:
        """Return the same whose diagonal makes its product with a constant zero."""
        data = np.concatenate([np.zeros(self.node_count), pairs])[self.source]
        # Each column holds its diagonal, so that none is empty.
        data[self.diagonal_at] = -np.add.reduceat(data, self.indptr[:-1]) if len(data) else 0.0
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
        count = np.arange(len(pattern.source), dtype=np.float64)
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
    cotangents, doubled = _cotangents(points, pattern)
    gaps, weights = _jumps(cotangents, doubled, pattern)
    # The jump of slope times |e| is d_e |e| (h_k + h_l) / (h_k h_l), and the coefficients of k and l in d_e
    # sum to -1.
    scale = -1.0 / (gaps[2] + gaps[3])
    return floats(np.stack([gap * scale for gap in gaps], axis=1)), floats(weights / scale**2)


def cotangent_weights(points: FloatArray, pattern: EdgePattern) -> FloatArray:
    """Return the weight w_e = (cot a_k + cot a_l) / 2 of each edge, shape (e,), without unit.

    a_k, a_l are the angles opposite to the edge; an edge with one triangle has one of them. Raises
    ModelingError as :func:`hinge_coefficients` does. ``points``: (n, 2), model units.
    """
    return floats(_edge_weights(_cotangents(points, pattern)[0], pattern))


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
    cotangents, doubled = _cotangents(points, pattern)
    own = np.zeros(len(pattern.edges))
    pairs = np.zeros(pattern.pair_count)
    load = np.zeros(len(points))
    if theta < 1.0:
        own -= (1.0 - theta) * _edge_weights(cotangents, pattern)
    if theta > 0.0:
        (i, j, k, ell), weights = _jumps(cotangents, doubled, pattern)
        weights *= theta * length**2
        if bend is not None:
            load = _bent_load(points, pattern, bend, [i, j, k, ell], weights)
        at_i, at_j = weights * i, weights * j
        rims = np.concatenate([at_i * k, at_j * k, at_i * ell, at_j * ell, [0.0]])
        own[pattern.hinges.edges] += at_i * j
        for rim in pattern.hinges.rims:
            own += rims[rim]
        pairs += np.bincount(pattern.tip_slots, weights * k * ell, minlength=len(pairs))
    pairs[pattern.edge_slots] += own
    return pattern.matrix_without_constants(pairs), load


def _bent_load(
    points: FloatArray, pattern: EdgePattern, bend: FloatArray, jumps: list[FloatArray], weights: FloatArray
) -> FloatArray:
    """Return the load of :func:`system`; ``jumps`` and ``weights`` as of ``_jumps``, times theta l^2."""
    nodes = pattern.hinges.nodes
    x, y = (np.ascontiguousarray(column) for column in points.T)
    xx, xy, yy = (column[nodes[0]] + column[nodes[1]] for column in np.ascontiguousarray(0.5 * bend.T))
    xx, yy = 0.5 * xx, 0.5 * yy
    # A jump knows no planes, so that 1/2 P^T K P may be counted from node i.
    from_x, from_y = x[nodes[0]], y[nodes[0]]
    pull = np.zeros(len(weights))
    for node, jump in zip(nodes[1:], jumps[1:], strict=True):
        dx, dy = x[node] - from_x, y[node] - from_y
        pull += jump * (dx * (xx * dx + xy * dy) + yy * dy * dy)
    pull *= weights
    load = np.zeros(len(points))
    for node, jump in zip(nodes, jumps, strict=True):
        load += np.bincount(node, pull * jump, minlength=len(load))
    return load


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


def _cotangents(points: FloatArray, pattern: EdgePattern) -> tuple[FloatArray, FloatArray]:
    """Return the cotangents of all angles, (3 m + 1,), the last 0 for the one a border lacks, and 2 areas."""
    x, y = (np.ascontiguousarray(column) for column in points.T)
    at_x, at_y = [x[c] for c in pattern.corners], [y[c] for c in pattern.corners]
    # Sides opposite to each corner, all the same way round.
    dx = [at_x[(c + 2) % 3] - at_x[(c + 1) % 3] for c in range(3)]
    dy = [at_y[(c + 2) % 3] - at_y[(c + 1) % 3] for c in range(3)]
    doubled = dx[0] * dy[1] - dx[1] * dy[0]
    if doubled.sum() < 0:
        doubled = -doubled
    if not (doubled > 0).all():
        raise _unfit(points, pattern, ~(doubled > 0))
    cotangents = np.zeros(pattern.triangles.size + 1)
    for c in range(3):
        a, b = (c + 1) % 3, (c + 2) % 3
        cotangents[c:-1:3] = -(dx[a] * dx[b] + dy[a] * dy[b]) / doubled
    return cotangents, doubled


def _edge_weights(cotangents: FloatArray, pattern: EdgePattern) -> FloatArray:
    first, second = pattern.hinges.opposite
    return np.asarray(0.5 * (cotangents[first] + cotangents[second]), dtype=np.float64)


def _jumps(
    cotangents: FloatArray, doubled: FloatArray, pattern: EdgePattern
) -> tuple[list[FloatArray], FloatArray]:
    """Return |e| J_e of each hinge as coefficients of u_i, u_j, u_k, u_l, (q,) each, and its weight in E_H.

    The slope across ij in the triangle ijk, times |e|, is cot_i (u_k - u_j) + cot_j (u_k - u_i). With
    h = 2 area / |e| the weight 3 |e| / (h_k + h_l) / |e|^2 is 3 over the two doubled areas.
    """
    in_k_i, in_k_j, in_l_i, in_l_j = (cotangents[angle] for angle in pattern.hinges.angles)
    weights = 3.0 / (doubled[pattern.hinges.faces[0]] + doubled[pattern.hinges.faces[1]])
    return [-(in_k_j + in_l_j), -(in_k_i + in_l_i), in_k_i + in_k_j, in_l_i + in_l_j], weights


def _unfit(points: FloatArray, pattern: EdgePattern, unfit: BoolArray) -> ModelingError:
    x, y = points[pattern.corners[:, np.argmax(unfit)]].mean(axis=0)
    return ModelingError(
        f"{np.count_nonzero(unfit)} of {len(unfit)} plan triangles have no area or are turned over, the "
        f"first at x {x:.6g}, y {y:.6g}."
    )
