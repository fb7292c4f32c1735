"""The triangulated surface through fault sticks."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.errors import InputError
from graben.model import UNDEFINED
from graben.surface import Surface, triangle_normals

_SAMPLES = 9  # points on each stick by which the distance between sticks is measured
_MOST_PIECES = 100  # into which one stick is cut, however dense the sticks are
_FLAT = 1e-9  # twice the area over the square of the longest side, below which a triangle is a line


def sticks_surface(name: str, sticks: Sequence[FloatArray]) -> Surface:
    """Return the surface through fault sticks: strips of triangles between neighbouring sticks.

    The sticks may stand in any order and direction. They are put into the order of the shortest way from
    stick to stick; where neighbours cross in the plane of the fault, their ends beyond the crossing are
    exchanged. Each is then cut into pieces about as long as the median distance between neighbours, and
    strips join points at like fractions of the sticks' lengths. Every usable point is a vertex; points
    that are not finite, or no places, are kept as vertices without triangle, so that the check ``finite``
    reports them.

    Parameters
    ----------
    name : str
        Name of the surface.
    sticks : sequence of (k, 3) arrays
        Points along each stick, elevations.

    Raises
    ------
    InputError
        When there are not two different sticks, or all lie in one line.
    """
    everything = np.concatenate([np.zeros((0, 3)), *sticks])
    unfit = everything[~(np.abs(everything) < UNDEFINED).all(axis=1)]
    clean = _cleaned(sticks)
    if len(clean) < 2:
        raise InputError(f"fault {name!r} has fewer than two different sticks; pick more.")
    distances = _distances(clean)
    order = _shortest_path(distances, _along(clean))
    spacing = float(np.median(distances[order[:-1], order[1:]]))
    lines = _uncrossed(_aligned([clean[k] for k in order]))
    vertices, triangles = _strips([_refined(line, spacing) for line in lines])
    if len(triangles) == 0:
        raise InputError(f"the sticks of fault {name!r} lie in one line; pick more.")
    return Surface(name, floats(np.concatenate([vertices, unfit])), triangles)


def _cleaned(sticks: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the sticks without points that repeat or are no places, and without repeated sticks."""
    result: list[FloatArray] = []
    seen: set[bytes] = set()
    for stick in sticks:
        points = stick[(np.abs(stick) < UNDEFINED).all(axis=1)]
        points = points[np.sort(np.unique(points, axis=0, return_index=True)[1])]
        key = np.unique(points, axis=0).tobytes()
        if len(points) and key not in seen:
            seen.add(key)
            result.append(points)
    return result


def _fractions(line: FloatArray) -> FloatArray:
    """Return the share of the length at each point of a line, shape (k,); 1/2 for a single point."""
    if len(line) == 1:
        return floats([0.5])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    return floats(length / length[-1])


def _at(line: FloatArray, fractions: FloatArray) -> FloatArray:
    """Return the points at given shares of the length of a line."""
    own = _fractions(line)
    return floats(np.stack([np.interp(fractions, own, line[:, k]) for k in range(3)], axis=1))


def _distances(sticks: Sequence[FloatArray]) -> FloatArray:
    """Return the distance of each pair of sticks, shape (n, n): mean distance to the nearest sample."""
    shares = floats(np.linspace(0.0, 1.0, _SAMPLES))
    samples = np.stack([_at(stick, shares) for stick in sticks])
    oneway = np.empty((len(sticks), len(sticks)))
    for k, own in enumerate(samples):
        apart = np.linalg.norm(own[None, :, None, :] - samples[:, None, :, :], axis=-1)
        oneway[k] = apart.min(axis=2).mean(axis=1)
    return floats((oneway + oneway.T) / 2)


def _along(sticks: Sequence[FloatArray]) -> FloatArray:
    """Return the place of each stick along the fault: the main axis of the middles, across the sticks."""
    ends = np.stack([stick[-1] - stick[0] for stick in sticks])
    direction = np.linalg.svd(ends)[2][0]
    middles = np.stack([stick.mean(axis=0) for stick in sticks])
    middles = middles - middles.mean(axis=0)
    across = middles - np.outer(middles @ direction, direction)
    return floats(across @ np.linalg.svd(across)[2][0])


def _shortest_path(distances: FloatArray, start: FloatArray) -> IntArray:
    """Return an order of the sticks that no reversal of a part makes shorter (2-opt)."""
    order = np.argsort(start, kind="stable")
    n = len(order)
    improved = True
    while improved:
        improved = False
        for i in range(n - 1):
            # Turning round order[i : j + 1] replaces the steps into i and out of j; at the ends of the path
            # there is only one of them.
            j = np.arange(i + 1, n)
            before = distances[order[i - 1], order[i]] if i else 0.0
            entered = distances[order[i - 1], order[j]] if i else np.zeros(len(j))
            following = order[np.minimum(j + 1, n - 1)]
            inside = j + 1 < n
            after = np.where(inside, distances[order[j], following], 0.0)
            left = np.where(inside, distances[order[i], following], 0.0)
            gain = before + after - entered - left
            best = int(np.argmax(gain))
            if gain[best] > _FLAT * distances.max():
                stop = int(j[best]) + 1
                order[i:stop] = order[i:stop][::-1].copy()
                improved = True
    return ints(order)


def _aligned(sticks: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the sticks, all in one direction: the first downwards, each next as its neighbour."""
    first = sticks[0]
    result = [first[::-1] if first[0, 2] < first[-1, 2] else first]
    for stick in sticks[1:]:
        last = result[-1]
        same = np.linalg.norm(stick[0] - last[0]) + np.linalg.norm(stick[-1] - last[-1])
        turned = np.linalg.norm(stick[-1] - last[0]) + np.linalg.norm(stick[0] - last[-1])
        result.append(stick if same <= turned else stick[::-1])
    return result


def _uncrossed(sticks: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the sticks with their ends exchanged beyond the place where neighbours cross.

    An exchange shortens the two lines in the plane in which they cross, so the sweeps come to an end.
    """
    lines = list(sticks)
    for _ in range(len(lines)):
        changed = False
        for k in range(len(lines) - 1):
            a, b = lines[k], lines[k + 1]
            place = _crossing(a, b)
            if place is not None:
                i, j = place
                lines[k] = floats(np.concatenate([a[: i + 1], b[j + 1 :]]))
                lines[k + 1] = floats(np.concatenate([b[: j + 1], a[i + 1 :]]))
                changed = True
        if not changed:
            break
    return lines


def _crossing(a: FloatArray, b: FloatArray) -> tuple[int, int] | None:
    """Return the first segments of two lines that properly cross in the lines' common plane, if any do."""
    together = np.concatenate([a, b])
    middle = together.mean(axis=0)
    plane = np.linalg.svd(together - middle, full_matrices=False)[2][:2]
    p, q = (a - middle) @ plane.T, (b - middle) @ plane.T

    def side(one: FloatArray, other: FloatArray, third: FloatArray) -> FloatArray:
        u, v = other - one, third - one
        return np.sign(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])

    p0, p1, q0, q1 = p[:-1, None], p[1:, None], q[None, :-1], q[None, 1:]
    cross = (side(p0, p1, q0) * side(p0, p1, q1) < 0) & (side(q0, q1, p0) * side(q0, q1, p1) < 0)
    found = np.argwhere(cross)
    return (int(found[0, 0]), int(found[0, 1])) if len(found) else None


def _refined(line: FloatArray, spacing: float) -> FloatArray:
    """Return a line with points added so that its pieces are about as long as ``spacing``."""
    if len(line) == 1:
        return line
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    spacing = max(spacing, float(lengths.sum()) / _MOST_PIECES)
    parts = []
    for start, stop, length in zip(line[:-1], line[1:], lengths, strict=True):
        count = max(1, round(length / spacing))
        t = np.arange(count)[:, None] / count
        parts.append(start + t * (stop - start))
    return floats(np.concatenate([*parts, line[-1:]]))


def _strips(lines: Sequence[FloatArray]) -> tuple[FloatArray, IntArray]:
    """Return vertices and triangles of the strips between successive lines; points in one place are one."""
    starts = np.cumsum([0, *(len(line) for line in lines)])
    strips = []
    for k, (a, b) in enumerate(pairwise(lines)):
        corners = _strip(_fractions(a), _fractions(b))
        strips.append(np.where(corners < len(a), corners + starts[k], corners - len(a) + starts[k + 1]))
    points, where = np.unique(np.concatenate(lines), axis=0, return_inverse=True)
    triangles = where.ravel()[np.concatenate(strips)]
    a, b, c = (points[triangles[:, k]] for k in range(3))
    longest = np.max([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    normals = triangle_normals(points, triangles)
    triangles = triangles[np.linalg.norm(normals, axis=1) > _FLAT * longest]
    if normals[:, 2].sum() < 0:
        triangles = triangles[:, ::-1]
    used, numbers = np.unique(triangles, return_inverse=True)
    return floats(points[used]), ints(numbers, -1, 3)


def _strip(left: FloatArray, right: FloatArray) -> IntArray:
    """Return the triangles between two lines, given the shares of length at their points.

    Indices count the left line's points, then the right line's. From the pair of points reached, the step is
    taken on the side whose next piece has its middle first.
    """
    p, q = len(left), len(right)
    down_left, down_right = (left[:-1] + left[1:]) / 2, (right[:-1] + right[1:]) / 2
    # All steps in the order of their middles; the left step comes first where they are level.
    middles = np.concatenate([down_left, down_right])
    sides = np.concatenate([np.zeros(p - 1, dtype=np.int64), np.ones(q - 1, dtype=np.int64)])
    sides = sides[np.lexsort((sides, middles))]
    j = np.cumsum(sides) - sides
    i = np.arange(len(sides)) - j
    third = np.where(sides == 0, i + 1, p + j + 1)
    return ints(np.stack([i, third, p + j], axis=1), -1, 3)
