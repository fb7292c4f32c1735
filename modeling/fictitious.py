"""The fictitious fault: a vertical wall on the outer boundary of a horizon (paper Sect. 3.1)."""

from __future__ import annotations

import numpy as np

from graben.arrays import IntArray
from graben.complexes import Complex
from graben.prism import over
from graben.refinement import refined
from graben.surface import Surface

#: How far the wall reaches beyond the faults and the horizon, as a share of their height.
_MARGIN = 0.1


def fictitious_fault(horizon: Surface, network: Complex) -> Surface:
    """Return W_fict: the wall of the closed prism over the horizon, past all depths of the faults.

    Its triangles stand over the horizon's own boundary edges, and its vertices over the boundary nodes, x and
    y equal to the bit, so that the horizon's boundary lies on it.

    Raises
    ------
    ModelingError
        When the boundary of the horizon bounds no area in plan.
    """
    levels = np.concatenate([horizon.vertices[:, 2], network.vertices[:, 2]])
    margin = _MARGIN * max(float(np.ptp(levels)), np.finfo(float).tiny)
    return over("W_fict", horizon, float(levels.min() - margin), float(levels.max() + margin)).wall


def wall_edges(horizon: Surface, network: Complex) -> tuple[Complex, IntArray, IntArray]:
    """Return the common refinement of the faults and W_fict, and the edges of W_i ∩ W_fict.

    Returns
    -------
    complex : Complex
        ``owner`` 0 for the faults, 1 for the wall.
    edges : (e, 2) array
        Vertex indices in it.
    faults : (e,) array
        The fault of each edge.
    """
    faults = Surface("faults", network.vertices, network.triangles)
    both = refined([faults, fictitious_fault(horizon, network)])
    edges, sides = both.edges()
    of_wall = both.owner == 1
    on_wall = np.zeros(len(edges), dtype=bool)
    on_wall[sides[of_wall]] = True
    side, owner = sides[~of_wall], network.owner[both.parent[~of_wall]]
    count = int(network.owner.max(initial=0)) + 1
    keys = np.unique((side * count + owner[:, None])[on_wall[side]])
    return both, edges[keys // count], np.asarray(keys % count, dtype=np.int64)
