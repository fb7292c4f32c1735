"""Where the triangles of one surface pass through or lie upon one another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.finding import Part
from graben.surface import Surface
from graben.validators.measuring.measures import (
    Mesh,
    areas_of,
    components,
    inner_points,
    largest_parts,
    normals_of,
    sides_of,
    welded_mesh_of,
)
from graben.validators.measuring.plan import Doubled, doubled, doubled_in_plan
from graben.validators.measuring.triangle_pairs import (
    Lines,
    common_lines,
    heights_over,
    leeway,
    unit_normals,
)

#: Cosine between a triangle's normal and the axis of view below which the triangle stands upright in the
#: view: what it crosses need not be covered twice there.
UPRIGHT = 1e-3
#: Share of triangles that may stand upright in plan for the plan to be the view.
FEW = 1e-3
#: Triangles whose neighbours are asked for at once: it bounds memory.
CHUNK = 20_000
#: Pairs of neighbours after which the search ends: a surface with more is no surface.
MOST_PAIRS = 20_000_000


@dataclass(frozen=True, eq=False)
class Crossings:
    """Pairs of triangles of a surface that have more in common than corners, sides or a touch.

    Parameters
    ----------
    pairs : (p, 2) array
        Triangle indices, the smaller first.
    lines : (p, 2, 3) array
        Ends of the line in which they cross; for an overlap both are its centroid.
    depths : (p,) array
        How deep inside both triangles the line comes; 0 for an overlap.
    areas : (p,) array
        Area of the overlap, square model units; 0 where they cross in a line.
    complete : bool
        False where the search ended early, see ``MOST_PAIRS``.
    """

    pairs: IntArray
    lines: FloatArray
    depths: FloatArray
    areas: FloatArray
    complete: bool = True


@dataclass(frozen=True, eq=False)
class _Scene:
    """The wide triangles of a surface, ``kept`` (m,) of its mesh, with their unit normals (m, 3)."""

    surface: Surface
    mesh: Mesh
    kept: IntArray
    normals: FloatArray
    touch: float

    def corners(self, triangles: IntArray) -> FloatArray:
        """Return the corners of wide triangles given by their number, shape (q, 3, 3)."""
        return self.surface.vertices[self.mesh.triangles[self.kept[triangles]]]


def crossings(surface: Surface, touch: float) -> Crossings:
    """Return the pairs of triangles that cross or overlap by more than a touch.

    Two triangles cross when a point of both lies further than ``touch`` from the sides of each. Where
    they meet along a side, a neighbour continues the sheet beyond it: they cross when the two sheets
    change places there. They overlap when one lies within ``touch`` of the plane of the other and
    neither can leave the other by a move of ``touch`` in that plane. So a vertex, a side or a rim that
    lies on another triangle, to the rounding of its coordinates, is a touch.

    Vertices at one place, equal to the bit, count as one; of triangles on the same places only the first
    takes part, and none that is nowhere wider than 2 ``touch``.

    Parameters
    ----------
    surface : Surface
        Finite coordinates and indices in range.
    touch : float
        Distance at which two sheets touch, model units.
    """
    scene = _scene(surface, touch)
    found: list[Crossings] = []
    seen = 0
    for pairs in _near_pairs(scene):
        found += [_crossing(scene, pairs), _overlapping(scene, pairs)]
        seen += len(pairs)
        if seen > MOST_PAIRS:
            break
    if not found:
        return Crossings(ints([], 0, 2), floats([], 0, 2, 3), floats([]), floats([]))
    pairs = np.sort(scene.mesh.kept[scene.kept[np.concatenate([f.pairs for f in found])]], axis=1)
    order = np.lexsort(pairs.T[::-1])
    return Crossings(
        ints(pairs[order]),
        floats(np.concatenate([f.lines for f in found])[order]),
        floats(np.concatenate([f.depths for f in found])[order]),
        floats(np.concatenate([f.areas for f in found])[order]),
        seen <= MOST_PAIRS,
    )


def overlap_parts(kind: str, surface: Surface, found: Crossings, unit: str) -> tuple[Part, ...]:
    """Return the connected areas in which triangles overlap, as parts, the largest first.

    Parameters
    ----------
    kind : str
        What to call them.
    surface : Surface
        What they are parts of.
    found : Crossings
        The pairs, of which those without area are left out.
    unit : str
        The unit of length; empty for none.
    """
    flat = found.areas > 0
    if not flat.any():
        return ()
    pairs = found.pairs[flat]
    mesh = welded_mesh_of(surface)
    own = np.flatnonzero(np.isin(mesh.kept, pairs))
    local = np.searchsorted(mesh.kept[own], pairs)
    # overlaps of triangles that are joined by an edge are one
    edges = np.stack([np.repeat(np.arange(len(own)), 3), len(own) + mesh.sides[own].ravel()], axis=1)
    labels = components(len(own) + len(mesh.edges), np.concatenate([local, edges]))
    group = np.unique(labels[local[:, 0]], return_inverse=True)[1].reshape(-1)
    sizes = floats(np.bincount(group, found.areas[flat]))
    places = inner_points(found.lines[flat, 0], group)
    return largest_parts(kind, sizes, np.bincount(group), places, f"{unit}²" if unit else "")


def _scene(surface: Surface, touch: float) -> _Scene:
    mesh = welded_mesh_of(surface)
    double, perimeter = 2.0 * areas_of(surface)[mesh.kept], sides_of(surface)[mesh.kept].sum(axis=1)
    # the radius of the inscribed circle is the area over half the perimeter
    kept = np.flatnonzero((double > touch * perimeter) & (double > 0))
    normals = normals_of(surface)[mesh.kept[kept]] / double[kept, None]
    return _Scene(surface, mesh, ints(kept), normals, touch)


def _near_pairs(scene: _Scene) -> Iterator[IntArray]:
    """Yield the pairs of triangles whose boxes meet, of which one may cross another.

    Where the surface covers no place of a view twice, only triangles that stand upright in the view can
    cross others.
    """
    if len(scene.kept) < 2:
        return
    axes, twice = _viewed(scene)
    suspect = np.array(np.abs(scene.normals @ axes[:, 2]) < UPRIGHT, dtype=bool)
    if not (suspect.any() or twice.tangled or len(twice.faces)):
        return
    corners = (scene.surface.vertices @ axes)[scene.mesh.triangles[scene.kept]]
    low, high = corners.min(axis=1) - scene.touch, corners.max(axis=1) + scene.touch
    boxes = shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    tree = shapely.STRtree(boxes)
    suspect[tree.query(twice.faces, predicate="intersects")[1]] = True
    suspect |= twice.tangled
    asked = np.flatnonzero(suspect)
    for start in range(0, len(asked), CHUNK):
        chunk = asked[start : start + CHUNK]
        k, j = tree.query(boxes[chunk])
        i = chunk[k]
        new = (i < j) | ~suspect[j]
        i, j = i[new], j[new]
        meet = (low[i, 2] <= high[j, 2]) & (low[j, 2] <= high[i, 2])
        yield np.stack([i[meet], j[meet]], axis=1)


def _viewed(scene: _Scene) -> tuple[FloatArray, Doubled]:
    """Return the axes of a view, the last the way one looks, and the faces covered twice in it.

    The plan where it is covered once and few triangles stand upright in it, else the main axis of the
    normals.
    """
    if (np.abs(scene.normals[:, 2]) < UPRIGHT).mean() <= FEW:
        found = doubled_in_plan(scene.surface)
        if not (found.tangled or len(found.faces)):
            return floats(np.eye(3)), found
    axes = np.linalg.eigh(scene.normals.T @ scene.normals)[1]
    return floats(axes), doubled((scene.surface.vertices @ axes)[:, :2], scene.mesh)


def _shared(scene: _Scene, pairs: IntArray) -> IntArray:
    """Return how many corners the triangles of each pair have in common, shape (p,)."""
    first, second = (scene.mesh.triangles[scene.kept[pairs[:, k]]] for k in (0, 1))
    return np.asarray((first[:, :, None] == second[:, None, :]).sum(axis=(1, 2)), dtype=np.int64)


def _crossing(scene: _Scene, pairs: IntArray) -> Crossings:
    """Return those of some pairs that cross in a line."""
    pairs = pairs[_shared(scene, pairs) < 2]
    corners = (scene.corners(pairs[:, 0]), scene.corners(pairs[:, 1]))
    normals = (scene.normals[pairs[:, 0]], scene.normals[pairs[:, 1]])
    lines = common_lines(corners, normals, scene.touch)
    deep = np.flatnonzero(lines.depth > scene.touch)
    through = np.array((lines.along[deep] < 0).all(axis=1), dtype=bool)
    beside = deep[~through]
    if len(beside):
        through[~through] = _change_places(scene, pairs[lines.pair[beside]], lines, beside)
    deep = deep[through]
    return Crossings(pairs[lines.pair[deep]], lines.ends[deep], lines.depth[deep], np.zeros(len(deep)))


def _change_places(scene: _Scene, pairs: IntArray, lines: Lines, which: IntArray) -> BoolArray:
    """Return for which pairs that meet along a side the sheets beyond it lie across each other.

    Seen along the line, each sheet is two rays that leave it. They change places when one ray of the
    second lies on either side of the first, further from its rays than a touch.
    """
    ends, depth, along = lines.ends[which], lines.depth[which], lines.along[which]
    way = unit_normals(ends[:, 1] - ends[:, 0])
    middle = ends.mean(axis=1)
    right = scene.normals[pairs[:, 0]]
    ahead = np.cross(way, right)
    angles, sizes = [], []
    for k in (0, 1):
        rays = _rays(scene, pairs[:, k], along[:, k], middle, way, depth)
        angles.append(np.arctan2(np.einsum("qrd,qd->qr", rays, right), np.einsum("qrd,qd->qr", rays, ahead)))
        sizes.append(np.linalg.norm(rays, axis=2))
    turn = 2.0 * np.pi
    arc = np.mod(angles[0][:, 1] - angles[0][:, 0], turn)
    between = np.mod(angles[1] - angles[0][:, :1], turn) < arc[:, None]
    gap = np.abs(np.mod(angles[1][:, :, None] - angles[0][:, None, :] + np.pi, turn) - np.pi)
    clear = gap * np.minimum(sizes[1][:, :, None], sizes[0][:, None, :]) > scene.touch
    # a rim has no second ray: its size is 0 and it is never clear
    return np.asarray((between[:, 0] != between[:, 1]) & clear.all(axis=(1, 2)))


def _rays(
    scene: _Scene,
    triangles: IntArray,
    along: IntArray,
    middle: FloatArray,
    way: FloatArray,
    depth: FloatArray,
) -> FloatArray:
    """Return the two rays in which a sheet leaves a line, shape (q, 2, 3); 0 beyond a rim.

    Inside a triangle they are opposite and as long as the line is deep; at a side each leads to the level
    of the corner opposite to it, in this triangle and in its neighbour.
    """
    across = np.cross(way, scene.normals[triangles]) * depth[:, None]
    rays = np.stack([across, -across], axis=1)
    at_side = np.flatnonzero(along >= 0)
    apex = (along[at_side] + 2) % 3
    own = scene.mesh.triangles[scene.kept[triangles[at_side]], apex]
    other = _beyond(scene.mesh, scene.kept[triangles[at_side]], apex)
    for k, corner in enumerate((own, other)):
        leg = scene.surface.vertices[corner] - middle[at_side]
        leg -= np.einsum("qd,qd->q", leg, way[at_side])[:, None] * way[at_side]
        rays[at_side, k] = np.where(corner[:, None] < 0, 0.0, leg)
    return rays


def _beyond(mesh: Mesh, triangles: IntArray, apex: IntArray) -> IntArray:
    """Return the vertex beyond the side opposite to a corner of triangles, (q,); -1 where not just one."""
    edge = mesh.sides[triangles, apex]
    t, k = np.nonzero(np.isin(mesh.sides, edge))
    order = np.argsort(mesh.sides[t, k], kind="stable")
    t, k = t[order], k[order]
    first = np.searchsorted(mesh.sides[t, k], edge)
    second = np.minimum(first + 1, len(t) - 1)
    take = np.where(t[first] == triangles, second, first)
    return np.where(mesh.sharing[edge] == 2, mesh.triangles[t[take], k[take]], -1)


def _overlapping(scene: _Scene, pairs: IntArray) -> Crossings:
    """Return those of some pairs that overlap in an area."""
    upon = _lies_in(scene, pairs[:, 1], pairs[:, 0])
    under = ~upon & _lies_in(scene, pairs[:, 0], pairs[:, 1])
    # the one in whose plane the other lies comes first
    pairs = np.concatenate([pairs[upon], pairs[under][:, ::-1]])
    corners = (scene.corners(pairs[:, 0]), scene.corners(pairs[:, 1]))
    wide = leeway(corners, scene.normals[pairs[:, 0]]) > scene.touch
    pairs, first, second = pairs[wide], corners[0][wide], corners[1][wide]
    right = unit_normals(first[:, 1] - first[:, 0])
    frame = np.stack([right, np.cross(scene.normals[pairs[:, 0]], right)], axis=2)
    plans = [shapely.polygons((c - first[:, :1]) @ frame) for c in (first, second)]
    common = shapely.intersection(plans[0], plans[1])
    centroid = shapely.centroid(common)
    middle = np.nan_to_num(np.stack([shapely.get_x(centroid), shapely.get_y(centroid)], axis=1))
    place = first[:, 0] + (frame @ middle[:, :, None])[:, :, 0]
    return Crossings(pairs, np.stack([place, place], axis=1), np.zeros(len(pairs)), shapely.area(common))


def _lies_in(scene: _Scene, triangles: IntArray, planes: IntArray) -> BoolArray:
    """Return which triangles lie in the planes of others, within the distance of a touch."""
    heights = heights_over(
        scene.corners(planes), scene.normals[planes], scene.corners(triangles), scene.touch
    )
    return np.asarray(~heights.any(axis=1))
