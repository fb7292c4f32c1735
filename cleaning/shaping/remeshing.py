"""A patch of a surface meshed anew by PyMeshLab, while all around it stays to the bit.

PyMeshLab's remeshing of a selection flips edges and projects vertices outside of it, and splits edges along
its border. So the patch alone is handed over, cut along the lines to be kept, which then are borders, with a
flag at each vertex to be kept: a triangle outside of the selection, which pins the vertex that it stands on.
What comes back is taken where every edge of the borders is still there; its vertices get their coordinates
of before.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.cleaning.shaping.fans import fans_of, joints_of
from graben.cleaning.shaping.shared import among
from graben.proximity import nearest
from graben.surface import Surface, edge_sharing, edge_table, triangle_normals

#: Bits of a vertex index in the number of an edge.
_HALF = 32
#: Passes of PyMeshLab over a patch: its own default.
_PASSES = 10
#: Degrees between the normals of triangles from which on an edge between them stays: PyMeshLab's default.
_RIDGE = 30.0
#: Length over the wanted one above which PyMeshLab splits an edge.
_SPLIT = 4.0 / 3.0
#: Height of a flag over the wanted length: too small for what is projected onto the patch to end up there.
_FLAG = 1e-2
#: Distance over the size of a patch up to which a vertex that came back is the one that was sent.
_SAME = 1e-9
#: Distance over the size of a patch between the banks of a line: PyMeshLab merges vertices in one place.
_APART = 1e-11
#: Share of the distance allowed that PyMeshLab may use: it measures at vertices and middles of edges alone.
_USED = 0.5


@dataclass(frozen=True, eq=False)
class _Cut:
    """A patch cut along lines: ``points`` (n, 3) from ``origin``, ``triangles`` (m, 3), and what stays.

    ``source`` (n,) is the vertex of the surface that each comes from, ``pinned`` (n,) whether it stays.
    ``borders`` (b, 2) are the edges that stay, by vertices of the surface, and ``sharing`` (b,) is how many
    triangles of the patch each has.
    """

    origin: FloatArray
    points: FloatArray
    triangles: IntArray
    source: IntArray
    pinned: BoolArray
    borders: IntArray
    sharing: IntArray


def shared_edges(surface: Surface, others: Iterable[Surface]) -> IntArray:
    """Return the edges of a surface that others have too, equal to the bit, the smaller vertex first, (k, 2).

    >>> line = [[0, 0, 0], [1, 0, 0]]
    >>> first = Surface("F", [*line, [0, 1, 1]], [[0, 1, 2]])
    >>> shared_edges(first, [Surface("G", [*line, [0, -1, 1]], [[0, 1, 2]])]).tolist()
    [[0, 1]]
    """
    edges = edge_table(surface.triangles)[0]
    shared = np.zeros(len(edges), dtype=np.bool_)
    for other in others:
        if other is surface or not among(other.vertices, surface.vertices).any():
            continue
        own, theirs = _places(surface.vertices, other.vertices)
        shared |= np.isin(_keys(own[edges]), _keys(theirs[edge_table(other.triangles)[0]]))
    return ints(edges[shared], -1, 2)


def rings(triangles: IntArray, seeds: IntArray, count: int) -> IntArray:
    """Return some triangles and those within so many rings of vertices around them, ascending, shape (k,).

    >>> rings(ints([[0, 1, 2], [1, 2, 3], [4, 5, 6]]), ints([0]), 1).tolist()
    [0, 1]
    """
    inside = np.zeros(len(triangles), dtype=np.bool_)
    inside[seeds] = True
    for _ in range(count):
        inside |= np.isin(triangles, triangles[inside]).any(axis=1)
    return np.flatnonzero(inside)


def remeshed(
    surface: Surface, patch: IntArray, held: BoolArray, lines: IntArray, length: float, away: float
) -> Surface | None:
    """Return a surface with a patch of it meshed anew, or None where that would change what is to be kept.

    The border of the patch stays edge by edge, and so do the rim and the lines in it; the vertices there and
    those held stay to the bit. The new triangles and vertices follow after the others.

    Parameters
    ----------
    surface : Surface
        A manifold.
    patch : (k,) array
        Indices of the triangles to be replaced.
    held : (n,) array
        Vertices that stay.
    lines : (l, 2) array
        Edges that stay, the smaller vertex first.
    length : float
        Length of edge wanted, model units.
    away : float
        Largest distance of the new triangles from the patch, model units; PyMeshLab keeps it about.
    """
    cut = _cut(surface, patch, held, lines)
    pins = np.flatnonzero(cut.pinned)
    if not len(pins) or not triangle_normals(cut.points, cut.triangles).sum(axis=0).any():
        return None
    points, triangles = _meshed(cut, length, away)
    size = float(np.abs(cut.points).max())
    distance, pin = cKDTree(cut.points[pins]).query(points)
    known = distance <= _SAME * size
    new = np.setdiff1d(triangles, np.flatnonzero(known))
    index = np.full(len(points), -1)
    index[known] = cut.source[pins[pin[known]]]
    index[new] = len(surface.vertices) + np.arange(len(new))
    made = ints(index[triangles], -1, 3)
    return _put(surface, patch, points[new] + cut.origin, made) if _same_borders(cut, made) else None


def followed(old: Surface, new: Surface, held: BoolArray, lines: IntArray) -> tuple[BoolArray, IntArray]:
    """Return which vertices (n,) and edges (k, 2) of a changed surface are those held in it before.

    Both are known by their places, equal to the bit; ``held`` and ``lines`` are of the old surface.
    """
    now, before = _places(new.vertices, old.vertices)
    edges = edge_table(new.triangles)[0]
    stay = np.isin(_keys(now[edges]), _keys(before[lines]))
    return bools(np.isin(now, before[held])), ints(edges[stay], -1, 2)


def differing(first: Surface, second: Surface) -> tuple[IntArray, IntArray]:
    """Return the triangles of each of two surfaces that the other has not, by their places, (k,) and (l,)."""
    places = _places(first.vertices, second.vertices)
    own = np.concatenate([p[s.triangles] for p, s in zip(places, (first, second), strict=True)])
    # the least corner first: a triangle turned over is another one
    start = own.argmin(axis=1)[:, None]
    turned = np.take_along_axis(own, (start + np.arange(3)) % 3, axis=1)
    kind, count = np.unique(turned, axis=0, return_inverse=True)[1].reshape(-1), len(first.triangles)
    return (
        np.flatnonzero(~np.isin(kind[:count], kind[count:])),
        np.flatnonzero(~np.isin(kind[count:], kind[:count])),
    )


def _cut(surface: Surface, patch: IntArray, held: BoolArray, lines: IntArray) -> _Cut:
    corners = ints(surface.triangles[patch], -1, 3)
    edges, sides = edge_table(corners)
    kept = np.isin(_keys(edges), _keys(lines))
    joints = joints_of(corners)
    triangles = fans_of(corners, ints(joints[~kept[sides.ravel()[joints[:, 0]]]], -1, 2))
    source = np.zeros(int(triangles.max()) + 1, dtype=np.int64)
    source[triangles.ravel()] = corners.ravel()
    sharing = edge_sharing(sides, len(edges))
    border = kept | (sharing == 1)
    origin = surface.vertices[source].mean(axis=0)
    points = surface.vertices[source] - origin
    order = np.argsort(source, kind="stable")
    bank = np.empty(len(source))
    bank[order] = np.arange(len(source)) - np.searchsorted(source[order], source[order])
    return _Cut(
        origin,
        floats(points + _APART * float(np.abs(points).max()) * bank[:, None]),
        triangles,
        ints(source),
        bools(held[source] | np.isin(source, edges[border])),
        edges[border],
        sharing[border],
    )


def _meshed(cut: _Cut, length: float, away: float) -> tuple[FloatArray, IntArray]:
    """Return points and triangles as PyMeshLab makes them of a patch, without the flags' triangles."""
    pins, count = np.flatnonzero(cut.pinned), len(cut.points)
    flags = _flags(cut, pins, _FLAG * length)
    first = count + np.arange(len(pins))
    poles = np.stack([pins, first, first + len(pins)], axis=1)
    points = np.concatenate([cut.points, flags])
    # flat triangles are flipped before the first pass, selected or not: that goes ahead, and none is left
    # to carry its selection to the border
    points, triangles = _remeshed(points, np.concatenate([cut.triangles, poles]), length, away, 0)
    points, triangles = _remeshed(points, triangles, length, away, _PASSES)
    of_flag = cKDTree(flags).query(points)[0] <= _SAME * float(np.abs(cut.points).max())
    return points, ints(triangles[~of_flag[triangles].any(axis=1)], -1, 3)


def _remeshed(
    points: FloatArray, triangles: IntArray, length: float, away: float, passes: int
) -> tuple[FloatArray, IntArray]:
    """Return what PyMeshLab makes of a mesh: not of triangles with a side of the border that it would split.

    Nor of flags, which have three sides there.
    """
    import pymeshlab

    edges, sides = edge_table(triangles)
    size = np.linalg.norm(np.diff(points[edges], axis=1)[:, 0], axis=1)
    border = edge_sharing(sides, len(edges)) == 1
    chosen = ~(border & (size > _SPLIT * length))[sides].any(axis=1) & (border[sides].sum(axis=1) < 3)
    mesh = pymeshlab.Mesh(
        vertex_matrix=points, face_matrix=triangles, f_scalar_array=chosen.astype(np.float64)
    )
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(mesh)
    meshes.compute_selection_by_condition_per_face(condselect="fq > 0.5")
    meshes.meshing_isotropic_explicit_remeshing(
        iterations=passes,
        selectedonly=True,
        targetlen=pymeshlab.PureValue(length),
        featuredeg=_RIDGE,
        checksurfdist=True,
        maxsurfdist=pymeshlab.PureValue(_USED * away),
        reprojectflag=True,
    )
    made = meshes.current_mesh()
    return floats(made.vertex_matrix()), ints(made.face_matrix(), -1, 3)


def _flags(cut: _Cut, pins: IntArray, height: float) -> FloatArray:
    """Return the two tips of a flag on each pin, the first ones and then the others, square to the patch."""
    up = np.zeros_like(cut.points)
    normals = triangle_normals(cut.points, cut.triangles)
    for corner in range(3):
        np.add.at(up, cut.triangles[:, corner], normals)
    mean = normals.sum(axis=0)
    up = np.where((up != 0.0).any(axis=1)[:, None], up, mean)[pins]
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    along = np.cross(up, np.eye(3)[np.abs(up).argmin(axis=1)])
    return np.concatenate([cut.points[pins] + height * (up + side * along) for side in (0.5, -0.5)])


def _same_borders(cut: _Cut, made: IntArray) -> bool:
    """Return whether new triangles have the borders of the patch, its pins, and else inner edges alone."""
    edges, sides = edge_table(made)
    sharing = edge_sharing(sides, len(edges))
    border = np.isin(_keys(edges), _keys(cut.borders))
    return (
        bool(np.isin(cut.source[cut.pinned], made).all())
        and np.array_equal(edges[border], cut.borders)
        and np.array_equal(sharing[border], cut.sharing)
        and bool((sharing[~border] == 2).all())
    )


def _put(surface: Surface, patch: IntArray, points: FloatArray, made: IntArray) -> Surface:
    """Return a surface with other triangles in place of a patch, without the vertices of it not used."""
    kept = np.delete(np.arange(len(surface.triangles)), patch)
    triangles = np.concatenate([surface.triangles[kept], made])
    vertices = np.concatenate([surface.vertices, points])
    unused = np.setdiff1d(surface.triangles[patch], triangles)
    used = np.delete(np.arange(len(vertices)), unused)
    lines = surface.lines
    if len(lines):
        middle = vertices[made].mean(axis=1)
        lines = np.concatenate(
            [lines[kept], lines[patch][nearest(middle, surface.vertices, surface.triangles[patch]).simplex]]
        )
    return replace(
        surface,
        vertices=floats(vertices[used]),
        triangles=ints(np.searchsorted(used, triangles), -1, 3),
        lines=ints(lines),
    )


def _places(*points: FloatArray) -> list[IntArray]:
    """Return for some sets of points (n, 3) the numbers of their places: one for points equal to the bit."""
    place = np.unique(np.concatenate(points) + 0.0, axis=0, return_inverse=True)[1].reshape(-1)
    return np.split(place, np.cumsum([len(p) for p in points])[:-1])


def _keys(edges: IntArray) -> IntArray:
    """Return a number for each edge (e, 2), whichever of its ends comes first."""
    low, high = edges.min(axis=1), edges.max(axis=1)
    return ints((low << _HALF) | high)
