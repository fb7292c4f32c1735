"""simplicial-complex: the faults form one complex (paper Sect. 3.2, condition 1)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from graben.arrays import floats, ints
from graben.finding import Element, Part
from graben.validators.context import CONTACT, Check, CheckContext, Defect, Need, Scope, Severity, Tolerance
from graben.validators.measuring.contact import Contact, ContactKind
from graben.validators.measuring.leaving import broken_by_holes
from graben.validators.measuring.measures import amount, part_at
from graben.words import plural

#: What the condition asks for: a vertex or an edge that both have.
_CONFORMING = (ContactKind.EDGE, ContactKind.VERTEX)
#: The kinds from the gravest to the mildest: the first that occurs gives the finding its place and remedy.
_GRAVEST = (ContactKind.AREA, ContactKind.T, ContactKind.LINE, ContactKind.POINT, ContactKind.CROSSING)
_REMEDIES = {
    ContactKind.AREA: "Take the common part out of one of the two, or keep only one of them.",
    ContactKind.T: "Split the triangles along the rim, so that both faults have it as the same edges, or "
    "move the rim clearly off the other fault.",
    ContactKind.LINE: "Move the two apart, or let one pass through the other.",
    ContactKind.POINT: "Move the two apart, or let one pass through the other.",
    ContactKind.CROSSING: "Nothing, under the profile extended; else split the triangles of both along the "
    "line, so that they have it as the same edges.",
}
#: A part of its own: a rim strays to both sides of the other fault, so that triangles cross after all.
WITHIN_CONTACT = "crossing within the contact distance"
#: A gap in the line in which a fault meets the wall over a horizon's boundary, in contact distances.
_GAP = 100.0


def _run(context: CheckContext) -> list[Defect]:
    reason = context.evidence.errors.get("")
    if reason is not None:
        return [_not_refined(context, reason)]
    by_pair = groupby(context.evidence.contacts, key=lambda c: c.surfaces)
    found = [_pair(context, tuple(contacts)) for _, contacts in by_pair]
    return [d for d in found if d is not None] + _leaving(context)


def _not_refined(context: CheckContext, reason: str) -> Defect:
    return Defect(
        tuple(f.name for f in context.model.faults),
        f"The faults could not be refined to one complex: {reason}",
        "Check the faults two by two, and take the one out with which it fails.",
        blocks=True,
    )


def _pair(context: CheckContext, contacts: Sequence[Contact]) -> Defect | None:
    """Return how two faults meet otherwise than in edges and vertices that both have, if they do."""
    contacts = [c for c in contacts if c.kind not in _CONFORMING]
    if not contacts:
        return None
    names = tuple(context.model.faults[k].name for k in contacts[0].surfaces)
    contacts.sort(key=lambda c: (_GRAVEST.index(c.kind), -c.size))
    first = contacts[0]
    said = [
        _said(kind, list(same), (names[0], names[1]), context)
        for kind, same in groupby(contacts, key=lambda c: c.kind)
    ]
    milder = all(c.kind is ContactKind.CROSSING for c in contacts)
    forbidden = any(
        set(rule.faults) == set(names) and rule.rule == "forbid" for rule in context.model.contacts
    )
    said += ["[[contacts]] forbids the two to meet."] if forbidden else []
    return Defect(
        names,
        " ".join(said),
        _REMEDIES[first.kind],
        count=sum(c.count for c in contacts),
        value=first.size,
        unit=_unit(first.kind, context.unit),
        place=first.places[0],
        elements=ints(np.unique(np.concatenate([c.triangles[0] for c in contacts]))),
        element=Element.TRIANGLE,
        places=floats(np.concatenate([c.places for c in contacts])),
        paths=tuple(path for c in contacts for path in c.paths),
        parts=_parts(contacts, context.unit),
        severity=Severity.RELAXED if milder and not forbidden else None,
    )


def _parts(contacts: Sequence[Contact], unit: str) -> tuple[Part, ...]:
    parts = [part_at(str(c.kind), c.count, c.places[0], c.size, _unit(c.kind, unit)) for c in contacts]
    strays = [c for c in contacts if c.passing > 0]
    return tuple(parts + [part_at(WITHIN_CONTACT, 1, c.places[0], c.passing, unit) for c in strays])


def _said(
    kind: ContactKind, contacts: Sequence[Contact], names: tuple[str, str], context: CheckContext
) -> str:
    """Return one sentence about the contacts of one kind of two faults."""
    title = f"{names[0]} and {names[1]}"
    size = amount(sum(c.size for c in contacts), _unit(kind, context.unit))
    lines = f"one line of {size}" if len(contacts) == 1 else f"{len(contacts)} lines of {size} in all"
    if kind is ContactKind.CROSSING:
        pairs = plural(sum(c.count for c in contacts), "pair")
        return f"{title} cross properly in {pairs} of triangles along {lines}."
    if kind is ContactKind.T:
        rims = {context.model.faults[k].name for c in contacts for k in c.rims}
        ending = [name for name in names if name in rims]
        if len(ending) == 1:
            other = names[1 - names.index(ending[0])]
            text = f"The rim of {ending[0]} lies on {other} along {lines}, not in edges of {other}"
        else:
            text = f"The rims of {title} lie on each other along {lines}, not in the same edges"
        if any(c.passing > 0 for c in contacts):
            text += f"; they cross there by less than {amount(context.contact, context.unit)}"
        return text + "."
    if kind is ContactKind.LINE:
        return f"{title} touch along {lines} without passing through one another."
    if kind is ContactKind.POINT:
        return f"{title} touch in {plural(len(contacts), 'point')} that they have not as a vertex."
    return f"{title} overlap over {size}."


def _unit(kind: ContactKind, unit: str) -> str:
    return f"{unit}²" if unit and kind is ContactKind.AREA else unit


def _leaving(context: CheckContext) -> list[Defect]:
    """Return the faults whose line on the wall over a horizon's boundary is broken near the horizon."""
    found = []
    for horizon in context.horizons:
        for fault in context.faults:
            gamma = context.model.gamma(fault, horizon)
            holes = broken_by_holes(horizon.surface, fault.surface, gamma, _GAP * context.contact)
            if not holes:
                continue
            gaps = [float(np.linalg.norm(ends[:, None] - ends, axis=2).max()) for ends in holes]
            widest = int(np.argmax(gaps))
            found.append(
                Defect(
                    (horizon.name, fault.name),
                    f"{fault.name} leaves the domain of {horizon.name} in a broken line: "
                    f"{plural(len(holes), 'hole')} of the fault over the horizon's boundary, up to "
                    f"{amount(gaps[widest], context.unit)} wide.",
                    "Fill the hole, or end the fault before the boundary.",
                    count=len(holes),
                    value=gaps[widest],
                    unit=context.unit,
                    place=holes[widest][0],
                    places=floats(np.concatenate(holes)),
                    parts=tuple(
                        part_at("hole over the boundary", len(ends), ends[0], gap, context.unit)
                        for ends, gap in zip(holes, gaps, strict=True)
                    ),
                    severity=Severity.RELAXED,
                )
            )
    return found


CHECK = Check(
    "simplicial-complex",
    "3.2, condition 1",
    "The faults form one simplicial complex.",
    "Where two faults meet both must hold the same edge, since a junction moves along it and both must give "
    "it the same elevation.",
    _run,
    need=Need.COMPLEX,
    severity=Severity.FAIL,
    leniency="a pair that crosses properly, meets in no other way and is not forbidden to, and a hole over a "
    "horizon's boundary, only warn under extended",
    scope=Scope.MODEL,
    blocks_when="faults that cannot be refined to one complex",
    tolerance=Tolerance(
        "distance at which two surfaces touch",
        "model units",
        "1e-6 of the model's size",
        lambda model: [CONTACT * model.size],
    ),
    repairable=True,
)
