"""Cutoffs of all horizons on one fault, told by their place along its strike: profiles and juxtapositions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from graben.arrays import FloatArray, floats
from graben.modeling.results import Cutoff, HorizonResult
from graben.modeling.throws import stretches
from graben.surface import Surface, mean_dip_direction

#: Layers and juxtapositions of less than this share of the box around all cutoffs are lines, not areas.
_FLAT = 1e-9


@dataclass(frozen=True, eq=False)
class Stretch:
    """The cutoffs of a horizon on a fault between two junctions, k rows, by their place along strike.

    Parameters
    ----------
    horizon : str
        Name.
    along : (k,) array
        Place of the middle between the lips along strike, model units.
    hanging, foot : (k, 2) arrays
        Place along strike and elevation of each lip, model units.
    throw : (k,) array
        Model units.
    """

    horizon: str
    along: FloatArray
    hanging: FloatArray
    foot: FloatArray
    throw: FloatArray


@dataclass(frozen=True, eq=False)
class Strike:
    """The line along which a fault is followed: through its mean strike, the fault dipping to its right.

    ``origin`` (2,) is where the fault begins in plan, ``way`` (2,) the direction, a unit vector.
    """

    origin: FloatArray
    way: FloatArray

    @staticmethod
    def of(fault: Surface) -> Strike:
        """Return the strike of a fault with at least one vertex."""
        dx, dy = mean_dip_direction(fault.vertices, fault.triangles)[0]
        way = np.array([-dy, dx])
        places = fault.vertices[:, :2]
        return Strike(floats(places.mean(axis=0) + way * ((places - places.mean(axis=0)) @ way).min()), way)

    def along(self, points: FloatArray) -> FloatArray:
        """Return the places of points (..., >= 2) along strike, model units."""
        return floats((points[..., :2] - self.origin) @ self.way)

    def seen(self, points: FloatArray) -> FloatArray:
        """Return points (k, 3) as seen square to strike: place along it and elevation, (k, 2)."""
        return floats(np.column_stack([self.along(points), points[:, 2]]))


def stretches_on(results: Sequence[HorizonResult], fault: Surface) -> tuple[Stretch, ...]:
    """Return the cutoffs of horizons on a fault, horizon by horizon."""
    strike = Strike.of(fault)
    return tuple(
        _stretch(result.name, cutoff, rows, strike)
        for result in results
        for cutoff in result.cutoffs
        if cutoff.fault == fault.name
        for rows in stretches(cutoff)
    )


def _stretch(horizon: str, cutoff: Cutoff, rows: slice, strike: Strike) -> Stretch:
    hanging, foot = cutoff.hanging[rows], cutoff.foot[rows]
    middle = strike.along((hanging + foot) / 2.0)
    return Stretch(horizon, middle, strike.seen(hanging), strike.seen(foot), floats(cutoff.throw[rows]))


@dataclass(frozen=True, eq=False)
class Layer:
    """The rock between two neighbouring horizons on one side of a fault, seen along its dip direction.

    ``shape`` has the place along strike as x and the elevation as y; it is empty where there is none.
    """

    upper: str
    lower: str
    shape: shapely.Geometry

    @property
    def name(self) -> str:
        """Its two horizons."""
        return f"{self.upper} to {self.lower}"


@dataclass(frozen=True, eq=False)
class Juxtaposition:
    """Where a layer of the foot wall meets a layer of the hanging wall across a fault.

    ``shape`` as of :class:`Layer`; ``area`` in square model units, of the fault as seen on a vertical plane
    along its strike.
    """

    foot: Layer
    hanging: Layer
    shape: shapely.Geometry
    area: float


@dataclass(frozen=True, eq=False)
class Juxtaposed:
    """An Allan diagram in numbers: the layers of both walls, the upper first, and where they meet."""

    fault: str
    stretches: tuple[Stretch, ...]
    foot: tuple[Layer, ...]
    hanging: tuple[Layer, ...]
    meetings: tuple[Juxtaposition, ...]


def juxtaposed(results: Sequence[HorizonResult], fault: Surface) -> Juxtaposed:
    """Return the layers on both walls of a fault, and where they meet (U. S. Allan, AAPG Bulletin 73, 1989).

    Layers lie between horizons that follow each other by their mean elevation on the fault; what is above
    the first and below the last is left out.
    """
    lines = stretches_on(results, fault)
    names = list(dict.fromkeys(line.horizon for line in lines))
    level = {name: _level([line for line in lines if line.horizon == name]) for name in names}
    names.sort(key=lambda name: -level[name])
    heights = np.concatenate(
        [side for line in lines for side in (line.hanging, line.foot)] or [np.zeros((1, 2))]
    )
    least = _FLAT * float(np.prod(np.ptp(heights, axis=0)))
    walls = {side: tuple(_layers(lines, names, side)) for side in ("foot", "hanging")}
    meetings = []
    for foot in walls["foot"]:
        for hanging in walls["hanging"]:
            shape = _areas(shapely.intersection(foot.shape, hanging.shape))
            if shape.area > least:
                meetings.append(Juxtaposition(foot, hanging, shape, float(shape.area)))
    return Juxtaposed(fault.name, lines, walls["foot"], walls["hanging"], tuple(meetings))


def _level(lines: Sequence[Stretch]) -> float:
    return float(np.concatenate([side[:, 1] for line in lines for side in (line.hanging, line.foot)]).mean())


def _layers(lines: Sequence[Stretch], names: Sequence[str], side: str) -> Iterator[Layer]:
    """Yield the layers between neighbours of ``names`` on one side."""
    for upper, lower in pairwise(names):
        tops, bases = (
            [getattr(line, side) for line in lines if line.horizon == name] for name in (upper, lower)
        )
        yield Layer(upper, lower, shapely.union_all([_between(a, b) for a in tops for b in bases]))


def _between(top: FloatArray, base: FloatArray) -> shapely.Geometry:
    """Return the area between two lines (k, 2), where the first lies above and both are known."""
    top, base = (line[np.argsort(line[:, 0], kind="stable")] for line in (top, base))
    low, high = max(top[0, 0], base[0, 0]), min(top[-1, 0], base[-1, 0])
    if not low < high:
        return shapely.Polygon()
    at = np.unique(np.concatenate([top[:, 0], base[:, 0], [low, high]]))
    at = at[(at >= low) & (at <= high)]
    upper, lower = (np.interp(at, line[:, 0], line[:, 1]) for line in (top, base))
    ring = np.concatenate(
        [np.column_stack([at, upper]), np.column_stack([at, np.minimum(upper, lower)])[::-1]]
    )
    return _areas(shapely.make_valid(shapely.Polygon(ring)))


def _areas(shape: shapely.Geometry) -> shapely.Geometry:
    """Return the polygons of a geometry alone."""
    parts = shapely.get_parts(shapely.get_parts(shape))
    return shapely.union_all([part for part in parts if part.geom_type == "Polygon"])
