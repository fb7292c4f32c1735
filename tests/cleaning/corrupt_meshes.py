"""Corruptions of the mesh: the surface stays where it is, its triangles no longer tell it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.arrays import FloatArray, floats, ints
from graben.proximity import nearest
from tests.cleaning.corrupt_sheets import Corrupted, Made, Sheet

Rng = np.random.Generator

#: Least and greatest share of the triangles that a corruption hits.
SHARE = (0.01, 0.10)
#: Values that stand in files for no value.
_NO_VALUES = (np.nan, np.inf, -np.inf, 1e30)
#: Heights of slivers over their longest side: angles of 0.01 to 0.35 degrees, below the gate's 0.5.
_THIN = (1e-4, 3e-3)


def not_finite(state: Corrupted, sheet: Sheet, rng: Rng) -> Made:
    """Vertices inside lose one or all coordinates; at times a triangle has a vertex that does not exist."""
    inside = np.flatnonzero(sheet.free)
    rows = sheet.apart(rng, inside[:, None], max(1, sheet.some(rng, *SHARE) // 6))
    if not len(rows):
        return None
    chosen = inside[rows]
    vertices = sheet.vertices.copy()
    for v in chosen.tolist():
        axes = slice(None) if rng.random() < 0.5 else rng.integers(3)
        vertices[v, axes] = rng.choice(_NO_VALUES)
    triangles, what = sheet.triangles, f"{len(chosen)} vertices without a finite place"
    if rng.random() < 0.3:
        beyond = len(vertices) + int(rng.integers(1, 50))
        triangles = ints(np.concatenate([triangles, [[*sheet.triangles[0, :2], beyond]]]))
        what += " and a triangle with an index out of range"
    return replace(sheet.surface, vertices=vertices, triangles=triangles), sheet.vertices[chosen], what


def unwelded(state: Corrupted, sheet: Sheet, rng: Rng) -> Made:
    """Triangles get corners of their own; others stand twice, some of them the other way round."""
    count = sheet.some(rng, *SHARE)
    patch = sheet.patch(rng, count) if rng.random() < 0.5 else None
    loose = rng.choice(len(sheet.triangles), count, replace=False) if patch is None else patch
    triangles = sheet.triangles.copy()
    first = len(sheet.vertices)
    triangles[loose] = np.arange(first, first + 3 * len(loose)).reshape(-1, 3)
    copies = sheet.vertices[sheet.triangles[loose].ravel()]
    twice = rng.choice(len(triangles), sheet.some(rng, 0.0, SHARE[1] / 2), replace=False)
    again = np.array([np.roll(t, rng.integers(3)) for t in sheet.triangles[twice]])
    turned = rng.random(len(again)) < 0.25
    again[turned] = again[turned, ::-1]
    surface = replace(
        sheet.surface,
        vertices=np.concatenate([sheet.vertices, copies]),
        triangles=np.concatenate([triangles, again]),
    )
    places = sheet.middles[np.concatenate([loose, twice])]
    return surface, places, f"{len(loose)} triangles with corners of their own, {len(twice)} twice"


def thin(state: Corrupted, sheet: Sheet, rng: Rng) -> Made:
    """Triangles without area, slivers along edges, and needles at their ends; the surface stays the same."""
    edges, pairs = sheet.inner_edges
    rows = sheet.apart(rng, edges, max(2, sheet.some(rng, *SHARE) // 2))
    if len(rows) < 2:
        return None
    flats, needles = rows[::2], rows[1::2]
    kept = np.ones(len(sheet.triangles), dtype=bool)
    points: list[FloatArray] = []
    added: list[list[int]] = []
    for row in flats.tolist():
        a, b, c = _turned(sheet, int(pairs[row, 0]), edges[row])
        p, height = len(sheet.vertices) + len(points), float(np.exp(rng.uniform(*np.log(_THIN))))
        share = rng.uniform(0.3, 0.7)
        on = (1 - share) * sheet.vertices[a] + share * sheet.vertices[b]
        points.append(floats(on if rng.random() < 0.3 else (1 - height) * on + height * sheet.vertices[c]))
        added += [[a, b, p], [b, c, p], [c, a, p]]
        kept[pairs[row, 0]] = False
        if rng.random() < 0.3:
            added.append([a, b, b])
    for row in needles.tolist():
        share = float(np.exp(rng.uniform(*np.log(_THIN))))
        p = len(sheet.vertices) + len(points)
        a, b = edges[row].tolist()
        points.append(floats((1 - share) * sheet.vertices[a] + share * sheet.vertices[b]))
        for t in pairs[row].tolist():
            i, j, k = _turned(sheet, t, edges[row])
            added += [[i, p, k], [p, j, k]]
        kept[pairs[row]] = False
    what = f"{len(flats)} triangles split close to an edge, {len(needles)} edges split close to an end"
    return sheet.grown(floats(points), ints(added), kept), sheet.vertices[edges[rows, 0]], what


def _turned(sheet: Sheet, triangle: int, edge: np.ndarray) -> tuple[int, int, int]:
    """The corners of a triangle in their order, the edge first."""
    corners = sheet.triangles[triangle]
    k = int(np.flatnonzero(~np.isin(corners, edge))[0])
    a, b, c = np.roll(corners, 2 - k).tolist()
    return a, b, c


def hanging(state: Corrupted, sheet: Sheet, rng: Rng) -> Made:
    """Edges are split on one side only, half of them with a crack of up to a hundredth of the edge."""
    edges, pairs = sheet.inner_edges
    rows = sheet.apart(rng, edges, sheet.some(rng, *SHARE))
    if not len(rows):
        return None
    kept = np.ones(len(sheet.triangles), dtype=bool)
    kept[pairs[rows, 0]] = False
    ends = sheet.vertices[edges[rows]]
    share = rng.uniform(0.3, 0.7, (len(rows), 1))
    crack = np.where(rng.random(len(rows)) < 0.5, rng.uniform(-0.01, 0.01, len(rows)), 0.0)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    off = (crack * length)[:, None] * sheet.normals[pairs[rows, 0]]
    points = (1 - share) * ends[:, 0] + share * ends[:, 1] + off
    first = len(sheet.vertices)
    added = []
    for n, row in enumerate(rows.tolist()):
        a, b, c = _turned(sheet, int(pairs[row, 0]), edges[row])
        added += [[a, first + n, c], [first + n, b, c]]
    return sheet.grown(floats(points), ints(added), kept), points, f"{len(rows)} edges split on one side only"


def specks(state: Corrupted, sheet: Sheet, rng: Rng) -> Made:
    """One to four loose bits of one to three triangles beside the fault, clear of other faults."""
    others = [f.surface for f in state.clean.faults if f.name != sheet.surface.name]
    points: list[FloatArray] = []
    added: list[list[int]] = []
    places: list[FloatArray] = []
    inside = np.flatnonzero(sheet.free)
    if not len(inside):
        return None
    for v in rng.permutation(inside)[: rng.integers(1, 5)].tolist():
        side = rng.choice([-1.0, 1.0])
        size = rng.uniform(0.2, 0.8) * sheet.edge
        # half its own size clear of the fault at least
        centre = sheet.vertices[v] + side * (rng.uniform(0.4, 2.0) * sheet.edge + size) * sheet.normal
        if any(nearest(centre[None], o.vertices, o.triangles).distance[0] < 2 * sheet.edge for o in others):
            continue
        frame = np.linalg.svd(sheet.normal[None])[2][1:] + rng.uniform(-0.3, 0.3, (2, 3))
        count = int(rng.integers(1, 4))
        angle = np.cumsum([rng.uniform(0, 6), *rng.uniform(0.8, 1.3, count)])
        ring = centre + size * (np.cos(angle)[:, None] * frame[0] + np.sin(angle)[:, None] * frame[1])
        first = len(sheet.vertices) + len(points)
        points += [floats(centre), *(floats(p) for p in ring)]
        added += [[first, first + 1 + k, first + 2 + k] for k in range(count)]
        places.append(floats(centre))
    if not places:
        return None
    return sheet.grown(floats(points), ints(added)), floats(places), f"{len(places)} specks beside it"


def fins(state: Corrupted, sheet: Sheet, rng: Rng) -> Made:
    """Extra triangles stand on inner edges, others touch the fault with one corner."""
    edges, pairs = sheet.inner_edges
    rows = sheet.apart(rng, edges, max(1, sheet.some(rng, 0.01, 0.05)))
    if not len(rows):
        return None
    points: list[FloatArray] = []
    added: list[list[int]] = []
    for row in rows.tolist():
        (a, b), normal = edges[row].tolist(), sheet.normals[pairs[row, 0]] * rng.choice([-1.0, 1.0])
        ends = sheet.vertices[[a, b]]
        up, along = rng.uniform(0.3, 0.8) * sheet.edge * normal, ends[1] - ends[0]
        first = len(sheet.vertices) + len(points)
        if rng.random() < 0.6:
            points.append(floats(ends[0] + rng.uniform(0.2, 0.8) * along + up))
            added.append([a, b, first])
        else:
            points += [floats(ends[0] + up + 0.3 * along), floats(ends[0] + up - 0.3 * along)]
            added.append([a, first, first + 1])
    what = f"{len(rows)} triangles stand on inner edges or vertices"
    return sheet.grown(floats(points), ints(added)), sheet.vertices[edges[rows, 0]], what


def flipped(state: Corrupted, sheet: Sheet, rng: Rng) -> Made:
    """Triangles are turned over, in a patch or scattered."""
    count = sheet.some(rng, *SHARE)
    patch = sheet.patch(rng, count) if rng.random() < 0.5 else None
    chosen = rng.choice(len(sheet.triangles), count, replace=False) if patch is None else patch
    triangles = sheet.triangles.copy()
    triangles[chosen] = triangles[chosen, ::-1]
    return (
        replace(sheet.surface, triangles=triangles),
        sheet.middles[chosen],
        f"{len(chosen)} triangles turned",
    )


def holes(state: Corrupted, sheet: Sheet, rng: Rng) -> Made:
    """One to three holes of 3 to 30 triangles inside, a tenth of all triangles at most."""
    left = max(3, int(SHARE[1] * len(sheet.triangles)))
    places, counts = [], []
    for _ in range(int(rng.integers(1, 4))):
        patch = sheet.patch(rng, int(rng.integers(3, 31))) if left >= 3 else None
        if patch is None:
            continue
        patch = patch if len(patch) <= left else sheet.patch(rng, left)
        if patch is None:
            continue
        places.append(sheet.middles[patch].mean(axis=0))
        counts.append(len(patch))
        left -= len(patch)
        sheet = Sheet(sheet.without(patch), sheet.branches)
    if not places:
        return None
    return sheet.surface, floats(places), f"holes of {', '.join(map(str, counts))} triangles"
