"""How a rebuilt horizon lies to its input by distance from the faults, and what of the input was not used."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
import shapely

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.beside import begun
from graben.cutgraph import CutGraph
from graben.model import Model
from graben.modeling.distance import distances
from graben.modeling.picks import node_data
from graben.modeling.results import HorizonResult
from graben.proximity import PlanIndex, boxes, nearest
from graben.surface import Surface, triangle_normals

#: Limits of the bins of distance, in gammas: finer where smearing is, and one beyond the zone to compare.
BINS = (0.0, 0.125, 0.25, 0.5, 1.0, 2.0)
#: The part of the zone, in gammas, in which input that is smeared no wider than gamma asks for should be met.
OUTER = (0.5, 1.0)
#: So many standard widths from the trace the smear of the input has ended. Where it is known, the part of the
#: zone to be met begins there, if that is not too close to its end: the last limit, in gammas.
_CLEAR, _ROOM = 3.0, 0.75
#: Barycentric coordinates down to minus this count as inside: points on an edge belong to its triangles.
_ON_EDGE = 1e-7
#: Points without which a mean says little.
_LEAST = 10
#: Points from which on two cores share the comparison.
_WORTH = 50_000


@dataclass(frozen=True)
class Bin:
    """Input less rebuilt horizon between two distances from the trace of a fault, model units.

    Parameters
    ----------
    horizon, fault : str
        Names; a point belongs to the fault it is nearest to, in gammas.
    near, far : float
        Plan distances from the trace.
    count, gap : int
        Points that lie on the rebuilt horizon, and those that lie in the gap of the fault, which have none.
    mean, rms, largest : float
        Mean, root mean square and largest magnitude of the difference in elevation; NaN without a point.
    """

    horizon: str
    fault: str
    near: float
    far: float
    count: int
    gap: int
    mean: float
    rms: float
    largest: float


@dataclass(frozen=True)
class Masked:
    """Input within gamma of the trace of a fault, and how much of it was left out as smeared.

    ``what`` is "picks" or "nodes"; nodes of the zone are never used, picks where they jump at the fault as
    those further out ask for.
    """

    horizon: str
    fault: str
    what: str
    within: int
    left_out: int


@dataclass(frozen=True, eq=False)
class Missed:
    """The input in the outer part of the zone of a fault less the rebuilt horizon, model units.

    Parameters
    ----------
    horizon, fault : str
        Names; a point belongs to the fault it is nearest to, in gammas.
    near, far : float
        Plan distances from the trace that the points lie between.
    clear : bool
        Whether they are known to lie beyond the smear of the input; else it is the outer half of the zone.
    count : int
        Points on the rebuilt horizon.
    rms, beyond : float
        Root mean square of the difference there, and up to a gamma further out.
    place : (3,) array
        The point with the largest difference.
    """

    horizon: str
    fault: str
    near: float
    far: float
    clear: bool
    count: int
    rms: float
    beyond: float
    place: FloatArray


@dataclass(frozen=True)
class Misfit:
    """How a rebuilt horizon lies to its input, fault by fault.

    ``bins`` are differences by distance from each fault. ``missed`` are those of the outer part of each zone,
    without faults that have fewer than ten points there. ``masked`` is the input that was not used.
    """

    bins: tuple[Bin, ...] = ()
    missed: tuple[Missed, ...] = ()
    masked: tuple[Masked, ...] = ()


def misfit_of(result: HorizonResult, model: Model) -> Callable[[], Misfit]:
    """Return what tells how a rebuilt horizon lies to its input; without a fault that cuts it, nothing.

    On a large one the work is begun on a second core. Each input point is compared with the rebuilt horizon
    of its own side of the faults, that of the point.

    Parameters
    ----------
    result : HorizonResult
        A rebuilt horizon, in the frame of the model.
    model : Model
        The model that it was rebuilt from.
    """
    if not result.cutoffs:
        return Misfit
    local = _Local.of(result, model)
    owner, share = local.nearest_fault()
    near = np.flatnonzero(share < BINS[-1])
    # points come in rows, so that each half has triangles of its own
    tasks = [partial(local.rebuilt_at, half) for half in np.array_split(near, 2)]
    later = begun(tasks) if len(near) > _WORTH else lambda: [task() for task in tasks]

    def found() -> Misfit:
        off = local.points[near, 2] - np.concatenate(later())
        compared = _Compared(local, near, owner[near], share[near], off)
        return Misfit(tuple(compared.bins()), tuple(compared.missed()), tuple(local.masked()))

    return found


@dataclass(frozen=True, eq=False)
class _Compared:
    """Input points near faults, (k,), the fault that each is nearest to, in gammas, and how near that is.

    ``off`` (k,) is their elevation less that of the rebuilt horizon, NaN in the gap of a fault.
    """

    local: _Local
    points: IntArray
    owner: IntArray
    share: FloatArray
    off: FloatArray

    def bins(self) -> Iterator[Bin]:
        """Yield the differences in bins of distance."""
        for k, name in enumerate(self.local.result.graph_faults):
            width = float(self.local.gammas[k])
            for low, high in pairwise(BINS):
                mine = self.off[(self.owner == k) & (self.share >= low) & (self.share < high)]
                known = mine[np.isfinite(mine)]
                figures = (np.nan,) * 3
                if len(known):
                    figures = known.mean(), np.sqrt((known**2).mean()), np.abs(known).max()
                mean, rms, largest = (float(v) for v in figures)
                sizes = (len(known), len(mine) - len(known))
                limits = (low * width, high * width)
                yield Bin(self.local.result.name, name, *limits, *sizes, mean, rms, largest)

    def missed(self) -> Iterator[Missed]:
        """Yield the differences in the outer part of each zone."""
        for k, name in enumerate(self.local.result.graph_faults):
            mine = (self.owner == k) & np.isfinite(self.off)
            width = float(self.local.gammas[k])
            ended = _CLEAR * float(self.local.result.smears[k]) / width
            clear = 0.0 < ended <= _ROOM
            start = ended if clear else OUTER[0]
            inside = mine & (self.share >= start) & (self.share < OUTER[1])
            outside = mine & (self.share >= OUTER[1])
            if np.count_nonzero(inside) < _LEAST or np.count_nonzero(outside) < _LEAST:
                continue
            rms, beyond = (float(np.sqrt((self.off[some] ** 2).mean())) for some in (inside, outside))
            worst = self.points[inside][np.argmax(np.abs(self.off[inside]))]
            place = floats(self.local.points[worst] - self.local.origin)
            limits = (start * width, OUTER[1] * width)
            yield Missed(self.local.result.name, name, *limits, clear, int(inside.sum()), rms, beyond, place)


@dataclass(frozen=True, eq=False)
class _Local:
    """A rebuilt horizon and its input points, (p, 3), about the origin.

    ``origin`` (3,) was added to coordinates. ``near`` has for each fault the points that may lie within its
    bins, ascending, and how far they lie from its trace; ``gammas`` (f,) are those of the faults.
    """

    result: HorizonResult
    surfaces: tuple[Surface, ...]
    points: FloatArray
    near: tuple[tuple[IntArray, FloatArray], ...]
    gammas: FloatArray
    origin: FloatArray

    @staticmethod
    def of(result: HorizonResult, model: Model) -> _Local:
        origin = floats(-np.round(result.surface.vertices.mean(axis=0)))
        result, model = result.moved(origin), model.moved(origin)
        faults = [next(f for f in model.faults if f.name == name) for name in result.graph_faults]
        surfaces = tuple(f.surface for f in faults)
        gammas = floats([model.gamma(f, result.horizon) for f in faults])
        picks = result.horizon.picks
        points = picks if len(picks) else result.horizon.surface.vertices
        near = _near_traces(points, result.graph, BINS[-1] * gammas)
        return _Local(result, surfaces, points, near, gammas, origin)

    def masked(self) -> Iterator[Masked]:
        """Yield how much of the input lies within gamma of each fault, and how much of that was not used."""
        what = "picks" if len(self.result.horizon.picks) else "nodes"
        trusted = self._trusted()
        for k, name in enumerate(self.result.graph_faults):
            within = len(self.within(k))
            yield Masked(self.result.name, name, what, within, 0 if trusted[k] else within)

    def _trusted(self) -> BoolArray:
        """Return of each fault, (f,), whether picks inside its zone were used."""
        result, picks = self.result, self.result.horizon.picks
        places, block = result.first[:, :2], result.block
        data = node_data(picks, result.graph, self.surfaces, self.gammas, places, block)
        return bools((block[data.nodes] != 0).any(axis=0))

    def within(self, fault: int) -> IntArray:
        """Return the points within gamma of a fault's trace, ascending."""
        points, away = self.near[fault]
        return ints(points[away <= self.gammas[fault]])

    def nearest_fault(self) -> tuple[IntArray, FloatArray]:
        """Return for each point the fault it is nearest to, in gammas, and how near; inf is far from all."""
        owner = np.zeros(len(self.points), dtype=np.int64)
        share = np.full(len(self.points), np.inf)
        for k, (points, away) in enumerate(self.near):
            own = away / self.gammas[k]
            nearer = own < share[points]
            owner[points[nearer]], share[points[nearer]] = k, own[nearer]
        return owner, share

    def rebuilt_at(self, chosen: IntArray) -> FloatArray:
        """Return the elevation of the rebuilt horizon at some of the points, (k,); NaN in a gap."""
        points = self.points[chosen]
        surface = self.result.surface
        point, triangle, z = _over(points[:, :2], surface)
        own = np.ones(len(point), dtype=bool)
        place = np.full(len(self.points), -1)
        place[chosen] = np.arange(len(chosen))
        for k, fault in enumerate(self.surfaces):
            close = place[self.within(k)]
            close = close[close >= 0]
            sides = np.zeros(len(chosen), dtype=np.int8)
            sides[close] = _side(points[close], fault)
            side = sides[point]
            asked = np.flatnonzero(side)
            # A triangle whose nodes all lie on the other side is one across the fault.
            block = self.result.block[:, k][surface.triangles[triangle[asked]]]
            own[asked] &= (block * side[asked, None]).max(axis=1) >= 0
        found = np.full(len(points), np.nan)
        found[point[own]] = z[own]
        return found


def _near_traces(
    points: FloatArray, graph: CutGraph, reach: FloatArray
) -> tuple[tuple[IntArray, FloatArray], ...]:
    """Return for each fault the points (p, 3) in the box within ``reach`` (f,), and how far off they lie."""
    index = PlanIndex(points)
    found = []
    for k, f in enumerate(np.unique(graph.faults)):
        mine = graph.faults == f
        ends = graph.nodes[graph.edges[mine]][:, :, :2].reshape(-1, 2)
        near = index.within(ends.min(axis=0) - reach[k], ends.max(axis=0) + reach[k])
        found.append((near, distances(points[near], graph, mine)[0]))
    return tuple(found)


def _side(points: FloatArray, fault: Surface) -> IntArray:
    """Return 1 for points above a fault, on its hanging wall, and -1 for those below."""
    if len(points) == 0:
        return np.zeros(0, dtype=np.int64)
    near = nearest(points, fault.vertices, fault.triangles)
    normal = triangle_normals(fault.vertices, fault.triangles)[near.simplex]
    normal = normal * np.where(normal[:, 2:] < 0, -1.0, 1.0)
    return ints(np.where(((points - near.place) * normal).sum(axis=1) > 0, 1, -1))


def _over(places: FloatArray, surface: Surface) -> tuple[IntArray, IntArray, FloatArray]:
    """Return each place, (k, 2), with each triangle that it lies in in plan, and the elevation there."""
    near = _near(surface, places)
    low, high = boxes(surface.vertices, surface.triangles[near])
    tree = shapely.STRtree(shapely.points(places))
    triangle, point = tree.query(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))
    a, b, c = (surface.vertices[surface.triangles[near[triangle], k]] for k in range(3))
    p = places[point]
    with np.errstate(divide="ignore", invalid="ignore"):  # in a triangle without area lies nothing
        area = _cross(b - a, c - a)
        shares = [_cross(v - p, w - p) / area for v, w in ((b[:, :2], c[:, :2]), (c[:, :2], a[:, :2]))]
    shares.append(1.0 - shares[0] - shares[1])
    inside = np.flatnonzero(np.minimum(np.minimum(shares[0], shares[1]), shares[2]) >= -_ON_EDGE)
    z = shares[0] * a[:, 2] + shares[1] * b[:, 2] + shares[2] * c[:, 2]
    return ints(point[inside]), ints(near[triangle[inside]]), floats(z[inside])


def _near(surface: Surface, places: FloatArray) -> IntArray:
    """Return the triangles that may lie over one of the places, (k, 2): a few times those that do."""
    plan = surface.vertices[:, :2]
    edges = plan[surface.triangles] - plan[np.roll(surface.triangles, 1, axis=1)]
    # In cells of the size of the largest, a place lies in the cell of a corner or in one beside it.
    size, low = float(np.abs(edges).max()), plan.min(axis=0)
    across = int(np.ptp(plan[:, 1]) / size) + 4

    def cells(points: FloatArray) -> IntArray:
        column, row = (np.floor((points - low) / size).astype(np.int64) + 1).T
        return ints(column * across + row)

    beside = np.add.outer(np.array([-1, 0, 1]) * across, [-1, 0, 1]).ravel()
    marked = np.unique(np.add.outer(np.unique(cells(places)), beside))
    return np.flatnonzero(np.isin(cells(plan), marked)[surface.triangles[:, 0]])


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], dtype=np.float64)
