"""How a subdomain ended, in words for this model (paper Sect. 7 and Table 4)."""

from __future__ import annotations

from dataclasses import dataclass

from graben.arrays import FloatArray
from graben.model import Fault, Model
from graben.modeling.iteration import Outcome
from graben.modeling.movement import Role
from graben.modeling.results import Side, Termination, TerminationType
from graben.modeling.shortfall import shortfall

_SIDES = {1: Side.HANGING, -1: Side.FOOT}
_NAMES = {
    TerminationType.STAGNATION: "stagnation",
    TerminationType.PROJECTION_FAILURE: "projection failure",
    TerminationType.VERTEX_REACHED: "vertex reached",
}


@dataclass(frozen=True, eq=False)
class Deciding:
    """The copy of a cut node that decided how a subdomain ended.

    Parameters
    ----------
    role : Role
        What it is tied to.
    faults : tuple of Fault
        The fault or faults on which its guide lies.
    sides : tuple of int
        Its lip on each: 1 hanging, -1 foot, 0 where both lips meet.
    place : (3,) array
        Where it ended, model units.
    end, tangent : (3,) arrays
        Where its guide ends on the side it went to, and how the guide would go on, per unit of elevation.
    gammas : tuple of float
        Half-width of the zone around each fault, model units.
    """

    role: Role
    faults: tuple[Fault, ...]
    sides: tuple[int, ...]
    place: FloatArray
    end: FloatArray
    tangent: FloatArray
    gammas: tuple[float, ...]


def termination(outcome: Outcome, model: Model, deciding: Deciding | None) -> Termination:
    """Return the termination of a subdomain with its place and the advice of the paper's Table 4.

    Parameters
    ----------
    outcome : Outcome
        Where the iteration ended.
    model : Model
        For its unit and parameters.
    deciding : Deciding or None
        The node that decided; None for type 0.
    """
    if deciding is None:
        return Termination(TerminationType.CONVERGED, "converged")
    if outcome.type is TerminationType.STAGNATION:
        return _restless(outcome, model, deciding)
    return _short(outcome, model, deciding)


def _restless(outcome: Outcome, model: Model, deciding: Deciding) -> Termination:
    """Return the termination of type 1."""
    p, fault, side = model.parameters, deciding.faults[0].name, _SIDES.get(deciding.sides[0])
    lip = f"The {'cut' if side is None else side.value + ' lip'} of {fault}"
    full = len(outcome.history) >= p.max_iterations
    still = f"still moved by {_length(outcome.excess, model)}"
    gamma = _length(deciding.gammas[0], model)
    if outcome.shortened:
        advice = (
            f"{lip} cannot move where it has to: triangles would turn over. Raise gamma from {gamma}, or "
            f"change theta from {p.theta:g}; look at the angle between the horizon and {fault}."
        )
    elif full:
        faster = "" if p.acceleration else " turn acceleration on,"
        advice = (
            f"{lip} {still} at iteration {len(outcome.history)}:{faster} allow more, or change theta from "
            f"{p.theta:g} or gamma from {gamma}."
        )
    else:
        faster = "" if p.acceleration else "turn acceleration on, or "
        advice = (
            f"{lip} does not come to rest and {still}: {faster}change theta from {p.theta:g} or raise gamma "
            f"from {gamma}; look at the angle between the horizon and {fault}."
        )
    x, y, z = (float(c) for c in deciding.place)
    name = "not converged" if full else _NAMES[TerminationType.STAGNATION]
    return Termination(TerminationType.STAGNATION, name, advice, fault, side, None, x, y, z)


def _short(outcome: Outcome, model: Model, deciding: Deciding) -> Termination:
    """Return the termination of type 2 or 3."""
    by = abs(outcome.excess)
    up = outcome.excess > 0
    missing = [shortfall(f.surface, deciding.end, outcome.excess, deciding.tangent) for f in deciding.faults]
    # Where two faults meet, the line ends on the rim of one of them, seldom of both.
    ended = [k for k, m in enumerate(missing) if m is not None] or [0]
    first = ended[0]
    fault, side = deciding.faults[first].name, _SIDES.get(deciding.sides[first])
    kind = TerminationType.VERTEX_REACHED
    if deciding.role is Role.FREE:
        kind = TerminationType.PROJECTION_FAILURE
    what = f"The horizon {'rises' if up else 'falls'} {_length(by, model)} {'above' if up else 'below'}"
    extend = []
    for k in ended:
        m = missing[k]
        name = deciding.faults[k].name
        extend.append(
            f"change the shape of {name}, which turns there,"
            if m is None
            else f"extend {name} {m} by at least {_length(m.length, model)},"
        )
    advice = f"{what} {_what(deciding, side)}: {' and '.join(extend)} or lower gamma from "
    advice += f"{_length(deciding.gammas[first], model)}."
    x, y, z = (float(c) for c in deciding.end)
    return Termination(kind, _NAMES[kind], advice, fault, side, by, x, y, z)


def _what(deciding: Deciding, side: Side | None) -> str:
    """Return what the horizon goes beyond: "the end of F1 on its hanging lip"."""
    names = [f.name for f in deciding.faults]
    if deciding.role is Role.JUNCTION:
        return f"the end of the line in which {' and '.join(names)} meet"
    if deciding.role is Role.TIP:
        return f"the end of the rim of {names[0]}"
    where = " on the outer boundary" if deciding.role is Role.EXIT else ""
    return f"the end of {names[0]}{where}" + ("" if side is None else f" on its {side.value} lip")


def _length(value: float, model: Model) -> str:
    return f"{value:.4g}" + ("" if model.unit == "none" else f" {model.unit}")
