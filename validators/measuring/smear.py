"""How wide a horizon is smeared along a fault: the distance within which it leaves the trend of its own side.

Across a trace, d its distance and s the place along it, the horizon is described as

    u(d, s) = c(d, s) + (2 Phi(d / w) - 1) h(|d|, s),

c and h the mean of the two sides and half the step between them, Phi the normal distribution: a step that a
Gaussian of standard width w has smeared, between sides that may slope and bend. In windows along the trace
c (1, d, d^2, s, s d) and h (1, |d|, s) are fitted by least squares; w is one for the whole trace.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.special import ndtr

from graben.arrays import FloatArray
from graben.cutgraph import CutGraph
from graben.model import Horizon
from graben.validators.measuring.flanks import Flanks, Windows, flanks_of, hat, nodes_of, picks_of
from graben.validators.measuring.measures import remembered

#: Phi(1.645) = 0.95: at this many standard widths 95 % of the step is done.
DONE = 1.645
#: Widths w that are tried, in this many of these steps at least, and how many.
FINEST = 0.15
TRIED = 24
#: Half widths of the strip that is looked at, in steps of the horizon or of its picks, and the share of it
#: that the smear may take: beyond it both sides must be seen.
STRIPS = (8.0, 16.0, 32.0, 64.0)
INSIDE = 0.4
#: Points that a window needs, and of them on either side.
LEAST, LEAST_A_SIDE = 30, 10
#: A jump must leave this many times the squared residuals of the smeared step: else nothing is known.
CLEARER = 1.5
#: The step over the scatter about it, and over the horizon's step, below which there is none to speak of.
LEAST_SIGNAL, _LEAST_THROW = 4.0, 1e-3


@dataclass(frozen=True, eq=False)
class Smear:
    """How a horizon is smeared along a fault.

    Parameters
    ----------
    width : float
        Plan distance from the trace at which 95 % of the step is done, model units: what gamma should be at
        least.
    throw : float
        Root mean square of the step along the trace, model units.
    place : (3,) array
        On the trace, the middle of where the step is, model units.
    lines : tuple of (k, 3) arrays
        The trace.
    """

    width: float
    throw: float
    place: FloatArray
    lines: tuple[FloatArray, ...]

    @property
    def standard(self) -> float:
        """Standard width w of the Gaussian, model units."""
        return self.width / DONE


def smear_width(horizon: Horizon, graph: CutGraph, fault: int, gammas: Mapping[int, float]) -> Smear | None:
    """Return how wide a horizon is smeared along a fault.

    Looked at are the picks of a horizon that has some, else its nodes. The strip along the trace is widened
    until the smear takes less than 40 % of it.

    Parameters
    ----------
    horizon : Horizon
        As given, in the frame of the graph.
    graph : CutGraph
        Of that horizon.
    fault : int
        Index in the model of a fault that the graph has edges of.
    gammas : mapping
        gamma of each fault of the graph, model units: within gamma of another fault nothing is looked at.

    Returns
    -------
    Smear or None
        None where a step that is not smeared describes the horizon nearly as well, as it does where the
        throw is small against the noise, and where the horizon is not seen far enough on both sides.
    """
    return _measured(horizon, graph, fault, tuple(sorted(gammas.items())))


@remembered
def _measured(
    horizon: Horizon, graph: CutGraph, fault: int, gammas: tuple[tuple[int, float], ...]
) -> Smear | None:
    points = picks_of(horizon) if len(horizon.picks) else nodes_of(horizon.surface)
    step = spacing_of(horizon)
    for steps in STRIPS:
        reach = steps * step
        flanks = flanks_of(points, graph, fault, dict(gammas), reach, step)
        windows = [_Window.of(flanks, k, r, reach) for k, r in Windows.over(flanks, reach / 2)]
        seen = [w for w in windows if w is not None]
        if not seen:
            continue
        width = _fitted(seen, step, reach)
        if DONE * width <= INSIDE * reach:
            return _described(flanks, seen, width, _LEAST_THROW * step)
    return None


def spacing_of(horizon: Horizon) -> float:
    """Return the step of a horizon, or how far its picks lie apart where that is less, model units.

    The surface fitted to picks may have a step of twice their distance and more. In strips as wide as that
    the bend of the horizon itself, where its displacement dies out, was taken for smear.
    """
    if len(horizon.picks) == 0:
        return horizon.step
    hull = shapely.convex_hull(shapely.multipoints(horizon.picks[:, :2]))
    return min(horizon.step, float(np.sqrt(hull.area / len(horizon.picks))))


@dataclass(frozen=True, eq=False)
class _Window:
    """Points in a window of the strip: place along it (-1 to 1), distance, elevation, root of the weight."""

    centre: float
    s: FloatArray
    d: FloatArray
    z: FloatArray
    root: FloatArray
    reach: float

    @staticmethod
    def of(flanks: Flanks, centre: float, half: float, reach: float) -> _Window | None:
        weight = flanks.share * hat(flanks.along, centre, half) * hat(flanks.across, 0.0, reach)
        used = np.flatnonzero(weight > 0)
        right = int(np.count_nonzero(flanks.across[used] > 0))
        if len(used) < LEAST or min(right, len(used) - right) < LEAST_A_SIDE:
            return None
        return _Window(
            centre,
            (flanks.along[used] - centre) / half,
            flanks.across[used],
            flanks.points[used, 2],
            np.sqrt(weight[used]),
            reach,
        )

    def fit(self, width: float) -> tuple[float, float]:
        """Return half the step at the trace and the sum of squared residuals for a width; 0 is a jump."""
        d, s = self.d / self.reach, self.s
        step = np.sign(d) if width == 0.0 else 2.0 * ndtr(self.d / width) - 1.0
        one = np.ones_like(d)
        basis = np.column_stack([step, step * np.abs(d), step * s, one, d, d * d, s, s * d])
        left, right = basis * self.root[:, None], self.z * self.root
        found = np.linalg.lstsq(left, right, rcond=None)[0]
        return float(found[0]), float(((right - left @ found) ** 2).sum())

    def residuals(self, widths: FloatArray) -> FloatArray:
        """Return the sums of squared residuals for several widths, (k,); none of them 0.

        As of :meth:`fit`, but what does not depend on the width is fitted once.
        """
        d, s, one = self.d / self.reach, self.s, np.ones_like(self.d)
        smooth = _spanned(np.column_stack([one, d, d * d, s, s * d]) * self.root[:, None])
        step = (2.0 * ndtr(self.d / widths[:, None]) - 1.0) * self.root
        stepped = np.stack([step, step * np.abs(d), step * s], axis=2)
        size = np.linalg.norm(stepped, axis=(1, 2))
        stepped = stepped - smooth @ (smooth.T @ stepped)
        heights = self.z * self.root
        heights = heights - smooth @ (smooth.T @ heights)
        u, sizes, _ = np.linalg.svd(stepped, full_matrices=False)
        # directions that the smooth part has already, to rounding, explain nothing more
        share = (heights @ u) * (sizes > len(d) * np.finfo(float).eps * size[:, None])
        left = heights - (u @ share[:, :, None])[:, :, 0]
        return np.asarray((left**2).sum(axis=1))


def _spanned(columns: FloatArray) -> FloatArray:
    """Return an orthonormal basis of what some columns (n, c) span, (n, <= c)."""
    u, size, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(u[:, size > max(columns.shape) * np.finfo(float).eps * size[0]])


def _left(windows: list[_Window], width: float) -> float:
    """Return the sum of squared residuals over all windows."""
    return sum(w.fit(width)[1] for w in windows)


def _fitted(windows: list[_Window], step: float, reach: float) -> float:
    """Return the standard width that leaves the least residuals."""
    tried = np.geomspace(FINEST * step, INSIDE * reach, TRIED)
    left = np.sum([w.residuals(tried) for w in windows], axis=0)
    best = int(np.argmin(left))
    bend = 0.0 if best in (0, TRIED - 1) else left[best - 1] - 2.0 * left[best] + left[best + 1]
    if bend <= 0.0:
        return float(tried[best])
    # the least of the parabola through the best and its neighbours, in the logarithm of the width
    shift = 0.5 * (left[best - 1] - left[best + 1]) / bend
    return float(tried[best] * (tried[1] / tried[0]) ** shift)


def _described(flanks: Flanks, windows: list[_Window], width: float, least: float) -> Smear | None:
    """Return the smear of a standard width; None where there is no step, or a jump does nearly as well."""
    halves = np.array([w.fit(width)[0] for w in windows])
    throw = 2.0 * float(np.sqrt((halves**2).mean()))
    left = _left(windows, width)
    scatter = float(np.sqrt(left / sum(w.root @ w.root for w in windows)))
    if throw <= max(least, LEAST_SIGNAL * scatter) or _left(windows, 0.0) < CLEARER * left:
        return None
    centres = np.array([w.centre for w in windows])
    strongest = flanks.piece(float(centres[np.argmax(np.abs(halves))]))
    same = np.array([flanks.piece(c) == strongest for c in centres])
    middle = float(np.average(centres[same], weights=halves[same] ** 2))
    return Smear(DONE * width, throw, flanks.place(middle), flanks.lines)
