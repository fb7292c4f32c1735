"""How wide a horizon is smeared along each of its faults."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from graben.arrays import FloatArray, floats
from graben.cutgraph import CutGraph
from graben.model import Horizon
from graben.modeling.close_smears import close_smear
from graben.modeling.side_by_side import usable_cores, worked
from graben.validators.measuring.smear import smear_width

#: Nodes of the horizon times faults whose smear takes longer to measure than a process to start.
_WORTH_A_PROCESS = 1e7


def smear_widths(horizon: Horizon, graph: CutGraph, gammas: Mapping[int, float]) -> FloatArray:
    """Return the standard width of the smear along each fault, (f,), model units; 0 where none is seen.

    Parameters
    ----------
    horizon, graph : Horizon, CutGraph
        The input.
    gammas : mapping
        gamma of each fault of the graph, model units; widths come in the order of the faults. Of faults that
        run close to each other the smear is measured together.
    """
    faults = sorted(gammas)

    def width(place: int) -> float:
        close = close_smear(horizon, graph, faults[place], gammas)
        if close is not None:
            return close.width
        smear = smear_width(horizon, graph, faults[place], gammas)
        return 0.0 if smear is None else smear.standard

    each = float(len(horizon.surface.vertices))
    return floats(np.array(worked(width, [each] * len(faults), usable_cores(), _WORTH_A_PROCESS)))
