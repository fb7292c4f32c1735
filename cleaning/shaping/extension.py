"""A fault extended beyond a stretch of its rim, along its own trend."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.cleaning.shaping.rim_chains import Ways, directed_chain, ways_on
from graben.cleaning.shaping.trend import Trend, trend
from graben.errors import GrabenError
from graben.proximity import nearest
from graben.surface import Surface, triangle_dips, triangle_normals
from graben.validators.measuring.rim_lines import unit

#: The trend is taken from within so many edges, backwards from within the length of the extension if larger.
_WINDOW = 2.5
#: Ways that directions are smoothed and the curve is bent, tried in this order until nothing folds or lies
#: flat: the window over the first one, and the share of the curvature.
_TRIES = ((1.0, 1.0), (1.0, 0.5), (2.0, 0.5), (2.0, 0.0), (4.0, 0.0))
#: A length below this share of the edge is none.
_NOTHING = 1e-6
#: Edges along a row longer than so many target lengths are halved; shorter than the second are joined.
_LONG, _SHORT = 1.6, 0.55
#: Least cosine between the normal of a new triangle and that of the fault at the rim it grew from.
_UNFOLDED = 0.3
#: A new triangle that dips less than this share of the flattest one of the fault continues its roughness, not
#: its course. A listric fault turns by less than that within the length of an extension.
_FLAT = 0.5
#: New vertices keep at least this share of the edge from the old triangles they do not belong to.
_APART = 1e-3

#: The place at an arc length along the rim and a distance beyond it.
_Place = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Extension:
    """An extended fault.

    Parameters
    ----------
    surface : Surface
        The fault, its own vertices and triangles first and as they were.
    patch : Surface
        What was added, as a surface of its own.
    triangles : (t,) array
        The triangles of ``surface`` that were added.
    front : (k,) array
        Its vertices along what is the rim of the fault there now.
    length : float
        The greatest length, model units.
    folded : int
        How many of them fold over, or lie on the fault itself; a sound extension has none.
    flat : int
        How many dip less than half of what the flattest triangle of the fault does.
    """

    surface: Surface
    patch: Surface
    triangles: IntArray
    front: IntArray
    length: float
    folded: int = 0
    flat: int = 0


def extended(
    surface: Surface,
    rim: IntArray,
    length: FloatArray | float,
    edge: float | None = None,
    *,
    straight: bool = False,
) -> Extension:
    """Return a fault extended beyond a stretch of its rim.

    It goes on in its own tangent plane, square to the rim, and bends as it bends near the rim, ever less.
    Where the stretch ends at a corner of the fault, the side of the extension goes on along the fault's side.

    Parameters
    ----------
    surface : Surface
        The fault, its triangles turned one way along the rim.
    rim : (k,) array
        Vertices along the rim, in either direction; first = last for a whole rim.
    length : (k,) array or float
        How far to go from each, model units; where it is 0 the rim stays.
    edge : float, optional
        Length of the new edges, model units; the median along the stretch where not given.
    straight : bool
        Whether to go on square to the chord of the stretch, whatever notches it has.

    Returns
    -------
    Extension
        ``folded`` says whether it may be used.

    Raises
    ------
    GrabenError
        If the vertices are no stretch of the rim.
    """
    chain, reverse = directed_chain(surface, rim)
    given = np.broadcast_to(np.asarray(length, dtype=np.float64), (len(chain),))
    far = np.maximum(given[::-1] if reverse else given, 0.0)
    sizes = np.linalg.norm(np.diff(surface.vertices[chain], axis=0), axis=1)
    h = edge or _weighted_median(sizes)
    if not h > 0:
        raise GrabenError(f"{surface.name}: the stretch of the rim has no length.")
    far = np.where(far > _NOTHING * h, far, 0.0)
    if chain[0] == chain[-1]:
        far[[0, -1]] = far[[0, -1]].max()
    if not far.any():
        nothing = replace(surface, vertices=floats([], 0, 3), triangles=ints([], 0, 3), lines=ints([]))
        return Extension(surface, nothing, ints([]), ints([]), 0.0)
    best: Extension | None = None
    for smooth, bend in _TRIES:
        made = _grown(surface, chain, floats(far), h, smooth, bend, straight)
        if best is None or (made.folded, made.flat) < (best.folded, best.flat):
            best = made
        if made.folded == made.flat == 0:
            break
    assert best is not None
    return best


def _weighted_median(sizes: FloatArray) -> float:
    """Return the length that half of the rim has edges no longer than."""
    order = np.argsort(sizes, kind="stable")
    total = np.cumsum(sizes[order])
    return float(sizes[order][np.searchsorted(total, 0.5 * total[-1])])


def _grown(
    surface: Surface,
    chain: IntArray,
    far: FloatArray,
    h: float,
    smooth: float,
    bend: float,
    straight: bool,
) -> Extension:
    """Return the extension with one choice of smoothing and bending."""
    reach = max(h, surface.median_edge)
    ways = ways_on(surface, chain, far, smooth * 2.0 * reach, straight)
    curves = trend(surface, chain, ways, floats(np.maximum(_WINDOW * reach, far)), _WINDOW * reach, bend)
    points = surface.vertices[chain]
    s = floats(np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]))
    fixed = floats(s[ways.corner])
    vertices, triangles, front = _rows(surface, chain, s, far, h, _placed(curves, s), fixed)
    whole = replace(
        surface,
        vertices=np.concatenate([surface.vertices, vertices]),
        triangles=np.concatenate([surface.triangles, triangles]),
        lines=np.concatenate([surface.lines, np.zeros(len(triangles), dtype=np.int64)])
        if len(surface.lines)
        else surface.lines,
    )
    used, corners = np.unique(triangles, return_inverse=True)
    patch = Surface(surface.name, whole.vertices[used], ints(corners.reshape(-1, 3)))
    new = ints(np.arange(len(surface.triangles), len(whole.triangles)))
    folded = _folded(surface, whole, triangles, chain, ways, h)
    least = _FLAT * float(triangle_dips(surface.vertices, surface.triangles).min())
    flat = int((triangle_dips(whole.vertices, triangles) < least).sum())
    return Extension(whole, patch, new, front, float(far.max()), folded, flat)


def _placed(curves: Trend, s: FloatArray) -> _Place:
    """Return the function from arc length along the rim and distance beyond it to the place."""

    def place(along: FloatArray, far: FloatArray) -> FloatArray:
        k = np.clip(np.searchsorted(s, along, side="right") - 1, 0, len(s) - 2)
        share = ((along - s[k]) / (s[k + 1] - s[k]))[:, None]
        return floats((1 - share) * curves.at(k, far) + share * curves.at(k + 1, far))

    return place


def _rows(
    surface: Surface,
    chain: IntArray,
    s: FloatArray,
    far: FloatArray,
    h: float,
    place: _Place,
    fixed: FloatArray,
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the new vertices and triangles, row by row away from the rim, and the vertices of the last."""
    height = float(far.max()) / max(1, round(float(far.max()) / h))
    index, along, at = chain, s, surface.vertices[chain]
    added: list[FloatArray] = []
    strips: list[IntArray] = []
    count = len(surface.vertices)
    ring = bool(chain[0] == chain[-1])
    for row in range(1, max(1, round(float(far.max()) / height)) + 1):
        risen = partial(_risen, place, s, far, height, row)
        local = np.interp(along, s, far)
        active = (local > 0) & (np.maximum(np.rint(local / height), 1) >= row)
        runs = np.split(np.arange(len(along)), np.flatnonzero(active[1:] != active[:-1]) + 1)
        fronts: list[tuple[IntArray, FloatArray, FloatArray]] = []
        for run in runs:
            if not active[run[0]]:
                fronts.append((index[run], along[run], at[run]))
                continue
            new_along = _resampled(along[run], risen, h, fixed)
            new_at = risen(new_along)
            whole = ring and len(run) == len(along)
            new = count + np.arange(len(new_along))
            if whole:
                new[-1], new_at = new[0], np.concatenate([new_at[:-1], new_at[:1]])
            count += len(new) - int(whole)
            added.append(new_at[:-1] if whole else new_at)
            fronts.append((ints(new), new_along, new_at))
            around = np.arange(max(run[0] - 1, 0), min(run[-1] + 2, len(along)))
            left, right = around[around < run[0]], around[around > run[-1]]
            upper = np.concatenate([index[left], new, index[right]])
            upper_at = np.concatenate([at[left], new_at, at[right]])
            strips.append(_strip(index[around], at[around], upper, upper_at))
        index = ints(np.concatenate([f[0] for f in fronts]))
        along = floats(np.concatenate([f[1] for f in fronts]))
        at = floats(np.concatenate([f[2] for f in fronts]))
    return floats(np.concatenate(added)), ints(np.concatenate(strips)), index


def _risen(
    place: _Place, s: FloatArray, far: FloatArray, height: float, row: int, along: FloatArray
) -> FloatArray:
    """Return the places of a row at arc lengths: whole rows apart, the last one as far as there is to go."""
    local = np.interp(along, s, far)
    whole = np.maximum(np.rint(local / height), 1) > row
    return place(along, np.where(whole, row * height, local))


def _resampled(
    along: FloatArray, place: Callable[[FloatArray], FloatArray], h: float, fixed: FloatArray
) -> FloatArray:
    """Return the arc lengths of the nodes of a row: the last row's, long edges divided, short ones joined."""
    at = place(along)
    held = np.isin(along, fixed)
    keep = [0]
    for k in range(1, len(along)):
        short = np.linalg.norm(at[k] - at[keep[-1]]) < _SHORT * h
        last = k == len(along) - 1
        if short and (last or held[k]) and len(keep) > 1 and not held[keep[-1]]:
            keep[-1] = k
        elif not short or last or held[k]:
            keep.append(k)
    along, at = along[keep], at[keep]
    sizes = np.linalg.norm(np.diff(at, axis=0), axis=1)
    parts = ints(np.maximum(np.ceil(sizes / (_LONG * h)), 1))
    if len(parts) == 0 or parts.max() == 1:
        return floats(along)
    cell = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(cell)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[cell]
    return floats(np.append(along[cell] + share * (along[cell + 1] - along[cell]), along[-1]))


def _strip(lower: IntArray, lower_at: FloatArray, upper: IntArray, upper_at: FloatArray) -> IntArray:
    """Return the triangles between two rows of vertices, by the shorter diagonals.

    The lower row runs as the triangles before it turn. Where the rows share an end there is no triangle.
    """
    i = j = 0
    found = []
    while i < len(lower) - 1 or j < len(upper) - 1:
        if i == len(lower) - 1:
            ahead = False
        elif j == len(upper) - 1:
            ahead = True
        else:
            along = np.linalg.norm(lower_at[i + 1] - upper_at[j])
            ahead = bool(along <= np.linalg.norm(lower_at[i] - upper_at[j + 1]) * (1 + 1e-6))
        if ahead:
            found.append((lower[i + 1], lower[i], upper[j]))
            i += 1
        else:
            found.append((lower[i], upper[j], upper[j + 1]))
            j += 1
    made = np.array(found, dtype=np.int64)
    distinct = (made[:, 0] != made[:, 1]) & (made[:, 1] != made[:, 2]) & (made[:, 2] != made[:, 0])
    return ints(made[distinct])


def _folded(old: Surface, whole: Surface, triangles: IntArray, chain: IntArray, ways: Ways, h: float) -> int:
    """Return how many new triangles turn away from the fault, in space or where it has none such in plan."""
    normals = unit(triangle_normals(whole.vertices, triangles))
    middles = whole.vertices[triangles].mean(axis=1)
    links = ints(np.stack([np.arange(len(chain) - 1), np.arange(1, len(chain))], axis=1))
    by = links[nearest(middles, old.vertices[chain], links).simplex].min(axis=1)
    bad: BoolArray = np.einsum("ij,ij->i", normals, ways.normal[by]) < _UNFOLDED
    up = triangle_normals(old.vertices, old.triangles)[:, 2]
    if (up > 0).all() or (up < 0).all():
        bad |= normals[:, 2] * np.sign(up[0]) <= 0
    fresh = np.arange(len(old.vertices), len(whole.vertices))
    gap = nearest(whole.vertices[fresh], old.vertices, old.triangles).distance
    touching = fresh[gap < _APART * h]
    return int((bad | np.isin(triangles, touching).any(axis=1)).sum())
