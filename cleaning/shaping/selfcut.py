"""A surface refined exactly along the lines in which it crosses itself, and the patches between them."""

from __future__ import annotations

from dataclasses import replace

import igl
import igl.copyleft.cgal
import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.cleaning.shaping.pushing import rings
from graben.cleaning.shaping.shared import among
from graben.complexes import Complex
from graben.surface import Surface, edge_sharing, edge_table, triangle_normals
from graben.validators.measuring.measures import components, side_lengths, smallest_angles

#: Intersections that one triangle may have; above it the library would drop the triangle silently.
_CUTOFF = 1_000_000
#: A triangle with a smaller angle than this, degrees, is a sliver of the refinement and is collapsed.
SLIVER = 1.0
#: Rounds of collapsing: each takes one edge away around every sliver that is alone.
_MOST_ROUNDS = 200
#: A collapse must not turn a triangle around it further than this, as a cosine: 60 degrees.
_TURNED = 0.5


def self_refined(surface: Surface, concerned: BoolArray, touch: float) -> Complex:
    """Return a surface with the lines in which some of its triangles cross in its edges.

    Parameters
    ----------
    surface : Surface
        With sound triangles.
    concerned : (m,) array
        The triangles that cross others; they and those around them go through exact arithmetic.
    touch : float
        Vertices within this distance become one, before and after, that of the surface if there is one:
        sheets that cross along edges would pass each other by, and a line that ends at a rim but for
        rounding would not reach it.

    Returns
    -------
    Complex
        With one owner, 0.
    """
    corners = np.zeros(len(surface.vertices), dtype=np.bool_)
    corners[surface.triangles[concerned]] = True
    near = corners[surface.triangles].any(axis=1)
    points = _merged(surface.vertices, corners, corners, touch)
    new, faces, _, birth, unique = igl.copyleft.cgal.remesh_self_intersections(
        points,
        np.ascontiguousarray(surface.triangles[near], dtype=np.int64),
        False,
        False,
        False,
        True,
        _CUTOFF,
    )
    triangles = np.concatenate([surface.triangles[~near] + len(new), unique[faces]])
    parent = np.concatenate([np.flatnonzero(~near), np.flatnonzero(near)[birth]])
    vertices = np.concatenate([new, points])
    used, flat = np.unique(triangles, return_inverse=True)
    once, index = np.unique(vertices[used] + 0.0, axis=0, return_inverse=True)
    triangles = index.reshape(-1)[flat].reshape(-1, 3)
    once, again = np.unique(
        _merged(once, among(once, surface.vertices), np.ones(len(once), dtype=np.bool_), touch),
        axis=0,
        return_inverse=True,
    )
    triangles = again.reshape(-1)[triangles]
    a, b, c = triangles.T
    whole = (a != b) & (b != c) & (c != a)
    triangles, parent = triangles[whole], parent[whole]
    kept = ~_rim_slivers(once, triangles, touch)
    order = np.flatnonzero(kept)[np.argsort(parent[kept], kind="stable")]
    return Complex(once, triangles[order], ints(np.zeros(len(order))), parent[order])


def _rim_slivers(vertices: FloatArray, triangles: IntArray, touch: float) -> BoolArray:
    """Return the triangles of no height on their longest side, where that is of the rim, (m,).

    They join what a line parts that ends at the rim but for rounding.
    """
    edges, sides = edge_table(triangles)
    lengths = side_lengths(vertices, triangles)
    longest = lengths.argmax(axis=1)
    every = np.arange(len(triangles))
    double = np.linalg.norm(triangle_normals(vertices, triangles), axis=1)
    rim = edge_sharing(sides, len(edges))[sides[every, longest]] == 1
    return np.asarray(rim & (double <= touch * lengths[every, longest]), dtype=np.bool_)


def _merged(points: FloatArray, preferred: BoolArray, chosen: BoolArray, reach: float) -> FloatArray:
    """Return points (n, 3), chosen ones within reach of each other at the place of one of them."""
    some = np.flatnonzero(chosen)
    some = some[np.argsort(~preferred[some], kind="stable")]
    group = components(len(some), cKDTree(points[some]).query_pairs(reach, output_type="ndarray"))
    merged = np.array(points)
    merged[some] = points[some[np.unique(group, return_index=True)[1][group]]]
    return merged


def patches(network: Complex) -> IntArray:
    """Return the patch of each triangle, (m,): patches end where more than two triangles share an edge."""
    edges, sides = network.edges()
    count = len(network.triangles)
    joined = edge_sharing(sides, len(edges))[sides.ravel()] == 2
    pairs = np.stack([np.repeat(np.arange(count), 3), count + sides.ravel()], axis=1)[joined]
    labels = components(count + len(edges), pairs)[:count]
    return ints(np.unique(labels, return_inverse=True)[1].reshape(-1))


def crossing_edges(network: Complex) -> FloatArray:
    """Return the edges that more than two triangles share, shape (e, 2, 3), model units."""
    edges, sides = network.edges()
    return np.asarray(network.vertices[edges[edge_sharing(sides, len(edges)) > 2]])


def without_patch(surface: Surface, network: Complex, away: BoolArray) -> Surface | None:
    """Return a refined surface without some triangles (m,), where what is left is one manifold sheet.

    Slivers along the lines are collapsed; vertices of the surface keep their order, new ones follow.
    """
    triangles = network.triangles[~away]
    edges, sides = edge_table(triangles)
    if edge_sharing(sides, len(edges)).max(initial=0) > 2:
        return None
    old = among(network.vertices, surface.vertices)
    vertices, triangles, parent = collapsed(network.vertices, triangles, network.parent[~away], ~old)
    used, index = np.unique(triangles, return_inverse=True)
    made = replace(
        surface,
        vertices=vertices[used],
        triangles=ints(index.reshape(-1, 3)),
        lines=surface.lines[parent] if len(surface.lines) else surface.lines,
    )
    return _ordered(made, surface)


def collapsed(
    vertices: FloatArray, triangles: IntArray, parent: IntArray, movable: BoolArray
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return a mesh with the short sides of slivers collapsed, where the mesh stays sound.

    Parameters
    ----------
    vertices : (n, 3) array
        Model units.
    triangles : (m, 3) array
        Vertex indices.
    parent : (m,) array
        Follows the triangles.
    movable : (n,) array
        Vertices that may go; the other end of an edge stays where it is.
    """
    refused: set[tuple[int, int]] = set()
    for _ in range(_MOST_ROUNDS):
        angles = smallest_angles(vertices, triangles)
        thin = np.flatnonzero(angles < SLIVER)
        choice = _shortest(vertices, triangles[thin], movable, refused)
        if choice is None:
            break
        goes, stays = choice
        merged = np.where(triangles == goes, stays, triangles)
        a, b, c = merged.T
        whole = (a != b) & (b != c) & (c != a)
        if _harms(vertices, triangles, merged, whole, goes, stays):
            refused.add((goes, stays))
            continue
        triangles, parent = merged[whole], parent[whole]
    return vertices, triangles, parent


def _shortest(
    vertices: FloatArray, thin: IntArray, movable: BoolArray, refused: set[tuple[int, int]]
) -> tuple[int, int] | None:
    """Return the shortest side of slivers that may collapse: the end that goes, and the one that stays."""
    ways = np.concatenate([thin[:, [k, (k + s) % 3]] for k in range(3) for s in (1, 2)])
    ways = np.unique(ways[movable[ways[:, 0]]], axis=0)
    sizes = np.linalg.norm(vertices[ways[:, 0]] - vertices[ways[:, 1]], axis=1)
    for k in np.argsort(sizes, kind="stable"):
        way = int(ways[k, 0]), int(ways[k, 1])
        if way not in refused:
            return way
    return None


def _harms(
    vertices: FloatArray, before: IntArray, after: IntArray, whole: BoolArray, goes: int, stays: int
) -> bool:
    """Return whether a collapse breaks the link condition, turns a triangle or makes one as thin."""
    at = [before[(before == v).any(axis=1)] for v in (goes, stays)]
    common = np.setdiff1d(np.intersect1d(at[0], at[1]), [goes, stays])
    if len(common) != int((~whole).sum()):
        return True
    # an edge across the sheet between two vertices of the rim would pinch it
    on_rim = [_on_rim(t, v) for t, v in zip(at, (goes, stays), strict=True)]
    if on_rim[0] and (not on_rim[1] or len(common) > 1):
        return True
    kept = whole & (before == goes).any(axis=1)
    old, new = (triangle_normals(vertices, t[kept]) for t in (before, after))
    size = np.linalg.norm(old, axis=1) * np.linalg.norm(new, axis=1)
    thin = smallest_angles(vertices, before[kept]) < SLIVER
    turned = ((old * new).sum(axis=1) < _TURNED * size) & ~thin
    worse = smallest_angles(vertices, after[kept]) < np.minimum(
        smallest_angles(vertices, before[kept]), SLIVER
    )
    return bool((turned | worse).any())


def _on_rim(around: IntArray, vertex: int) -> bool:
    spokes = around[around != vertex]
    return bool((np.unique(spokes, return_counts=True)[1] == 1).any())


def _ordered(made: Surface, surface: Surface) -> Surface:
    """Return a surface with the vertices that it has from another first, in the order of that one."""
    both = np.concatenate([surface.vertices, made.vertices]) + 0.0
    place = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
    first = np.full(place.max() + 1, len(surface.vertices))
    np.minimum.at(first, place[: len(surface.vertices)], np.arange(len(surface.vertices)))
    order = np.argsort(first[place[len(surface.vertices) :]], kind="stable")
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.arange(len(order))
    return replace(made, vertices=made.vertices[order], triangles=ints(number[made.triangles]))


def sheets(surface: Surface, chosen: BoolArray) -> IntArray:
    """Return the layer of each chosen triangle (m,), -1 for others: layers end at creases over 90 degrees."""
    found = np.full(len(surface.triangles), -1)
    some = np.flatnonzero(chosen)
    triangles = surface.triangles[some]
    edges, sides = edge_table(triangles)
    order = np.argsort(sides.ravel(), kind="stable")
    shared = edge_sharing(sides, len(edges))
    start = np.cumsum(shared) - shared
    two = np.flatnonzero(shared == 2)
    first, second = order[start[two]] // 3, order[start[two] + 1] // 3
    normals = triangle_normals(surface.vertices, igl.bfs_orient(np.ascontiguousarray(triangles))[0])
    level = (normals[first] * normals[second]).sum(axis=1) > 0
    found[some] = components(len(some), np.stack([first[level], second[level]], axis=1))
    return ints(found)


def around(surface: Surface, triangles: BoolArray, count: int) -> BoolArray:
    """Return the triangles of a surface within some rings of others (m,)."""
    corners = np.zeros(len(surface.vertices), dtype=np.bool_)
    corners[surface.triangles[triangles]] = True
    return np.asarray(rings(surface.triangles, corners, count)[surface.triangles].any(axis=1), dtype=np.bool_)
