"""Points become a surface: the nodes of a lattice fitted to scattered picks.

The values u of the nodes minimize

    1/2 sum over picks of a_p (u(p) - z_p)^2 + c^4 E_H(u),

u(p) the linear interpolation in the triangle of pick p, a_p the share of pick p in the covered area, E_H the
Hessian-like energy of :mod:`graben.modeling.energy` and c the length over which the picks are smoothed: one
step, or more where the picks are noisy. Planes are reproduced whatever c.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import shapely
from scipy.optimize import brentq

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.errors import ModelingError
from graben.modeling.algebra import Cholmod
from graben.modeling.coverage import Coverage, covered, meshed
from graben.modeling.scattered import Places, Scattered, located
from graben.words import plural

#: Greatest length c, in steps: the surface is then nearly a plane.
MOST_SMOOTHING = 300.0
#: The rms residual is brought to the noise within this share of it.
NOISE_ACCURACY = 1e-2


@dataclass(frozen=True, eq=False)
class FittedSurface:
    """A surface fitted to picks.

    Parameters
    ----------
    vertices : (n, 3) array
        Model units.
    triangles : (m, 3) array
        Counter-clockwise in plan.
    note : str
        One sentence: what was done, and which picks were left out.
    residuals : (p,) array
        Pick minus surface in elevation, model units; NaN where a pick lies outside the surface.
    smoothing : float
        The length c, model units.
    """

    vertices: FloatArray
    triangles: IntArray
    note: str
    residuals: FloatArray = field(default_factory=lambda: floats([]))
    smoothing: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", floats(self.vertices, -1, 3))
        object.__setattr__(self, "triangles", ints(self.triangles, -1, 3))
        object.__setattr__(self, "residuals", floats(self.residuals))


@dataclass(frozen=True, eq=False)
class _Frame:
    """A plan frame in steps: the x axis along the longer side of the least rectangle about the picks."""

    origin: FloatArray
    axes: FloatArray
    step: float

    @staticmethod
    def of(plan: FloatArray, step: float) -> _Frame:
        """Return the frame of picks at plan positions (p, 2)."""
        # The least rectangle turns with the picks; its longer side says which way.
        if len(plan) < 3:
            raise ModelingError("there are fewer than three")
        middle = (plan.min(axis=0) + plan.max(axis=0)) / 2.0
        rectangle = shapely.MultiPoint(plan - middle).minimum_rotated_rectangle
        if rectangle.area == 0:
            raise ModelingError("they lie in one line in plan")
        ring = shapely.get_coordinates(rectangle)
        sides = np.diff(ring[:3], axis=0)
        lengths = np.linalg.norm(sides, axis=1)
        along = sides[np.argmax(lengths)] / lengths.max()
        origin = middle + ring[:4].mean(axis=0)
        return _Frame(floats(origin), floats([along, [-along[1], along[0]]]), step)

    def local(self, plan: FloatArray) -> FloatArray:
        return floats((plan - self.origin) @ self.axes.T / self.step)

    def world(self, local: FloatArray) -> FloatArray:
        return floats(self.origin + self.step * local @ self.axes)


def fit_points(picks: FloatArray, step: float, noise: float = 0.0, name: str = "") -> FittedSurface:
    """Fit a surface to picks; see the head of the module for what is minimized.

    The area is that of :mod:`graben.modeling.coverage`. Inside it lies a hexagonal lattice with one node on
    step^2, its rows along the longer side of the least rectangle about the picks in plan, a node in the
    middle of that rectangle: so the result turns and moves with the picks. Picks at one place count as one,
    with the mean of their elevations.

    Parameters
    ----------
    picks : (p, 3) array
        x, y, elevation, model units. Those with coordinates that are not finite are left out.
    step : float
        Node spacing, model units.
    noise : float
        Standard deviation of the picks, model units; when positive, c is raised above one step until the
        rms residual equals it.
    name : str
        Name of the horizon, for messages.

    Raises
    ------
    ModelingError
        When the picks do not span a surface: fewer than three, in one line, or too far from each other.
    """
    picks = floats(picks, -1, 3)
    finite = np.isfinite(picks).all(axis=1)
    plan, z = floats(picks[finite, :2]), floats(picks[finite, 2])
    try:
        frame = _Frame.of(plan, step)
        places = Places.of(frame.local(plan), z)
        coverage = covered(places.points)
        points, triangles = _mesh(coverage)
        nodes, at_places, smoothing = _fitted(points, triangles, places, coverage.shares, noise)
    except ModelingError as error:
        whose = f" of horizon {name!r}" if name else ""
        reason = str(error).rstrip(".")
        raise ModelingError(f"No surface can be fitted to the points{whose}: {reason}.") from None
    residuals = np.full(len(picks), np.nan)
    residuals[finite] = z - at_places[places.which]
    return FittedSurface(
        vertices=np.column_stack([frame.world(points), nodes]),
        triangles=triangles,
        note=_note(residuals, coverage, len(points), step, smoothing * step),
        residuals=floats(residuals),
        smoothing=smoothing * step,
    )


def _mesh(coverage: Coverage) -> tuple[FloatArray, IntArray]:
    points, triangles, count = [], [], 0
    for part in coverage.parts:
        own_points, own_triangles = meshed(part)
        points.append(own_points)
        triangles.append(own_triangles + count)
        count += len(own_points)
    return floats(np.concatenate(points)), ints(np.concatenate(triangles))


def _fitted(
    points: FloatArray, triangles: IntArray, places: Places, shares: FloatArray, noise: float
) -> tuple[FloatArray, FloatArray, float]:
    """Return the values of the nodes, those at the places (NaN outside the mesh), and c in steps."""
    faces, weights, inside = located(points, triangles, places.points)
    used = np.flatnonzero(inside & (shares > 0))
    # What is left of a plane is small, and the plane itself is kept to rounding.
    design = np.column_stack([np.ones(len(places.points)), places.points])
    plane = np.linalg.lstsq(design[used], places.means[used], rcond=None)[0]
    rest = places.means - design @ plane
    problem = Scattered.of(points, triangles, faces[used], weights[used], shares[used])
    load = problem.load(rest[used])
    analysis = Cholmod().analyse(problem.energy)
    counts, spread = places.counts[used], float(places.spread[used].sum())

    def solved(smoothing: float) -> FloatArray:
        return analysis.factor(problem.matrix(smoothing)).solve(load)

    def rms(smoothing: float) -> float:
        misfit = rest[used] - problem.at_places(solved(smoothing))
        return float(np.sqrt((counts @ misfit**2 + spread) / counts.sum()))

    smoothing = 1.0 if noise <= 0 else _smoothing_for(noise, rms)
    nodes = solved(smoothing)
    at_places = (nodes[triangles[faces]] * weights).sum(axis=1) + design @ plane
    at_places[~inside] = np.nan
    return floats(nodes + plane[0] + points @ plane[1:]), floats(at_places), smoothing


def _smoothing_for(noise: float, rms: Callable[[float], float]) -> float:
    """Return the length c in steps, from 1 to MOST_SMOOTHING, at which the rms residual is the noise."""
    low, high = 0.0, np.log(MOST_SMOOTHING)

    def excess(logarithm: float) -> float:
        return float(np.log(rms(float(np.exp(logarithm))) / noise))

    if excess(low) >= 0:
        return 1.0
    if excess(high) <= 0:
        return MOST_SMOOTHING
    # The residual grows at most like c^4.
    return float(np.exp(brentq(excess, low, high, xtol=NOISE_ACCURACY / 4.0)))


def _note(residuals: FloatArray, coverage: Coverage, nodes: int, step: float, smoothing: float) -> str:
    used = np.isfinite(residuals)
    rms = float(np.sqrt(np.mean(residuals[used] ** 2)))
    text = (
        f"{plural(nodes, 'node')} at a step of {step:.6g} fitted to {plural(int(used.sum()), 'point')}, "
        f"rms residual {rms:.3g}"
    )
    if smoothing > step:
        text += f", smoothed over {smoothing:.3g}"
    if not used.all():
        text += f"; {plural(int((~used).sum()), 'point')} that stand alone or are not finite left out"
    if coverage.left_out:
        text += f"; {plural(coverage.left_out, 'small part')} of the area left out"
    return text + "."
