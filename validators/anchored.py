"""anchored: every subdomain has three fixed nodes that are not in one line."""

from __future__ import annotations

from collections.abc import Sequence

from graben.arrays import floats, ints
from graben.finding import Element, Part
from graben.validators.context import Anchoring, Check, CheckContext, Defect, Need, Scope
from graben.words import plural


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
            found.append(_defect(horizon.name, loose, context.unit))
    return found


def _defect(horizon: str, loose: Sequence[Anchoring], unit: str) -> Defect:
    """Return the subdomains of a horizon that nothing holds."""
    worst = min(loose, key=lambda a: a.fixed)
    faults = ", ".join(dict.fromkeys(name for a in loose for name in a.faults))
    between = f" {'between' if ',' in faults else 'beside'} {faults}" if faults else ""
    verb = "has" if len(loose) == 1 else "have"
    return Defect(
        (horizon,),
        f"{plural(len(loose), 'subdomain')} of {horizon}{between} {verb} fewer than three fixed nodes "
        "off one line.",
        _remedy(loose, faults, unit),
        count=len(loose),
        value=float(worst.fixed),
        unit="fixed nodes",
        place=floats(worst.place),
        elements=ints([a.subdomain for a in loose]),
        element=Element.SUBDOMAIN,
        places=floats([a.place for a in loose], -1, 3),
        parts=tuple(_part(horizon, a) for a in loose),
    )


def _remedy(loose: Sequence[Anchoring], faults: str, unit: str) -> str:
    """Return what to do: the gamma that would leave enough nodes fixed, where there is one."""
    needed = min(a.gamma for a in loose)
    length = f" {unit}" if unit else ""
    if needed > 0:
        mend = f"Set gamma below {needed:.2g}{length} for {faults}, or extend the horizon there"
    else:
        mend = "Use a smaller step, or change the faults or the horizon so that it is wider"
    return f"{mend}; it is left as it is until then."


def _part(horizon: str, loose: Anchoring) -> Part:
    """Return one subdomain, with the number of its fixed nodes."""
    x, y, z = (float(c) for c in loose.place)
    return Part("subdomain", 1, (x, y, z), float(loose.fixed), "fixed nodes", (horizon, *loose.faults))


CHECK = Check(
    "anchored",
    "3.3",
    "Every subdomain has at least three fixed nodes that are not in one line.",
    "With fewer the energy has no single minimum: the part could tilt or float.",
    _run,
    need=Need.ANCHORS,
    scope=Scope.HORIZON,
    blocks_when="a horizon that cannot be cut into subdomains",
)
