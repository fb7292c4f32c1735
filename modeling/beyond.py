"""Whether a horizon still steps beyond an end of its cut: the fault goes on, and was picked too short."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, floats
from graben.cutgraph import CutGraph
from graben.model import Model
from graben.modeling.distance import distances
from graben.modeling.results import HorizonResult
from graben.validators.measuring.flanks import nodes_of, picks_of

#: Looked at is what lies up to so many gammas beyond the end.
_FAR = 2.0
#: Nearer to the line of the fault than this share of gamma the input may be smeared.
_NEAR = 0.5
#: Points that either side needs, two for each coefficient of the fit.
_LEAST = 12
#: A step must stand out from the scatter about it by this factor: relief is no step.
_CLEAR = 3.0


@dataclass(frozen=True, eq=False)
class Step:
    """The step of the input horizon beyond an end: positive as throw is, model units.

    ``scatter`` is the root mean square of what the fit leaves.
    """

    value: float
    scatter: float

    @property
    def clear(self) -> bool:
        """Whether it stands out from the scatter."""
        return abs(self.value) > _CLEAR * self.scatter


def step_beyond(result: HorizonResult, model: Model, fault: str, line: FloatArray, last: bool) -> Step | None:
    """Return by how much the input horizon steps across the line on which a fault would go on.

    With d and s the places across and along that line, within 2 gamma of the end but not within half a gamma
    of the line, h sign(d) + a combination of 1, d, s, d^2 and s d is fitted to the input; the step is 2 h.
    On the models with a known answer it is at most 1 % of the largest throw beyond a true tip.

    Parameters
    ----------
    result : HorizonResult
        A rebuilt horizon; looked at are the picks of its input, where it has some, else its nodes.
    model : Model
        In the same frame; for the gammas.
    fault : str
        Name of a fault that cuts the horizon.
    line : (k, >= 2) array
        The cut in plan, the fault dipping to the right of the way.
    last : bool
        Whether the end is the last of its points, else the first.

    Returns
    -------
    Step or None
        None where either side has too few points off other faults.
    """
    gamma = next(model.gamma(f, result.horizon) for f in model.faults if f.name == fault)
    end, ahead = _onwards(line[:, :2] if last else line[::-1, :2], gamma)
    # Beyond the first point the way is walked backwards, and the fault dips to its left.
    right = np.array([ahead[1], -ahead[0]]) * (1.0 if last else -1.0)
    horizon = result.horizon
    index = picks_of(horizon) if len(horizon.picks) else nodes_of(horizon.surface)
    # the corners of the square that is looked at lie this far from the end
    reach = _FAR * np.sqrt(2.0) * gamma
    points = index.points[index.within(floats(end - reach), floats(end + reach))]
    to = points[:, :2] - end
    s, d = to @ ahead / gamma, to @ right / gamma
    used = (s > 0) & (s < _FAR) & (np.abs(d) > _NEAR) & (np.abs(d) < _FAR)
    used[used] = _off_others(points[used], result.graph, model, result, fault)
    s, d, z = s[used], d[used], points[used, 2]
    if min(np.count_nonzero(d > 0), np.count_nonzero(d < 0)) < _LEAST:
        return None
    basis = np.column_stack([np.sign(d), np.ones_like(d), d, s, d * d, s * d])
    found = np.linalg.lstsq(basis, z - z.mean(), rcond=None)[0]
    left = z - z.mean() - basis @ found
    # The foot lies on the left: throw is foot less hanging.
    return Step(-2.0 * float(found[0]), float(np.sqrt((left**2).mean())))


def _onwards(line: FloatArray, gamma: float) -> tuple[FloatArray, FloatArray]:
    """Return the end of a line (k, 2) and the direction in which it runs over its last gamma."""
    way = np.append(0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T)))
    back = max(float(way[-1]) - gamma, 0.0)
    before = np.array([np.interp(back, way, line[:, k]) for k in (0, 1)])
    chord = line[-1] - before
    return floats(line[-1]), floats(chord / max(float(np.hypot(*chord)), np.finfo(np.float64).tiny))


def _off_others(
    points: FloatArray, graph: CutGraph, model: Model, result: HorizonResult, fault: str
) -> BoolArray:
    """Return which points lie further than gamma from the cuts of all other faults, (n,)."""
    kept = np.ones(len(points), dtype=bool)
    if len(points) == 0:
        return kept
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    for f in np.unique(graph.faults):
        other, mine = model.faults[f], graph.faults == f
        gamma = model.gamma(other, result.horizon)
        cut = graph.nodes[graph.edges[mine], :2].reshape(-1, 2)
        beside = (cut.max(axis=0) + gamma < low).any() or (cut.min(axis=0) - gamma > high).any()
        if other.name != fault and not beside:
            kept &= distances(points[:, :2], graph, mine)[0] > gamma
    return kept
