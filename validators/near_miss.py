"""near-miss: no fault stops just short of another, or passes it by a stub."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graben.arrays import floats, ints
from graben.finding import Element, Part
from graben.validators.context import Check, CheckContext, Defect, Need, Severity, Tolerance
from graben.validators.measuring.contact import ContactKind
from graben.validators.measuring.measures import amount
from graben.validators.measuring.rim_labels import RimLabel
from graben.validators.measuring.rims import Stretch, rim_stretches
from graben.words import plural

#: How much the sizes along a finding may differ, as a share, to be told as one.
_ALIKE = 0.05


def _run(context: CheckContext) -> list[Defect]:
    network = context.evidence.complex
    faults = context.model.faults
    if network is None or len(faults) < 2:
        return []
    limits = tuple(context.tolerance("near-miss", context.model.max_extension(f)) for f in faults)
    stretches = rim_stretches(network, tuple(f.surface for f in faults), limits, context.contact)
    settled = {frozenset(c.faults) for c in context.model.contacts if c.rule in ("accept", "forbid")}
    passing = _passing(context)
    pairs: dict[tuple[str, str], list[Stretch]] = {}
    for stretch in stretches:
        pair = (stretch.fault, stretch.neighbour)
        told = stretch.label is RimLabel.GAP or (
            stretch.label is RimLabel.STUB and frozenset(pair) in passing
        )
        if told and frozenset(pair) not in settled:
            pairs.setdefault(pair, []).append(stretch)
    return [_defect(pair, own, context.unit) for pair, own in pairs.items()]


def _passing(context: CheckContext) -> set[frozenset[str]]:
    """Return the pairs of faults of which one may go on beyond the other; a touch is no passage."""
    names = [f.name for f in context.model.faults]
    return {
        frozenset(names[k] for k in contact.surfaces)
        for contact in context.evidence.contacts
        if contact.kind in (ContactKind.CROSSING, ContactKind.EDGE, ContactKind.AREA)
    }


def _defect(pair: tuple[str, str], stretches: Sequence[Stretch], unit: str) -> Defect:
    """Return what one fault leaves open towards another, a part for each stretch of its rim."""
    gaps = [s for s in stretches if s.label is RimLabel.GAP]
    stubs = [s for s in stretches if s.label is RimLabel.STUB]
    sentences = []
    if gaps:
        sentences.append(f"{pair[0]} ends {_sizes(gaps, unit)} short of {pair[1]}, {_along(gaps, unit)}.")
    if stubs:
        sentences.append(f"{pair[0]} ends {_sizes(stubs, unit)} beyond {pair[1]}, {_along(stubs, unit)}.")
    remedies = [
        *([f"Extend {pair[0]} to {pair[1]}"] if gaps else []),
        *(
            [f"cut {pair[0]} back to {pair[1]}" if gaps else f"Cut {pair[0]} back to {pair[1]}"]
            if stubs
            else []
        ),
    ]
    worst = _worst(gaps or stubs)
    return Defect(
        pair,
        " ".join([*sentences, *_which(gaps or stubs, unit)]),
        f"{', and '.join(remedies)}; where it is meant so, accept the pair under [[contacts]].",
        count=len(stretches),
        value=worst.size,
        unit=unit,
        place=worst.place,
        elements=ints(np.unique(np.concatenate([s.triangles for s in stretches]))),
        element=Element.TRIANGLE,
        places=floats([s.place for s in stretches], -1, 3),
        paths=tuple(s.path for s in stretches),
        parts=tuple(_part(s, unit) for s in stretches),
    )


def _worst(stretches: Sequence[Stretch]) -> Stretch:
    """Return the narrowest of gaps, the longest of stubs."""
    sign = -1.0 if stretches[0].label is RimLabel.GAP else 1.0
    return max(stretches, key=lambda s: sign * s.size)


def _part(stretch: Stretch, unit: str) -> Part:
    x, y, z = (float(c) for c in stretch.place)
    return Part(str(stretch.label), 1, (x, y, z), stretch.size, unit)


def _sizes(stretches: Sequence[Stretch], unit: str) -> str:
    least, greatest = min(s.least for s in stretches), max(s.greatest for s in stretches)
    if greatest - least <= _ALIKE * greatest:
        return amount(_worst(stretches).size, unit)
    return f"{amount(least)} to {amount(greatest, unit)}"


def _which(stretches: Sequence[Stretch], unit: str) -> list[str]:
    """Return the sentence that says which of several sizes stands as the worst, with its place."""
    least, greatest = min(s.least for s in stretches), max(s.greatest for s in stretches)
    if greatest - least <= _ALIKE * greatest:
        return []
    told = "least distance" if stretches[0].label is RimLabel.GAP else "longest part"
    return [f"The worst given is the {told}, {amount(_worst(stretches).size, unit)}."]


def _along(stretches: Sequence[Stretch], unit: str) -> str:
    total = sum(s.length for s in stretches)
    where = "along" if len(stretches) == 1 else f"in {plural(len(stretches), 'stretch', 'stretches')} of"
    return f"{where} {amount(total, unit)} of its rim"


CHECK = Check(
    "near-miss",
    "3.2",
    "No fault stops just short of another or passes it by a stub.",
    "A gap leaves a bridge of rock that is rarely meant, and a stub adds a cut too short to have a throw.",
    _run,
    need=Need.COMPLEX,
    faults_only=True,
    severity=Severity.WARN,
    tolerance=Tolerance(
        "widest gap and longest stub",
        "model units",
        "[repair] max_extension",
        lambda model: [model.max_extension(f) for f in model.faults],
    ),
    repairable=True,
)
