"""min-dip: dips of at least min_dip (paper Sect. 9); a warning under both profiles."""

from __future__ import annotations

import numpy as np

from graben.arrays import floats, ints
from graben.finding import Element
from graben.surface import Surface, triangle_areas, triangle_dips
from graben.validators.context import Check, CheckContext, Defect, Severity, Tolerance
from graben.validators.measuring.measures import centroids, smallest_angles
from graben.words import plural

#: Angle below which two dips are equal, degrees: above what rounding makes of coordinates of 500 km.
ROUNDING = 1e-6


def _run(context: CheckContext) -> list[Defect]:
    limit = context.tolerance("min-dip", context.model.parameters.min_dip)
    return [d for d in (_fault(f.surface, limit) for f in context.faults) if d is not None]


def _fault(surface: Surface, limit: float) -> Defect | None:
    """Return the triangles that dip less than ``limit`` degrees; those without area have no dip."""
    dips = triangle_dips(surface.vertices, surface.triangles)
    bad = np.flatnonzero(
        (dips < limit - ROUNDING) & (smallest_angles(surface.vertices, surface.triangles) > 0)
    )
    if not len(bad):
        return None
    places = centroids(surface.vertices, surface.triangles[bad])
    worst = int(np.argmin(dips[bad]))
    verb = "dips" if len(bad) == 1 else "dip"
    areas = triangle_areas(surface.vertices, surface.triangles)
    share = 100.0 * float(areas[bad].sum() / areas.sum())
    return Defect(
        (surface.name,),
        f"{plural(len(bad), 'triangle')} of {surface.name} {verb} less than {limit:g} degrees: "
        f"{_percent(share)} of its area, down to {dips[bad[worst]]:.3g} degrees.",
        "Nothing where no horizon comes near; else keep acceleration = true, or steepen the fault there.",
        count=len(bad),
        value=float(dips[bad[worst]]),
        unit="degrees",
        place=places[worst],
        elements=ints(bad),
        element=Element.TRIANGLE,
        places=floats(places, -1, 3),
        severity=Severity.WARN,
    )


def _percent(share: float) -> str:
    """Return a share in percent for a sentence: whole above 10, two digits below, never 0 for something."""
    if share >= 10:
        return f"{share:.0f} %"
    return f"{share:.2g} %" if share >= 0.01 else "less than 0.01 %"


CHECK = Check(
    "min-dip",
    "9",
    "Every triangle of a fault dips at least min_dip.",
    "The paper's iteration contracts by the slope of the horizon over that of the fault; where both are "
    "alike it does not converge.",
    _run,
    faults_only=True,
    severity=Severity.WARN,
    tolerance=Tolerance(
        "least dip", "degrees", "[parameters] min_dip", lambda model: [model.parameters.min_dip]
    ),
)
