"""Two parts of a fault joined by a strip between the stretches of their rims that face each other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.cleaning.shaping.limits import joined
from graben.cleaning.shaping.patching import Frame, folds, frame_at, local_edge, on_plate, patched, with_patch
from graben.cleaning.shaping.rim_chains import at_corners
from graben.proximity import nearest
from graben.surface import Surface, boundary_edges, triangle_normals
from graben.validators.measuring.measures import amount, lengths
from graben.validators.measuring.openings import vector_area
from graben.validators.measuring.rim_lines import unit

#: Least cosine between the way to the other rim and the way out of a part, 45 degrees: at an end of the
#: strip the rims still face each other, and beyond a corner they do not.
_FACING = 0.7
#: The same for edges at the ends of what faces: a ragged corner of a part still does, its side does not.
_LEANING = 0.3
#: An end of a strip that leans more than this from square to the rim, as a sine, is moved to where it is
#: shortest, if it does not join two corners: one part goes on there beyond the other. The way of the rim is
#: taken over so many edges.
_SQUARE, _CHORD = 0.5, 4
#: Share of the extent of the smaller part along the gap that must face the other.
LEAST_FACED = 0.5
#: Rims nearer than this share of an edge touch: there is no way from one to the other that could be asked.
_TOUCHING = 1e-6
#: Rims that face each other with breaks shorter than so many edges are one stretch.
_BREAK = 6.0
#: Smallest angle of a strip, degrees: twice what `degenerate` asks for.
LEAST_ANGLE = 1.0
#: What is said of rims that pass each other.
_ASIDE = "the rims, {} apart, do not face each other along a line"


@dataclass(frozen=True, eq=False)
class Bridge:
    """What joins two parts.

    Parameters
    ----------
    surface : Surface
        With the strip, its new vertices and its triangles last; as it was where there is a problem.
    strip : Surface or None
        The strip alone.
    gap : float
        Where there is a strip its greatest width, else the least distance of the two rims, model units.
    length : float
        Along the strip, model units.
    problem : str
        Why there is no strip, in words; empty where there is one.
    flipped : bool
        Whether the triangles of the second part were turned, to agree with the first.
    """

    surface: Surface
    strip: Surface | None
    gap: float
    length: float = 0.0
    problem: str = ""
    flipped: bool = False


@dataclass(frozen=True, eq=False)
class _Rim:
    """Directed rim edges (e, 2) of a part, their middles (e, 3) and the unit ways out of it (e, 3).

    ``along`` (e, 3) are the mean ways out of each edge and its two neighbours, for ragged rims.
    """

    edges: IntArray
    middles: FloatArray
    out: FloatArray
    along: FloatArray


def bridged(
    surface: Surface, first: BoolArray, second: BoolArray, limit: float, touch: float, unit_name: str = ""
) -> Bridge:
    """Return a surface with two of its parts joined across the gap between them; all its vertices stay.

    Parameters
    ----------
    surface : Surface
        Its triangles turned one way in each part.
    first, second : (m,) arrays
        The triangles of the two parts; the second is the smaller.
    limit : float
        Widest gap that is joined, model units.
    touch : float
        Depth of a crossing that counts, model units.
    unit_name : str
        Unit of length in sentences.
    """
    rims = _rim(surface, first), _rim(surface, second)
    if not len(rims[0].edges) or not len(rims[1].edges):
        return Bridge(surface, None, np.inf, problem="a part without a rim cannot be joined")
    apart = nearest(surface.vertices[np.unique(rims[1].edges)], surface.vertices, rims[0].edges).distance
    least = float(apart.min())
    if least > limit:
        said = f"the rims are {amount(least, unit_name)} apart, {beyond(limit, unit_name)}"
        return Bridge(surface, None, least, problem=said)
    one, gap_one = _facing(surface.vertices, rims[0], rims[1], limit)
    two, gap_two = _facing(surface.vertices, rims[1], rims[0], limit)
    aside = _ASIDE.format(amount(least, unit_name))
    if len(one) < 2 or len(two) < 2 or (one[0] == one[-1]) != (two[0] == two[-1]):
        return Bridge(surface, None, least, problem=aside)
    if one[0] == one[-1]:
        ways = [_around(surface.vertices, one, two)]
    else:
        ways = [_paired(surface, one, two, leaning) for leaning in (True, False)]
        faced, extent = _faced(surface, ways[0][1][0][1], rims[1])
        if faced < LEAST_FACED * extent:
            said = f"the rims face each other along {amount(faced, unit_name)} only"
            return Bridge(surface, None, least, problem=f"{said}, of a side of {amount(extent, unit_name)}")
    made = Bridge(surface, None, least, problem=aside)
    for flipped, pairs in ways:
        if made.problem and all(len(own) > 1 for pair in pairs for own in pair):
            turned = np.where((second & flipped)[:, None], surface.triangles[:, [1, 0, 2]], surface.triangles)
            ready = replace(surface, triangles=ints(turned)) if flipped else surface
            made = replace(_strip(ready, pairs, touch), flipped=flipped)
    if made.problem:
        return replace(made, surface=surface, gap=least, flipped=False)
    return replace(made, gap=max(gap_one, gap_two))


def _faced(surface: Surface, stretch: IntArray, rim: _Rim) -> tuple[float, float]:
    """Return the extent of a stretch of a rim from end to end, and that of the whole rim along it."""
    points = surface.vertices[stretch]
    chord = unit((points[-1] - points[0])[None])[0]
    return float(np.ptp(points @ chord)), float(np.ptp(surface.vertices[np.unique(rim.edges)] @ chord))


def _rim(surface: Surface, part: BoolArray) -> _Rim:
    """Return the rim of a part."""
    triangles = surface.triangles[part]
    edges = boundary_edges(triangles)
    if not len(edges):
        return _Rim(edges, *3 * (floats([], 0, 3),))
    normals = np.zeros((len(surface.vertices), 3))
    np.add.at(normals, triangles.ravel(), np.repeat(triangle_normals(surface.vertices, triangles), 3, axis=0))
    a, b = surface.vertices[edges[:, 0]], surface.vertices[edges[:, 1]]
    out = unit(np.cross(b - a, normals[edges].sum(axis=1)))
    total = out.copy()
    for near, far in ((0, 1), (1, 0)):
        at = np.zeros((len(surface.vertices), 3))
        at[edges[:, far]] = out
        total += at[edges[:, near]]
    return _Rim(edges, floats(0.5 * (a + b)), out, unit(floats(total)))


def _facing(vertices: FloatArray, own: _Rim, other: _Rim, limit: float) -> tuple[IntArray, float]:
    """Return the longest stretch of a rim that faces another, as its triangles turn, and how far at most."""
    near = nearest(own.middles, vertices, other.edges)
    way = near.place - own.middles
    size = lengths(vertices[own.edges[:, 1]] - vertices[own.edges[:, 0]])
    typical = float(np.median(size))
    there, raw = near.simplex, np.einsum("ij,ij->i", way, own.out)
    ahead = np.maximum(raw, np.einsum("ij,ij->i", way, own.along))
    back = [np.einsum("ij,ij->i", way, -out[there]) for out in (other.out, other.along)]
    touches = near.distance <= _TOUCHING * typical
    faces = (np.minimum(ahead, np.maximum(*back)) >= _FACING * near.distance) | touches
    faces &= near.distance <= limit
    leans = (raw >= _LEANING * near.distance) & (near.distance <= limit)
    order = in_turn(own.edges)
    best, best_size, best_gap = ints([]), 0.0, 0.0
    for chain in order:
        for run in _runs(faces[chain], size[chain], _BREAK * typical, _closed(own.edges, chain)):
            edges = _extended(chain, run, leans[chain], _closed(own.edges, chain))
            length = float(size[edges].sum())
            if length > best_size:
                best = ints(np.append(own.edges[edges, 0], own.edges[edges[-1], 1]))
                best_size = length
                best_gap = float(near.distance[edges].max())
    return best, best_gap


def _extended(chain: IntArray, run: IntArray, leans: BoolArray, closed: bool) -> IntArray:
    """Return the edges of a run in a chain with those that go on from its ends and still lean that way."""
    count = len(chain)
    places = run.tolist()
    for step in (1, -1):
        while len(places) < count:
            at = places[-1 if step > 0 else 0] + step
            if not (closed or 0 <= at < count) or not leans[at % count]:
                break
            places = [*places, at % count] if step > 0 else [at % count, *places]
    return ints(chain[places])


def _closed(edges: IntArray, chain: IntArray) -> bool:
    return bool(edges[chain[0], 0] == edges[chain[-1], 1])


def in_turn(edges: IntArray) -> list[IntArray]:
    """Return directed edges (by index) in chains, one after the other; where they branch they end."""
    leaving = np.bincount(edges[:, 0], minlength=int(edges.max()) + 1)
    coming = np.bincount(edges[:, 1], minlength=int(edges.max()) + 1)
    plain = (leaving == 1) & (coming == 1)
    after = dict(zip(edges[:, 0].tolist(), range(len(edges)), strict=True))
    starts = np.flatnonzero(~plain[edges[:, 0]]).tolist()
    used: set[int] = set()
    chains = []
    for start in [*starts, *range(len(edges))]:
        chain: list[int] = []
        at = start
        while at not in used:
            used.add(at)
            chain.append(at)
            if not plain[edges[at, 1]]:
                break
            at = after[int(edges[at, 1])]
        if chain:
            chains.append(ints(chain))
    return chains


def _runs(faces: BoolArray, size: FloatArray, gap: float, closed: bool) -> list[IntArray]:
    """Return the runs of edges that face, with breaks up to a length in them, as indices in turn."""
    count = len(faces)
    at = np.flatnonzero(faces)
    if not len(at):
        return []
    if len(at) == count:
        return [np.arange(count)]
    following = np.append(at[1:], at[0] + count)
    runs: list[list[int]] = [[int(at[0])]]
    for here, there in zip(at.tolist(), following.tolist(), strict=True):
        between = np.arange(here + 1, there) % count
        last = there >= count
        near = float(size[between].sum()) <= gap and (closed or not last)
        if near and last and len(runs) == 1:
            return [ints((at[0] + np.arange(count)) % count)]
        if near and last:
            runs[0] = [*runs.pop(), *between.tolist(), *runs[0]]
        elif near:
            runs[-1] += [*between.tolist(), there]
        elif not last:
            runs.append([there])
    return [ints(run) for run in runs]


def _paired(
    surface: Surface, one: IntArray, two: IntArray, leaning: bool
) -> tuple[bool, list[tuple[IntArray, IntArray]]]:
    """Return two stretches that face each other, of which neither goes on beyond the end of the other.

    And whether the second runs as the first, so that its part must be turned; it then comes reversed. Without
    ``leaning`` each end of the strip is where it is shortest.
    """
    vertices = surface.vertices
    corner = at_corners(surface, one), at_corners(surface, two)
    ends = vertices[[one[0], one[-1], two[0], two[-1]]]
    flipped = bool(lengths(ends[[0, 1]] - ends[[2, 3]]).sum() < lengths(ends[[0, 1]] - ends[[3, 2]]).sum())
    # by the end of the first: whether the side of the one part goes on in that of the other
    sides = corner[0] & (corner[1] if flipped else corner[1][::-1])
    two = ints(two[::-1]) if flipped else two
    for side in sides:
        # the ends of both that belong together: where one goes on, it ends opposite to the end of the other
        a, b = vertices[one], vertices[two[::-1]]
        from_one, from_two = lengths(a - b[0]), lengths(b - a[0])
        onward = a[0] - a[min(_CHORD, len(a) - 1)]
        leans = abs(unit(onward[None])[0] @ (b[0] - a[0])) > _SQUARE * from_one[0]
        if not leaning or (leans and not side):
            if from_one.min() <= from_two.min():
                one = one[int(np.argmin(from_one)) :]
            else:
                two = two[: len(two) - int(np.argmin(from_two))]
        # the other two ends: the same, seen from there
        one, two = ints(two), ints(one)
    return flipped, [(one, two)]


def _around(
    vertices: FloatArray, one: IntArray, two: IntArray
) -> tuple[bool, list[tuple[IntArray, IntArray]]]:
    """Return a closed rim and one within it as two pairs of stretches, each as its triangles turn.

    And whether the second runs as the first, so that its part must be turned.
    """
    flipped = bool(vector_area(vertices[one]) @ vector_area(vertices[two]) > 0)
    inner = two[-2::-1] if flipped else two[:-1]
    start = int(np.argmin(lengths(vertices[inner] - vertices[one[0]])))
    inner = np.append(np.roll(inner, -start), inner[start])
    half = len(one) // 2
    at = int(np.argmin(lengths(vertices[inner] - vertices[one[half]])))
    return flipped, [(one[: half + 1], ints(inner[at:])), (one[half:], ints(inner[: at + 1]))]


def _strip(surface: Surface, pairs: list[tuple[IntArray, IntArray]], touch: float) -> Bridge:
    """Return a surface with strips between stretches of its rims, each as its triangles turn."""
    rims = ints(np.unique(np.concatenate([own for pair in pairs for own in pair])))
    frame, edge = frame_at(surface, rims), local_edge(surface, rims)
    whole, loops = _capped(surface, frame, rims, pairs, edge)
    strips: list[Surface] = []
    for part in loops:
        patch = patched(whole, frame, part, ints([]), edge)
        if patch is None:
            return Bridge(surface, None, 0.0, problem="the gap cannot be laid flat")
        whole, strip = with_patch(whole, patch)
        problem = folds(whole, len(patch.triangles), frame, touch)
        if not problem and patch.angle < LEAST_ANGLE:
            problem = f"its triangles would have angles of {patch.angle:.2g} degrees"
        if problem:
            return Bridge(surface, None, 0.0, problem=f"a strip was tried and given up, since {problem}")
        strips.append(strip)
    if not strips:
        return Bridge(surface, None, 0.0, problem="there is no room between them")
    length = sum(float(lengths(np.diff(surface.vertices[two], axis=0)).sum()) for _, two in pairs)
    return Bridge(whole, reduce(joined, strips), 0.0, length)


def _capped(
    surface: Surface, frame: Frame, rims: IntArray, pairs: list[tuple[IntArray, IntArray]], edge: float
) -> tuple[Surface, list[IntArray]]:
    """Return the surface with the vertices at the ends of strips, and the closed lines around the strips."""
    caps: dict[tuple[int, int], IntArray] = {}
    grown, loops = surface, []
    for one, two in pairs:
        for a, b in ((int(one[0]), int(two[-1])), (int(two[0]), int(one[-1]))):
            if (b, a) in caps:
                caps[a, b] = ints(caps[b, a][::-1])
                continue
            points = _cap(surface, frame, rims, a, b, edge)
            caps[a, b] = ints(len(grown.vertices) + np.arange(len(points)))
            grown = replace(grown, vertices=floats(np.concatenate([grown.vertices, points])))
        first, last = caps[int(one[0]), int(two[-1])], caps[int(two[0]), int(one[-1])]
        loops += _simple(ints(np.concatenate([one[::-1], first, two[::-1], last])))
    return grown, loops


def _simple(loop: IntArray) -> list[IntArray]:
    """Return a closed line of vertices cut into ones that do not touch themselves, each first = last.

    Parts of a fault may touch in vertices between which their rims face each other.
    """
    found: list[IntArray] = []
    path: list[int] = []
    for vertex in [*loop.tolist(), int(loop[0])]:
        if vertex in path:
            at = path.index(vertex)
            if len(path) - at > 2:
                found.append(ints([*path[at:], vertex]))
            del path[at:]
        path.append(vertex)
    return found


def _cap(surface: Surface, frame: Frame, rims: IntArray, a: int, b: int, edge: float) -> FloatArray:
    """Return the new vertices at an end of a strip, between two vertices, where the surface would go on."""
    flat = frame.flat(surface.vertices[[a, b]])[:, :2]
    parts = max(1, round(float(np.linalg.norm(flat[1] - flat[0])) / edge))
    share = (np.arange(1, parts) / parts)[:, None]
    return on_plate(surface, frame, rims, floats((1 - share) * flat[0] + share * flat[1], -1, 2), edge)


def beyond(limit: float, unit_name: str) -> str:
    """Return the limit that a gap is wider than, in words."""
    return f"more than max_extension = {amount(limit, unit_name)}"


def boxes_near(surface: Surface, first: BoolArray, second: BoolArray, limit: float) -> bool:
    """Return whether the boxes of two parts of a surface come as near as a limit, model units."""
    low, high = (
        [op(surface.vertices[surface.triangles[part]].reshape(-1, 3), axis=0) for part in (first, second)]
        for op in (np.min, np.max)
    )
    return bool(bools((low[0] <= high[1] + limit) & (low[1] <= high[0] + limit)).all())
