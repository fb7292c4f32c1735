"""The energy of a horizon by triangles and hinges: the loops of :mod:`~graben.modeling.energy`.

A hinge is an edge ij with two triangles ijk and ijl. Arrays: x, y (n,) the positions of the nodes in plan,
model units; ``pairs`` (p,) the off-diagonal entries of the matrix, to which the first two functions add;
slots are numbers of pairs. Sums are made in the order of triangles and hinges.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from graben.arrays import FloatArray
from graben.compiled import compiled

Indices = NDArray[Any]


@compiled
def add_slopes(
    x: FloatArray, y: FloatArray, triangles: Indices, side_slots: Indices, share: float, pairs: FloatArray
) -> int:
    """Add ``share`` times the matrix of E_D, and return how many triangles have no area or are turned over.

    E_D = 1/2 sum over edges of w_e (u_i - u_j)^2, w_e half the sum of the cotangents of the angles opposite.
    Turned over is what is not oriented as most of the area is. ``triangles``, ``side_slots``: (m, 3).
    """
    whole = 0.0
    for t in range(len(triangles)):
        a, b, c = triangles[t]
        whole += (x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a])
    sign = 1.0 if whole >= 0.0 else -1.0
    unfit = 0
    for t in range(len(triangles)):
        a, b, c = triangles[t]
        a_x, a_y = x[c] - x[b], y[c] - y[b]
        b_x, b_y = x[a] - x[c], y[a] - y[c]
        c_x, c_y = x[b] - x[a], y[b] - y[a]
        doubled = sign * (a_x * b_y - a_y * b_x)
        if not doubled > 0.0:
            unfit += 1
        if share > 0.0:
            # The cotangent of the angle between two sides, both the same way round, is -dot / (2 area).
            factor = 0.5 * share / doubled
            pairs[side_slots[t, 0]] += factor * (b_x * c_x + b_y * c_y)
            pairs[side_slots[t, 1]] += factor * (c_x * a_x + c_y * a_y)
            pairs[side_slots[t, 2]] += factor * (a_x * b_x + a_y * b_y)
    return unfit


@compiled
def add_jumps(
    x: FloatArray,
    y: FloatArray,
    hinges: Indices,
    hinge_slots: Indices,
    scale: float,
    bend: FloatArray,
    pairs: FloatArray,
    load: FloatArray,
) -> None:
    """Add ``scale`` times the matrix of E_H to ``pairs``, and its load of a bent surface to ``load``, (n,).

    With h_k, h_l the distances of k and l from line ij, and d_e the gap between the lines ij and kl where
    they cross, E_H = 1/2 sum of c_e d_e^2, c_e = 3 |e| / (h_k + h_l) ((h_k + h_l) / (h_k h_l))^2. The slope
    across ij in the triangle ijk, times |e|, is cot_i (u_k - u_j) + cot_j (u_k - u_i). So |e| times the jump
    of slope has the coefficients below, and 3 over the sum of the two doubled areas for its weight.

    ``hinges`` (q, 4), ``hinge_slots`` (q, 6); ``bend`` (3, n) holds K_xx, K_xy, K_yy at the nodes, and is
    (3, 0) where nothing is bent. A hinge has the mean K of its edge's two nodes; the load is the jump of
    1/2 P^T K P, spread as it is.
    """
    bent = bend.shape[1] > 0
    for h in range(len(hinges)):
        i, j, k, m = hinges[h]
        e_x, e_y = x[j] - x[i], y[j] - y[i]
        k_x, k_y = x[k] - x[i], y[k] - y[i]
        m_x, m_y = x[m] - x[i], y[m] - y[i]
        area_k, area_m = abs(e_x * k_y - e_y * k_x), abs(e_x * m_y - e_y * m_x)
        squared, along_k, along_m = e_x * e_x + e_y * e_y, e_x * k_x + e_y * k_y, e_x * m_x + e_y * m_y
        i_in_k, j_in_k = along_k / area_k, (squared - along_k) / area_k
        i_in_m, j_in_m = along_m / area_m, (squared - along_m) / area_m
        of_i, of_j, of_k, of_m = -(j_in_k + j_in_m), -(i_in_k + i_in_m), i_in_k + j_in_k, i_in_m + j_in_m
        weight = scale * 3.0 / (area_k + area_m)
        pairs[hinge_slots[h, 0]] += weight * of_i * of_j
        pairs[hinge_slots[h, 1]] += weight * of_i * of_k
        pairs[hinge_slots[h, 2]] += weight * of_j * of_k
        pairs[hinge_slots[h, 3]] += weight * of_i * of_m
        pairs[hinge_slots[h, 4]] += weight * of_j * of_m
        pairs[hinge_slots[h, 5]] += weight * of_k * of_m
        if bent:
            # A jump knows no planes, so that 1/2 P^T K P may be counted from node i.
            xx, xy, yy = (
                (bend[0, i] + bend[0, j]) / 4,
                (bend[1, i] + bend[1, j]) / 2,
                (bend[2, i] + bend[2, j]) / 4,
            )
            pull = of_j * (e_x * (xx * e_x + xy * e_y) + yy * e_y * e_y)
            pull += of_k * (k_x * (xx * k_x + xy * k_y) + yy * k_y * k_y)
            pull += of_m * (m_x * (xx * m_x + xy * m_y) + yy * m_y * m_y)
            pull *= weight
            load[i] += pull * of_i
            load[j] += pull * of_j
            load[k] += pull * of_k
            load[m] += pull * of_m


@compiled
def fill(
    indptr: Indices, pairs_at: Indices, diagonal_at: Indices, pairs: FloatArray, data: FloatArray
) -> None:
    """Write the entries of a symmetric matrix whose columns sum to zero into ``data``, (n + 2 p,).

    ``indptr`` (n + 1,); ``pairs_at`` (2, p) and ``diagonal_at`` (n,) tell where the values stand in it.
    """
    for s in range(len(pairs)):
        data[pairs_at[0, s]] = pairs[s]
        data[pairs_at[1, s]] = pairs[s]
    for column in range(len(diagonal_at)):
        data[diagonal_at[column]] = 0.0
        total = 0.0
        for entry in range(indptr[column], indptr[column + 1]):
            total += data[entry]
        data[diagonal_at[column]] = -total
