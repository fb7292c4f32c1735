"""horizon: the horizon is fit to be cut, and what a person wants to know of it before it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from graben.arrays import floats, ints
from graben.finding import Element
from graben.validators.context import Check, CheckContext, Defect, Need, Tolerance
from graben.validators.horizon_advice import (
    Pair,
    filled_elsewhere,
    filled_holes,
    hole_parts,
    nearly_parallel,
    pairs_of,
    stray_picks,
    wide_smear,
)
from graben.validators.measuring.holes import distances, holes_of

#: Slope of a horizon along a fault's dip over the fault's own, from which on they are nearly parallel.
NEARLY_PARALLEL = 0.8


#: Distance in steps up to which a hole lies on a trace: above the rounding of coordinates.
_ON = 1e-3


def _run(context: CheckContext) -> list[Defect]:
    limit = context.tolerance("horizon", NEARLY_PARALLEL)
    found = []
    for horizon, graph in context.traced():
        holes = holes_of(horizon, graph)
        pairs = pairs_of(context, horizon, graph, holes)
        near = {hole for pair in pairs for hole in pair.holes}
        found += filled_elsewhere(horizon, [h for h in holes if h not in near], context.unit)
        for pair in pairs:
            # the gravest first: it gives the finding its place
            defects = [
                *_holes(pair),
                *nearly_parallel(pair, limit),
                *stray_picks(pair),
                *wide_smear(pair),
                *filled_holes(pair),
            ]
            if defects:
                found.append(_joined(defects))
    return found


def _joined(defects: Sequence[Defect]) -> Defect:
    """Return one defect of several: the first, with what the others say and show."""
    picks = [d for d in defects if d.element is Element.PICK]
    return replace(
        defects[0],
        message=" ".join(d.message for d in defects),
        places=floats(np.concatenate([d.places for d in defects]), -1, 3),
        paths=tuple(path for d in defects for path in d.paths),
        parts=tuple(part for d in defects for part in d.parts),
        elements=picks[0].elements if picks else ints([]),
        element=Element.PICK if picks else Element.NONE,
    )


def _holes(pair: Pair) -> list[Defect]:
    """Return the holes within gamma of the trace that nothing will fill, as one defect."""
    near = [hole for hole in pair.holes if not hole.filled]
    if not near:
        return []
    horizon, fault = pair.objects
    places = floats([hole.place(pair.trace, pair.horizon.step) for hole in near], -1, 3)
    closest = float(distances(near, pair.trace).min())
    where = f"{pair.length(closest)} from it" if closest > _ON * pair.horizon.step else "on it"
    many, most, nearest = "a hole", "", "and"
    if len(near) > 1:
        many, most, nearest = f"{len(near)} holes", "up to ", "and the nearest"
    defect = Defect(
        pair.objects,
        f"{horizon} has {many} within gamma ({pair.length(pair.gamma)}) of the trace of {fault}, {most}"
        f"{pair.length(near[0].width)} across {nearest} {where}.",
        "Give the horizon values there, on each side of the fault from that side alone.",
        count=len(near),
        value=near[0].width,
        unit=pair.unit,
        place=places[0],
        places=places,
        parts=hole_parts("hole", near, places, pair.unit),
    )
    return [defect]


CHECK = Check(
    "horizon",
    "3.2",
    "The horizon is defined around its traces and not nearly parallel to a fault.",
    "Throws come from the horizon just beyond gamma of a trace, on its side: where that is missing, on the "
    "wrong side or runs along the fault, the throw is a guess.",
    _run,
    need=Need.GRAPH,
    long=True,
    leniency="filled holes, near-parallel stretches, stray picks and a gamma less than the smear warn",
    tolerance=Tolerance(
        "least slope of a horizon along a fault's dip, over the fault's own, that is nearly parallel",
        "ratio",
        f"{NEARLY_PARALLEL:g}",
        lambda model: [NEARLY_PARALLEL],
    ),
)
