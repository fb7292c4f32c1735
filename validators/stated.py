"""What model.toml and the files state of their numbers: other units, and a sign of z that is assumed."""

from __future__ import annotations

from collections.abc import Sequence

from graben.validators.context import CheckContext, Defect, Severity
from graben.words import listed, plural


def other_units(context: CheckContext) -> list[Defect]:
    """Return a warning for each file that states another unit of length than the model has."""
    unit = context.unit
    if not unit:
        return []
    found = []
    for statement in context.model.statements:
        others = [u for u in statement.units if u != unit]
        if others:
            given = f"is {unit}" + (" (the default)" if "unit" in context.model.left_out else "")
            name, first = statement.file.name, statement.names[0]
            held = first if len(statement.names) == 1 else plural(len(statement.names), "surface")
            message = f"{name} ({held}) states the unit {others[0]}, but that of the model {given}."
            mend = f'Set unit = "{others[0]}" under [model], or convert the numbers of {name} to {unit}.'
            found.append(_warning((first,), message, mend))
    return found


def assumed_sign(context: CheckContext) -> list[Defect]:
    """Return the warning that numbers which may be depths are taken for elevations, since z is left out."""
    silent = [s for s in context.model.statements if not s.signed]
    if "z" not in context.model.left_out or not silent or not all(s.low > 0 for s in silent):
        return []
    names = tuple(name for s in silent for name in s.names)
    counts = "counts" if len(names) == 1 else "count"
    message = (
        f"z is left out under [model], so {listed(names)} {counts} as elevation, positive up; but every z "
        "there is positive, as depths are."
    )
    mend = 'Set z = "depth" under [model] if these are depths, else z = "elevation".'
    return [_warning(names, message, mend)]


def _warning(names: Sequence[str], message: str, remedy: str) -> Defect:
    return Defect(tuple(names), message, remedy, count=len(names), severity=Severity.WARN)
