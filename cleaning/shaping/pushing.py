"""Two surfaces moved apart in one place: one of them gets a smooth bump away from the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.sparse.linalg import spsolve

from graben.arrays import BoolArray, FloatArray, IntArray, floats
from graben.cleaning.shaping.turning import oriented
from graben.proximity import nearest
from graben.refinement import refined
from graben.surface import Surface, boundary_edges, edge_table, triangle_areas, triangle_normals
from graben.validators.measuring.contacts import Contact, contacts
from graben.validators.measuring.measures import smallest_angles

#: Clearance in contact distances: clearly above the distance at which two surfaces touch.
CLEAR = 10.0
#: Least clearance over the median edge of the finer surface, so that rounding does not undo it: files hold
#: four digits of an edge at least.
CLEAR_EDGE = 2e-3
#: Rings of triangles around the contact that must be clear, and rings that follow beyond them.
_ASKED_RINGS = 2
_FOLLOWING_RINGS = 4
#: Points within an edge at which its distance is looked at.
_SAMPLES = np.linspace(0.0, 1.0, 7)
#: Rounds of push and look; each closes most of what lacks.
_MOST_ROUNDS = 12
#: What is aimed at beyond the clearance, so that rounds come to an end.
_BEYOND = 1.1
#: A point beyond the rim of the other surface counts where it lies over it within this angle, as a cosine.
_OVER = 0.5
#: A push must leave a triangle this angle, degrees, or the second number times the angle that it had.
_SLIVER, _KEPT_ANGLE = 1.0, 0.5


@dataclass(frozen=True, eq=False)
class Push:
    """A surface moved away from another.

    Parameters
    ----------
    surface : Surface
        With the vertices moved; the triangles are the same.
    moved : (n,) array
        How far each vertex moved, model units.
    volume : float
        The space between the surface before and after, cubic model units.
    sound : bool
        Whether it has no slivers that it had not before.
    """

    surface: Surface
    moved: FloatArray
    volume: float
    sound: bool

    @property
    def most(self) -> float:
        """The largest move, model units."""
        return float(self.moved.max(initial=0.0))


def clearance(contact: float, *surfaces: Surface) -> float:
    """Return how far surfaces are moved apart, model units: above the contact distance and later rounding."""
    return max(CLEAR * contact, CLEAR_EDGE * min((s.median_edge for s in surfaces), default=0.0))


def met(first: Surface, second: Surface, contact: float) -> tuple[Contact, ...]:
    """Return where two surfaces meet, see :func:`graben.validators.measuring.contacts.contacts`."""
    both = [first, second]
    return contacts(both, refined(both), contact)


def side_of(own: Surface, other: Surface, vertices: IntArray) -> float:
    """Return on which side of a surface some vertices of another lie: 1.0 with its normals, else -1.0."""
    return 1.0 if _heights(own.vertices[vertices], oriented(other))[0].sum() >= 0 else -1.0


def heights(points: FloatArray, other: Surface) -> FloatArray:
    """Return signed distances of points (n, 3) from a surface, positive along its normals, model units."""
    return _heights(points, oriented(other))[0]


def pushed(
    own: Surface,
    other: Surface,
    core: BoolArray,
    side: float,
    clear: float,
    held: BoolArray,
) -> Push:
    """Return a surface moved to one side of another near some of its vertices.

    Samples on the edges of both, within two rings of triangles around ``core``, are asked to lie ``clear``
    apart, with ``own`` on the given side. The vertices of the triangles that lack it move along the normals
    of the other surface, the next four rings follow (the moves are harmonic there), all others stay.

    Parameters
    ----------
    own, other : Surface
        The one that moves, and the one that stays.
    core : (n,) array
        The vertices of ``own`` that take part in the contact, or lie behind the other surface.
    side : float
        1.0 for the side to which the triangles of ``other`` point, each turned as its neighbours; else -1.0.
    clear : float
        Distance to reach, model units.
    held : (n,) array
        Vertices that stay.
    """
    other = oriented(other)
    asked = rings(own.triangles, core, _ASKED_RINGS)
    rim = np.zeros(len(core), dtype=bool)
    rim[boundary_edges(own.triangles)] = True
    free = rings(own.triangles, asked, _FOLLOWING_RINGS) & ~held
    free &= ~(rim & ~rings(own.triangles, core, 1))
    normals = _vertex_normals(other)
    foot = nearest(own.vertices, other.vertices, other.triangles)
    way = side * _at(foot.place, foot.simplex, other, normals)
    need = np.zeros(len(core))
    surface = own
    for _ in range(_MOST_ROUNDS):
        lack = np.where(held, 0.0, _lacking(surface, other, normals, asked, side, clear * _BEYOND))
        if lack.max(initial=0.0) <= clear * (_BEYOND - 1.0) / 2.0:
            break
        need += lack
        surface = own.with_vertices(
            own.vertices + harmonic(own.triangles, need[:, None] * way, need > 0, free)
        )
    return _push(own, surface.vertices)


def _push(own: Surface, vertices: FloatArray) -> Push:
    """Return a surface with its vertices moved, and what that means."""
    moved = floats(np.linalg.norm(vertices - own.vertices, axis=1))
    volume = triangle_areas(own.vertices, own.triangles) @ moved[own.triangles].mean(axis=1)
    before, after = (smallest_angles(v, own.triangles) for v in (own.vertices, vertices))
    sound = bool((after >= np.minimum(_SLIVER, _KEPT_ANGLE * before)).all())
    return Push(own.with_vertices(vertices), moved, float(volume), sound)


def drawn_back(own: Surface, corners: BoolArray, clear: float) -> Push:
    """Return a surface with some vertices (n,) moved towards the mean of their neighbours, by ``clear``."""
    edges = edge_table(own.triangles)[0]
    ways = np.zeros_like(own.vertices)
    for a, b in (edges.T, edges.T[::-1]):
        np.add.at(ways, a, own.vertices[b] - own.vertices[a])
    size = np.linalg.norm(ways, axis=1)
    moves = np.where(corners[:, None], _BEYOND * clear * ways / np.where(size > 0, size, 1.0)[:, None], 0.0)
    return _push(own, own.vertices + moves)


def harmonic(triangles: IntArray, values: FloatArray, given: BoolArray, free: BoolArray) -> FloatArray:
    """Return values (n, 3) at vertices: as given, 0 where not free, else the mean of the neighbours."""
    result = np.where(given[:, None], values, 0.0)
    unknown = np.flatnonzero(free & ~given)
    if not len(unknown):
        return result
    edges = edge_table(triangles)[0]
    n = len(values)
    links = csr_array(
        coo_array(
            (np.ones(2 * len(edges)), (edges.T.ravel(), edges[:, ::-1].T.ravel())),
            shape=(n, n),
        )
    )
    laplace = csr_array(diags_array(links.sum(axis=1)) - links)
    rows = laplace[unknown]
    right = -(rows @ result)
    result[unknown] = spsolve(rows[:, unknown].tocsc(), right).reshape(-1, 3)
    return result


def rings(triangles: IntArray, vertices: BoolArray, count: int) -> BoolArray:
    """Return the vertices within ``count`` rings of triangles around some (n,), themselves included."""
    grown = np.array(vertices, dtype=np.bool_)
    for _ in range(count):
        grown[triangles[grown[triangles].any(axis=1)]] = True
    return grown


def _lacking(
    own: Surface, other: Surface, normals: FloatArray, asked: BoolArray, side: float, clear: float
) -> FloatArray:
    """Return how much each vertex of a surface lacks to be clear of another one, (n,), model units."""
    lack = np.zeros(len(own.vertices))
    edges = edge_table(own.triangles)[0]
    edges = edges[asked[edges].any(axis=1)]
    if not len(edges):
        return floats(lack)
    points = _sampled(own.vertices, edges)
    height, _, over = _heights(points, other)
    short = np.where(over | (np.abs(height) < clear), clear - side * height, 0.0).reshape(len(edges), -1)
    for k in (0, 1):
        # a sample asks the end that it is near to, and its middle both
        part = short[:, _SAMPLES <= 0.5] if k == 0 else short[:, _SAMPLES >= 0.5]
        np.maximum.at(lack, edges[:, k], part.max(axis=1, initial=0.0))
    # and the edges of the other one must not pass through a triangle of this
    mine = np.asarray(asked[own.triangles].any(axis=1), dtype=np.bool_)
    low, high = own.vertices[asked].min(axis=0), own.vertices[asked].max(axis=0)
    margin = clear + float(np.linalg.norm(high - low)) * 1e-3
    edges = edge_table(other.triangles)[0]
    ends = other.vertices[edges]
    edges = edges[((ends.min(axis=1) <= high + margin) & (ends.max(axis=1) >= low - margin)).all(axis=1)]
    if not len(edges):
        return np.where(asked, lack, 0.0)
    points, up = _sampled(other.vertices, edges), _sampled(normals, edges)
    back = nearest(points, own.vertices, own.triangles)
    gap = back.place - points
    along = (gap * up).sum(axis=1)
    level = side * np.sign(along) * back.distance
    facing = (np.abs(along) >= _OVER * back.distance) & mine[back.simplex]
    # what is far behind belongs to another place
    wanting = facing & (level < clear) & (level > -np.linalg.norm(high - low))
    tri = own.triangles[back.simplex[wanting]]
    np.maximum.at(lack, tri, np.repeat((clear - level[wanting])[:, None], 3, axis=1))
    return np.where(asked, lack, 0.0)


def _heights(points: FloatArray, other: Surface) -> tuple[FloatArray, IntArray, BoolArray]:
    """Return signed distances, nearest triangles, and which points lie over the surface, not beside it."""
    foot = nearest(points, other.vertices, other.triangles)
    up = _at(foot.place, foot.simplex, other, _vertex_normals(other))
    along = ((points - foot.place) * up).sum(axis=1)
    over = np.abs(along) >= _OVER * foot.distance
    return np.where(along < 0, -foot.distance, foot.distance), foot.simplex, over


def _sampled(values: FloatArray, edges: IntArray) -> FloatArray:
    """Return values (n, 3) at the samples of edges, shape (e * s, 3)."""
    a, b = values[edges[:, 0]], values[edges[:, 1]]
    return np.asarray((a[:, None] + _SAMPLES[:, None] * (b - a)[:, None]).reshape(-1, 3))


def _vertex_normals(surface: Surface) -> FloatArray:
    """Return the unit normals at vertices, weighted by the areas around them, shape (n, 3)."""
    normals = triangle_normals(surface.vertices, surface.triangles)
    total = np.zeros_like(surface.vertices)
    for k in range(3):
        np.add.at(total, surface.triangles[:, k], normals)
    size = np.linalg.norm(total, axis=1)
    return floats(total / np.where(size > 0, size, 1.0)[:, None])


def _at(places: FloatArray, simplex: IntArray, surface: Surface, values: FloatArray) -> FloatArray:
    """Return unit vectors at places in triangles, linear between those at the vertices, shape (n, 3)."""
    corners = surface.vertices[surface.triangles[simplex]]
    a, b, c = (corners[:, k] - places for k in range(3))
    shares = np.stack([np.linalg.norm(np.cross(u, v), axis=1) for u, v in ((b, c), (c, a), (a, b))], axis=1)
    total = shares.sum(axis=1)
    shares = np.where(total[:, None] > 0, shares / np.where(total > 0, total, 1.0)[:, None], 1.0 / 3.0)
    mixed = (shares[:, :, None] * values[surface.triangles[simplex]]).sum(axis=1)
    size = np.linalg.norm(mixed, axis=1)
    return np.asarray(mixed / np.where(size > 0, size, 1.0)[:, None])
