"""anchored: every subdomain has three fixed nodes that are not in one line."""

from __future__ import annotations

from collections.abc import Sequence

from graben.arrays import floats, ints
from graben.validators.context import Anchoring, Check, CheckContext, Defect, Need
from graben.validators.measures import plural


def _run(context: CheckContext) -> list[Defect]:
    evidence = context.evidence
    found = []
    for horizon in context.horizons:
        if horizon.name in evidence.graphs and horizon.name in evidence.errors:
            reason = evidence.errors[horizon.name]
            found.append(
                Defect(
                    (horizon.name,),
                    f"{horizon.name} could not be cut into subdomains: {reason}",
                    "Look at the faults that meet at that place.",
                    blocks=True,
                )
            )
        loose = [a for a in evidence.anchors.get(horizon.name, ()) if not a.holds]
        if loose:
            found.append(_defect(horizon.name, loose))
    return found


def _defect(horizon: str, loose: Sequence[Anchoring]) -> Defect:
    """Return the subdomains of a horizon that nothing holds."""
    worst = min(loose, key=lambda a: a.fixed)
    faults = ", ".join(dict.fromkeys(name for a in loose for name in a.faults))
    between = f" between {faults}" if faults else ""
    verb = "has" if len(loose) == 1 else "have"
    return Defect(
        (horizon,),
        f"{plural(len(loose), 'subdomain')} of {horizon}{between} {verb} fewer than three fixed nodes "
        "off one line.",
        "Reduce gamma for these faults, or extend the horizon there; it is left as it is until then.",
        count=len(loose),
        value=float(worst.fixed),
        unit="fixed nodes",
        place=floats(worst.place),
        elements=ints([a.subdomain for a in loose]),
        places=floats([a.place for a in loose], -1, 3),
    )


CHECK = Check(
    "anchored",
    "3.3",
    "Every subdomain has at least three fixed nodes that are not in one line.",
    need=Need.ANCHORS,
    run=_run,
)
