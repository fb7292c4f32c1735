"""Patches that continue a fault over a hole or a gap: laid out in its mean plane, bent as it bends around.

What was measured, holes of 3 to 30 triangles in corrugated and listric sheets, the largest distance of a new
vertex from the true surface in edges: thin-plate spline through two rings of vertices 0.01, biharmonic
(igl.harmonic, k = 2) 0.02, flat with refinement (pymeshlab) 0.10, harmonic 0.12, least-squares quadric 0.5.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely
import triangle as triangle_library
from scipy.interpolate import RBFInterpolator

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.surface import Surface, triangle_normals
from graben.validators.measuring.crossings import crossings
from graben.validators.measuring.measures import lengths, smallest_angles
from graben.validators.measuring.rim_lines import unit

#: Rings of vertices around a patch that say how the surface bends; a third one changes little.
_RINGS = 2
#: A spline through more points than this is solved piece by piece, from so many nearest ones.
_MOST_POINTS, _NEAREST = 2000, 100
#: Angles that are asked of the triangulation, degrees, and its largest triangles in equilateral ones of the
#: local edge: what comes out best in space is taken, since the patch's rim must stay as it is.
_TRIES = ((30.0, 1.3), (25.0, 1.3), (30.0, 0.9), (25.0, 1.9), (20.0, 0.7), (0.0, 1.3))
#: Smallest angle from which on a patch is as good as any, degrees.
_GOOD = 25.0
#: Without new vertices a patch may have edges of so many local ones.
_LONG = 1.6
#: Least cosine between a triangle of a patch and the mean plane.
_UNFOLDED = 0.2
#: Vertices of a ring nearer to each other in the mean plane than this share of an edge count once.
_ONCE = 1e-3
#: Area below which a loop lies on a line, in shares of its squared length.
_NO_AREA = 1e-6
_EQUILATERAL = 0.25 * np.sqrt(3.0)


@dataclass(frozen=True, eq=False)
class Frame:
    """The mean plane of a fault around a loop: ``origin`` (3,), and ``axes`` (3, 3), the last its normal.

    The normal points to the side to which those of the triangles point.
    """

    origin: FloatArray
    axes: FloatArray

    def flat(self, points: FloatArray) -> FloatArray:
        """Return points (n, 3) in the frame: two coordinates in the plane, and the height over it."""
        return floats((points - self.origin) @ self.axes.T)

    def space(self, points: FloatArray) -> FloatArray:
        """Return points (n, 3) of the frame in space."""
        return floats(points @ self.axes + self.origin)


@dataclass(frozen=True, eq=False)
class Patch:
    """A patch of a fault.

    Parameters
    ----------
    vertices : (n, 3) array
        The new ones, model units.
    triangles : (m, 3) array
        Vertex indices in the fault, the new ones after those that it has.
    angle : float
        Its smallest angle, degrees.
    """

    vertices: FloatArray
    triangles: IntArray
    angle: float


def frame_at(surface: Surface, loop: IntArray) -> Frame:
    """Return the mean plane of the triangles at some vertices of a surface."""
    at = np.isin(surface.triangles, loop).any(axis=1)
    normal = triangle_normals(surface.vertices, surface.triangles[at]).sum(axis=0)
    normal = unit(normal[None])[0]
    # the first axis follows the rim's own greatest extent, so that no direction of the compass matters
    points = surface.vertices[loop]
    origin = points.mean(axis=0)
    off = points - origin
    off = off - (off @ normal)[:, None] * normal
    along = np.linalg.eigh(off.T @ off)[1][:, -1]
    along = unit((along - (along @ normal) * normal)[None])[0]
    along = -along if ((off @ along) ** 3).sum() < 0 else along
    return Frame(floats(origin), floats([along, np.cross(normal, along), normal]))


def local_edge(surface: Surface, loop: IntArray) -> float:
    """Return the median length of the sides of the triangles at some vertices, model units."""
    corners = surface.vertices[surface.triangles[np.isin(surface.triangles, loop).any(axis=1)]]
    return float(np.median(lengths(corners - np.roll(corners, 1, axis=1))))


def outline(surface: Surface, frame: Frame, loop: IntArray) -> shapely.Polygon | None:
    """Return a closed loop of vertices in a mean plane; None where it crosses itself or lies on a line."""
    flat = frame.flat(surface.vertices[loop])[:, :2]
    area = shapely.Polygon(flat)
    around = float(np.linalg.norm(np.diff(flat, axis=0), axis=1).sum())
    return area if area.is_valid and area.area > _NO_AREA * around**2 else None


def patched(surface: Surface, frame: Frame, loop: IntArray, inner: IntArray, edge: float) -> Patch | None:
    """Return the best patch over a closed loop of vertices, which continues the surface around it.

    Parameters
    ----------
    surface : Surface
        Its triangles within the loop already taken away.
    frame : Frame
        The mean plane there.
    loop : (k + 1,) array
        Vertices around the patch, first = last. No edge of it is divided.
    inner : (i,) array
        Vertices of the surface that the patch is to hold inside the loop.
    edge : float
        Length of its edges, model units.

    Returns
    -------
    Patch or None
        None where the loop cannot be laid out in the plane.
    """
    area = outline(surface, frame, loop)
    held = np.concatenate([loop[:-1], inner])
    flat = frame.flat(surface.vertices[held])
    if area is None or not shapely.contains_xy(area, flat[len(loop) - 1 :, :2]).all():
        return None
    sides = np.arange(len(loop) - 1)
    plan = {"vertices": flat[:, :2] / edge, "segments": np.stack([sides, np.roll(sides, -1)], axis=1)}
    ring = _ring(surface, frame, held, edge)
    best: Patch | None = None
    for angle, size in ((0.0, 0.0), *_TRIES):
        asked = f"YYq{angle:g}a{size * _EQUILATERAL:.6f}" if size else ""
        made = triangle_library.triangulate(plan, f"p{asked}Q")
        places, corners = np.asarray(made["vertices"]), ints(made["triangles"], -1, 3)
        new = floats(places[len(held) :] * edge, -1, 2)
        whole = np.concatenate([surface.vertices[held], frame.space(_raised(new, ring, edge))])
        sides_of = whole[corners] - np.roll(whole[corners], 1, axis=1)
        patch = Patch(
            floats(whole[len(held) :], -1, 3),
            ints(np.concatenate([held, len(surface.vertices) + np.arange(len(new))])[corners], -1, 3),
            float(smallest_angles(floats(whole), corners).min()),
        )
        longest = float(lengths(sides_of).max())
        if not size and longest > _LONG * edge and not len(inner):
            continue
        if best is None or min(patch.angle, _GOOD) > best.angle:
            best = patch
        if best.angle >= _GOOD:
            break
    return best


def _ring(surface: Surface, frame: Frame, held: IntArray, edge: float) -> FloatArray:
    """Return the vertices around a patch in its frame, those on its rim included, shape (r, 3)."""
    normals = triangle_normals(surface.vertices, surface.triangles) @ frame.axes[2]
    inside = np.zeros(len(surface.vertices), dtype=np.bool_)
    inside[held] = True
    for _ in range(_RINGS):
        inside[surface.triangles[inside[surface.triangles].any(axis=1) & (normals > 0)]] = True
    points = frame.flat(surface.vertices[inside])
    once = np.unique(np.round(points[:, :2] / (_ONCE * edge)), axis=0, return_index=True)[1]
    return floats(points[np.sort(once)])


def _raised(plan: FloatArray, ring: FloatArray, edge: float) -> FloatArray:
    """Return points of the plane (n, 2) at the height of a thin plate through a ring of points, (n, 3)."""
    if not len(plan):
        return floats([], 0, 3)
    near = None if len(ring) <= _MOST_POINTS else _NEAREST
    plate = RBFInterpolator(ring[:, :2] / edge, ring[:, 2], neighbors=near, kernel="thin_plate_spline")
    return floats(np.column_stack([plan, plate(plan / edge)]))


def on_plate(surface: Surface, frame: Frame, rim: IntArray, plan: FloatArray, edge: float) -> FloatArray:
    """Return points (n, 2) of a mean plane on the surface as it goes on beyond some vertices, (n, 3)."""
    return frame.space(_raised(plan, _ring(surface, frame, rim, edge), edge))


def with_patch(surface: Surface, patch: Patch) -> tuple[Surface, Surface]:
    """Return the surface with a patch, its vertices and triangles last, and the patch alone."""
    whole = replace(
        surface,
        vertices=floats(np.concatenate([surface.vertices, patch.vertices])),
        triangles=ints(np.concatenate([surface.triangles, patch.triangles])),
        lines=ints(np.concatenate([surface.lines, np.zeros(len(patch.triangles), dtype=np.int64)]))
        if len(surface.lines)
        else surface.lines,
    )
    used, corners = np.unique(patch.triangles, return_inverse=True)
    return whole, Surface(surface.name, whole.vertices[used], ints(corners.reshape(-1, 3)))


def folds(surface: Surface, count: int, frame: Frame, touch: float) -> str:
    """Return what is wrong with the last triangles of a surface, in words; empty where nothing is.

    Parameters
    ----------
    surface : Surface
        With the patch.
    count : int
        Triangles of the patch, the last ones.
    frame : Frame
        Its mean plane.
    touch : float
        Depth of a crossing that counts, model units.
    """
    normals = triangle_normals(surface.vertices, surface.triangles)
    new = np.arange(len(normals)) >= len(normals) - count
    if (unit(normals[new]) @ frame.axes[2] < _UNFOLDED).any():
        return "it would fold over"
    near = _boxed(surface, new)
    up = normals[near & ~new][:, 2]
    if ((up > 0).all() or (up < 0).all()) and (normals[new][:, 2] * np.sign(up[0]) <= 0).any():
        return "it would be overturned, and the fault around it is not"
    some = np.flatnonzero(near)
    pairs = crossings(Surface(surface.name, surface.vertices, surface.triangles[some]), touch).pairs
    if new[some[pairs]].any():
        return "it would cross the fault"
    return ""


def _boxed(surface: Surface, new: BoolArray) -> BoolArray:
    """Return which triangles lie in the box of some of them, shape (m,)."""
    corners = surface.vertices[surface.triangles]
    low, high = corners[new].min(axis=(0, 1)), corners[new].max(axis=(0, 1))
    return bools(((corners.max(axis=1) >= low) & (corners.min(axis=1) <= high)).all(axis=1))
