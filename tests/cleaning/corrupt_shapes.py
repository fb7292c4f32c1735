"""Corruptions of the shape: a fault is cut through, crosses itself, turns over, or has summits and pits."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.proximity import nearest
from graben.surface import Surface, strong_components, triangle_areas, triangle_normals
from tests.cleaning.corrupt_meshes import SHARE
from tests.cleaning.corrupt_sheets import AWAY, Corrupted, Made, Sheet

Rng = np.random.Generator

#: Share of a fault's area in an overturned patch.
OVERTURNED = (0.01, 0.05)
_TRIES = 25  # places looked at on a fault
_SKEW = 30.0  # degrees between a cut through a fault and its dip direction, at most
_HALF = 0.15  # a fault that is cut through keeps such a share of its area on either side at least
_INVERTS = 0.3  # share of an edge up to which moving one of its ends turns no triangle over


def parted(state: Corrupted, sheet: Sheet, rng: Rng) -> Made:
    """A fault is cut through from rim to rim: a strip is missing, or the halves are drawn apart."""
    fault = next(f for f in state.clean.faults if f.name == sheet.surface.name)
    widest, areas = state.clean.max_extension(fault), triangle_areas(sheet.vertices, sheet.triangles)
    strike = np.array([-sheet.downdip[1], sheet.downdip[0], 0.0])
    held = np.zeros(len(sheet.vertices), dtype=bool)
    if len(sheet.branches):
        held = cKDTree(sheet.branches).query(sheet.vertices)[0] < AWAY * sheet.edge
    for v in rng.choice(len(sheet.vertices), _TRIES).tolist():
        turn = np.radians(rng.uniform(-_SKEW, _SKEW))
        normal = np.cos(turn) * strike + np.sin(turn) * sheet.downdip
        across = ((sheet.vertices - sheet.vertices[v]) @ normal)[sheet.triangles]
        side = across.mean(axis=1) > 0
        share = areas[side].sum() / areas.sum()
        near = np.abs(across).min(axis=1) < AWAY * sheet.edge
        if not _HALF < share < 1 - _HALF or held[sheet.triangles[near]].any():
            continue
        if rng.random() < 0.5:
            width = rng.uniform(0.0, 0.2 * widest)
            strip = (across.min(axis=1) < width / 2) & (across.max(axis=1) > -width / 2)
            if np.ptp(across[strip]) > widest:
                continue
            made, what = sheet.without(strip), f"a strip of {int(strip.sum())} triangles missing"
        else:
            width = rng.uniform(0.1, 1.0) * min(state.limit(fault.name), _INVERTS * sheet.edge)
            made = _drawn_apart(sheet, side, floats(width * strike))
            what = f"cut through and drawn apart by {2 * width:.0f} m"
        if strong_components(made.triangles).max() == 1:
            return made, floats(sheet.vertices[v]), what
    return None


def _drawn_apart(sheet: Sheet, side: BoolArray, move: FloatArray) -> Surface:
    """The surface unwelded between its two sides, the seam of each moved away from the other."""
    seam = np.intersect1d(sheet.triangles[side], sheet.triangles[~side])
    triangles = sheet.triangles.copy()
    copy = np.arange(len(sheet.vertices))
    copy[seam] = len(sheet.vertices) + np.arange(len(seam))
    triangles[side] = copy[triangles[side]]
    vertices = np.concatenate([sheet.vertices, sheet.vertices[seam] + move])
    vertices[seam] -= move
    return replace(sheet.surface, vertices=vertices, triangles=triangles)


def flaps(state: Corrupted, sheet: Sheet, rng: Rng) -> Made:
    """A second sheet passes through the fault, which goes on below it: a flap or a turned copy of a patch."""
    if rng.random() < 1 / 3:
        return _turned_copy(sheet, rng)
    edges, pairs = sheet.inner_edges
    rows = sheet.apart(rng, edges, int(rng.integers(1, 4)))
    points: list[FloatArray] = []
    added: list[list[int]] = []
    for row in rows.tolist():
        (a, b), normal = edges[row].tolist(), sheet.normals[pairs[row, 0]] * rng.choice([-1.0, 1.0])
        ends = sheet.vertices[[a, b]]
        way = np.cross(normal, ends[1] - ends[0])
        way, height = way / np.linalg.norm(way), rng.uniform(0.15, 0.4) * sheet.edge
        steps = [0.5 * sheet.edge * way + height * normal, 1.3 * sheet.edge * way - height * normal]
        rows_of = [[a, b]]
        if rng.random() < 0.5:
            steps = [0.2 * sheet.edge * way + 1.2 * height * normal, *steps]
            rows_of = []
        for step in steps:
            first = len(sheet.vertices) + len(points)
            points += [floats(p + step) for p in ends]
            rows_of.append([first, first + 1])
        for (i, j), (k, m) in pairwise(rows_of):
            added += [[i, j, m], [i, m, k]]
    if not added:
        return None
    return sheet.grown(floats(points), ints(added)), sheet.vertices[edges[rows, 0]], f"{len(rows)} flaps"


def _turned_copy(sheet: Sheet, rng: Rng) -> Made:
    patch = sheet.patch(rng, int(rng.integers(6, 15)))
    if patch is None:
        return None
    used, local = np.unique(sheet.triangles[patch], return_inverse=True)
    middle = sheet.vertices[used].mean(axis=0)
    frame = np.linalg.svd(sheet.normals[patch].mean(axis=0)[None])[2][1:]
    turn = rng.uniform(0, 2 * np.pi)
    axis = np.cos(turn) * frame[0] + np.sin(turn) * frame[1]
    a = np.radians(rng.uniform(15, 40))
    off = sheet.vertices[used] - middle
    along = (off @ axis)[:, None] * axis
    points = middle + along + np.cos(a) * (off - along) + np.sin(a) * np.cross(axis, off)
    triangles = local.reshape(-1, 3) + len(sheet.vertices)
    what = f"a copy of {len(patch)} triangles turned by {np.degrees(a):.0f} degrees"
    return sheet.grown(floats(points), ints(triangles)), middle, what


def overturned(state: Corrupted, sheet: Sheet, rng: Rng) -> Made:
    """A patch is overturned: what lies higher is pushed down dip, what lies lower back."""
    limit, areas = state.limit(sheet.surface.name), triangle_areas(sheet.vertices, sheet.triangles)
    strike = np.array([-sheet.downdip[1], sheet.downdip[0], 0.0])
    if not len(sheet.open):
        return None
    wanted = rng.uniform(*OVERTURNED) * areas.sum()
    for t in rng.choice(sheet.open, _TRIES).tolist():
        corners = sheet.vertices[sheet.triangles[t]]
        row = np.ptp(corners[:, 2])
        width = row / np.tan(np.arccos(sheet.normals[t] @ sheet.normal * abs(sheet.normal[2])))
        level = (sheet.vertices[:, 2] - corners[:, 2].mean() - _off_centre(corners[:, 2])) / row
        along = np.abs((sheet.vertices - corners.mean(axis=0)) @ strike)
        half = wanted / (row / np.sqrt(1 - sheet.normal[2] ** 2)) / 2
        share = np.clip(1 - (along - half) / (1.2 * sheet.edge), 0, 1)
        share *= np.sign(level) * np.clip(1 - (np.abs(level) - 0.5) / 2, 0, 1) * sheet.free
        push = 0.5 * width * rng.uniform(1.3, 1.7)
        moved = replace(sheet.surface, vertices=sheet.vertices + push * share[:, None] * sheet.downdip)
        turned = turned_over(moved, sheet)
        if (
            OVERTURNED[0] <= areas[turned].sum() / areas.sum() <= OVERTURNED[1]
            and _apart(sheet.surface, moved) < limit
        ):
            what = (
                f"{len(turned)} triangles overturned, {100 * areas[turned].sum() / areas.sum():.1f} % of it"
            )
            return moved, sheet.middles[turned], what
    return None


def _off_centre(heights: FloatArray) -> float:
    """How far the middle of a triangle's heights lies above their mean."""
    return float(0.5 * (heights.min() + heights.max()) - heights.mean())


def turned_over(surface: Surface, clean: Sheet) -> IntArray:
    """The triangles of a surface that face the other way in plan than the clean one's."""
    before = triangle_normals(clean.vertices, clean.triangles)[:, 2]
    after = triangle_normals(surface.vertices, surface.triangles)[:, 2]
    return np.flatnonzero(before * after < 0)


def _apart(clean: Surface, moved: Surface) -> float:
    """The largest distance of a vertex of either surface that was moved from the other surface."""
    changed = (clean.vertices != moved.vertices).any(axis=1)
    there = nearest(clean.vertices[changed], moved.vertices, moved.triangles).distance
    back = nearest(moved.vertices[changed], clean.vertices, clean.triangles).distance
    return float(max(there.max(initial=0.0), back.max(initial=0.0)))


def bumps(state: Corrupted, sheet: Sheet, rng: Rng) -> Made:
    """Vertices become summits or pits, or triangles level, by moves along the vertical."""
    limit = state.limit(sheet.surface.name)
    count = max(1, sheet.some(rng, *SHARE) // 6)
    z, taken = sheet.vertices[:, 2].copy(), ~sheet.free
    places: list[FloatArray] = []
    for v in rng.permutation(np.flatnonzero(sheet.free)).tolist():
        if len(places) == count:
            break
        star = sheet.triangles[(sheet.triangles == v).any(axis=1)]
        ring = np.setdiff1d(star, [v])
        if taken[ring].any() or taken[v]:
            continue
        if rng.random() < 1 / 3:
            some = star[rng.integers(len(star))]
            move = z[some].mean() - z[some]
        else:
            sign = rng.choice([-1.0, 1.0])  # of a pit's way down
            beyond = ring[sign * (z[ring] - z[v]) > 0.35 * np.abs(z[ring] - z[v]).max()]
            if not len(beyond):
                continue
            some = np.append(beyond, v)
            half = 0.5 * np.abs(z[beyond] - z[v]).max() * rng.uniform(1.03, 1.15)
            move = half * sign * np.append(-np.ones(len(beyond)), 1.0)
        if np.abs(move).max() * abs(sheet.normal[2]) > 0.9 * limit:
            continue
        z[some] += move
        if len(set(z[some].tolist())) < len(some) == 3 and np.ptp(z[some]) < 1e-6:
            z[some] = z[some[0]]
        taken[star.ravel()] = True
        places.append(sheet.vertices[v])
    if not places:
        return None
    moved = replace(sheet.surface, vertices=np.column_stack([sheet.vertices[:, :2], z]))
    if _apart(sheet.surface, moved) > limit:
        return None
    return moved, floats(places), f"{len(places)} summits, pits or level triangles"
