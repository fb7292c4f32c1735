"""min-dip: dips of at least min_dip (paper Sect. 9); a warning under both profiles."""

from __future__ import annotations

import numpy as np

from graben.arrays import floats, ints
from graben.surface import Surface, triangle_dips
from graben.validators.context import Check, CheckContext, Defect, Severity
from graben.validators.measures import centroids, plural, smallest_angles


def _run(context: CheckContext) -> list[Defect]:
    limit = context.tolerance("min-dip", context.model.parameters.min_dip)
    return [d for d in (_fault(f.surface, limit) for f in context.faults) if d is not None]


def _fault(surface: Surface, limit: float) -> Defect | None:
    """Return the triangles that dip less than ``limit`` degrees; those without area have no dip."""
    dips = triangle_dips(surface.vertices, surface.triangles)
    bad = np.flatnonzero((dips < limit) & (smallest_angles(surface.vertices, surface.triangles) > 0))
    if not len(bad):
        return None
    places = centroids(surface.vertices, surface.triangles[bad])
    worst = int(np.argmin(dips[bad]))
    verb = "dips" if len(bad) == 1 else "dip"
    return Defect(
        (surface.name,),
        f"{plural(len(bad), 'triangle')} of {surface.name} {verb} less than {limit:g} degrees.",
        "Look at the place in the report: where the horizon dips against the fault, the plain iteration may "
        "not converge.",
        count=len(bad),
        value=float(dips[bad[worst]]),
        unit="degrees",
        place=places[worst],
        elements=ints(bad),
        places=floats(places, -1, 3),
        severity=Severity.WARN,
    )


CHECK = Check(
    "min-dip",
    "9",
    "Every triangle of a fault dips at least min_dip.",
    faults_only=True,
    repairable=True,
    tolerance="least dip, degrees; before [parameters] min_dip",
    run=_run,
)
