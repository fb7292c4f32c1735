"""The sheets that part a prism into blocks: its surface, and the faults inside without their loose ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import igl
import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.prism import Prism
from graben.refinement import component_labels, refined
from graben.surface import Surface, edge_sharing, edge_table, triangle_areas

#: Winding number of the prism above which a point lies inside: halfway from 0, outside, to 1, inside.
_INSIDE = 0.5
#: Share of the largest coordinate, and of the size, within which places are one: what rounding leaves of
#: one place of exact arithmetic. It is far below the share to which the volumes have to add up.
_ONE_PLACE = 1e-14, 1e-12


@dataclass(frozen=True, eq=False)
class Sheets:
    """Triangles of the faults and the prism as one complex; ``owner`` counts the faults, then the prism."""

    vertices: FloatArray
    triangles: IntArray
    owner: IntArray
    prism: int

    def only(self, kept: BoolArray | IntArray) -> Sheets:
        """Return the triangles that are kept."""
        return Sheets(self.vertices, self.triangles[kept], self.owner[kept], self.prism)


def parting_sheets(whole: Prism, faults: Sequence[Surface]) -> Sheets:
    """Return the sheets, each triangle once: where a fault lies on the prism, the prism holds."""
    shape = refined([*_without_flat_triangles(faults), whole.surface])
    sheets = _cleared(Sheets(shape.vertices, shape.triangles, shape.owner, len(faults)))
    return _without_loose_ends(_inside(sheets, whole))


def _without_flat_triangles(faults: Sequence[Surface]) -> list[Surface]:
    """Return the faults cleared together: exact refinement passes flat triangles over, uncut."""
    if not any(len(f.triangles) for f in faults):
        return list(faults)
    starts = np.cumsum([0] + [len(f.vertices) for f in faults])
    triangles = [f.triangles + start for f, start in zip(faults, starts, strict=False)]
    owner = np.repeat(np.arange(len(faults)), [len(f.triangles) for f in faults])
    vertices = np.concatenate([f.vertices for f in faults])
    sheets = _cleared(Sheets(vertices, np.concatenate(triangles), owner, len(faults)))
    return [Surface(f.name, vertices, sheets.triangles[sheets.owner == k]) for k, f in enumerate(faults)]


def _cleared(sheets: Sheets) -> Sheets:
    """Return the sheets without what rounding made of exact intersections: double places and flat triangles.

    Where the sides of a flat triangle lie upon each other, the longest is parted at the corner beside it in
    all its triangles, so that the sheets stay joined as they are.
    """
    share, part = _ONE_PLACE
    size = float(np.linalg.norm(np.ptp(sheets.vertices[sheets.triangles].reshape(-1, 3), axis=0)))
    near = max(share * float(np.abs(sheets.vertices).max()), part * size)
    sheets = _once(_joined(sheets, near))
    while len(flat := _flat(sheets, near)):
        sheets = _once(_opened(sheets, flat))
    return sheets


def _joined(sheets: Sheets, near: float) -> Sheets:
    """Let vertices within ``near`` be one: that of the prism, if there is one."""
    of_prism = np.zeros(len(sheets.vertices), dtype=bool)
    of_prism[sheets.triangles[sheets.owner == sheets.prism]] = True
    pairs = cKDTree(sheets.vertices).query_pairs(near, output_type="ndarray")
    group = component_labels(len(sheets.vertices), pairs.astype(np.int64))
    first = np.zeros(int(group.max(initial=-1)) + 1, dtype=np.int64)
    order = np.argsort(of_prism, kind="stable")
    first[group[order]] = order
    return Sheets(sheets.vertices, first[group][sheets.triangles], sheets.owner, sheets.prism)


def _once(sheets: Sheets) -> Sheets:
    """Leave out triangles with a corner twice, and all but one of those with the same corners."""
    a, b, c = sheets.triangles.T
    sheets = sheets.only((a != b) & (b != c) & (c != a))
    rank = np.where(sheets.owner == sheets.prism, -1, sheets.owner)
    order = np.argsort(rank, kind="stable")
    first = np.unique(np.sort(sheets.triangles[order], axis=1), axis=0, return_index=True)[1]
    return sheets.only(np.sort(order[first]))


def _flat(sheets: Sheets, near: float) -> IntArray:
    """Return the triangles nowhere wider than ``near``, and the corner opposite the longest side: (f, 2)."""
    corners = sheets.vertices[sheets.triangles]
    lengths = np.linalg.norm(np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1), axis=2)
    height = 2.0 * triangle_areas(sheets.vertices, sheets.triangles) / lengths.max(axis=1)
    flat = np.flatnonzero(height <= near)
    return np.stack([flat, lengths[flat].argmax(axis=1)], axis=1)


def _opened(sheets: Sheets, flat: IntArray) -> Sheets:
    """Part the longest sides of flat triangles (f, 2) at the corners beside them, one for each triangle."""
    _, sides = edge_table(sheets.triangles)
    order = np.argsort(sides.ravel(), kind="stable")
    ordered = sides.ravel()[order]
    touched: set[int] = set()
    made, owner = [], []
    for t, k in flat.tolist():
        low, high = np.searchsorted(ordered, [sides[t, k], sides[t, k] + 1])
        around = [divmod(side, 3) for side in order[low:high].tolist()]
        if touched.intersection(s for s, _ in around):
            continue
        touched.update(s for s, _ in around)
        for s, j in around:
            for gone in ((j + 1) % 3, (j + 2) % 3):
                corners = sheets.triangles[s].copy()
                corners[gone] = sheets.triangles[t, k]
                made.append(corners)
                owner.append(sheets.owner[s])
    kept = np.setdiff1d(np.arange(len(sheets.triangles)), list(touched))
    return Sheets(
        sheets.vertices,
        np.concatenate([sheets.triangles[kept], np.array(made)]),
        np.concatenate([sheets.owner[kept], np.array(owner)]),
        sheets.prism,
    )


def _patches(sheets: Sheets) -> tuple[IntArray, BoolArray]:
    """Return the patch of each triangle, (m,), and which patches of faults have an edge of their own.

    Two triangles of faults are in one patch where they share an edge that no third one has.
    """
    edges, sides = edge_table(sheets.triangles)
    share = edge_sharing(sides, len(edges))
    fault = np.repeat(sheets.owner != sheets.prism, 3)
    inner = np.flatnonzero((share[sides.ravel()] == 2) & fault)
    inner = inner[np.argsort(sides.ravel()[inner], kind="stable")]
    edge, triangle = sides.ravel()[inner], inner // 3
    same = np.flatnonzero(edge[1:] == edge[:-1])
    patch = component_labels(len(sheets.triangles), np.stack([triangle[same], triangle[same + 1]], axis=1))
    loose = np.zeros(int(patch.max(initial=-1)) + 1, dtype=bool)
    loose[patch[np.flatnonzero((share[sides.ravel()] == 1) & fault) // 3]] = True
    return patch, loose


def _inside(sheets: Sheets, whole: Prism) -> Sheets:
    """Leave out what the faults have outside the prism: a patch is inside as its largest triangle is."""
    patch, loose = _patches(sheets)
    order = np.argsort(triangle_areas(sheets.vertices, sheets.triangles), kind="stable")
    largest = np.zeros(len(loose), dtype=np.int64)
    largest[patch[order]] = order
    turns = igl.winding_number(
        np.ascontiguousarray(whole.surface.vertices),
        np.ascontiguousarray(whole.surface.triangles),
        np.ascontiguousarray(sheets.vertices[sheets.triangles[largest]].mean(axis=1)),
    )
    return sheets.only((turns > _INSIDE)[patch] | (sheets.owner == sheets.prism))


def _without_loose_ends(sheets: Sheets) -> Sheets:
    """Leave out the patches with a free edge, round which one comes from one side to the other.

    What ended on such a patch may be left with a free edge itself, hence the loop.
    """
    while True:
        patch, loose = _patches(sheets)
        if not loose.any():
            return sheets
        sheets = sheets.only(~loose[patch])
