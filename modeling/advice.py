"""How a subdomain ended, in words for this model (paper Sect. 7 and Table 4)."""

from __future__ import annotations

from graben.arrays import FloatArray
from graben.model import Model
from graben.modeling.iteration import Outcome
from graben.modeling.movement import Role
from graben.modeling.results import Side, Termination, TerminationType

_WHAT = {
    Role.FREE: "the fault surface",
    Role.TIP: "the rim of the fault",
    Role.EXIT: "the fault's line on the outer boundary",
    Role.JUNCTION: "the line where the faults meet",
}


def termination(
    outcome: Outcome,
    model: Model,
    role: Role | None,
    owner: tuple[str, int] | None,
    place: FloatArray | None,
) -> Termination:
    """Return the termination of a subdomain with its place and the advice of the paper's Table 4.

    Parameters
    ----------
    outcome : Outcome
        Where the iteration ended.
    model : Model
        For its unit and parameters.
    role, owner, place
        For types 2 and 3: what the deciding node is tied to, its fault and side (1 hanging, -1 foot), and
        where it ended, (3,), model units.
    """
    if outcome.type is TerminationType.CONVERGED:
        return Termination(TerminationType.CONVERGED, "converged")
    if role is None or owner is None or place is None:
        full = len(outcome.history) >= model.parameters.max_iterations
        if full:
            left = f"The boundary still moved by {outcome.history[-1]:.3g} at the last iteration: allow more."
            return Termination(TerminationType.STAGNATION, "not converged", left)
        return Termination(
            TerminationType.STAGNATION,
            "stagnation",
            "The boundary does not come to rest: change theta or gamma, and look at the angle between the "
            "horizon and its faults.",
        )
    fault, number = owner
    unit = "" if model.unit == "none" else f" {model.unit}"
    way = "upwards" if outcome.excess > 0 else "downwards"
    by = abs(outcome.excess)
    kind = TerminationType.PROJECTION_FAILURE if role is Role.FREE else TerminationType.VERTEX_REACHED
    names = {
        TerminationType.PROJECTION_FAILURE: "projection failure",
        TerminationType.VERTEX_REACHED: "vertex reached",
    }
    advice = (
        f"The horizon needs {_WHAT[role]} {by:.4g}{unit} further {way}: extend {fault} there by at least "
        f"that much in elevation, or lower gamma."
    )
    side = {1: Side.HANGING, -1: Side.FOOT}.get(number)
    x, y, z = (float(c) for c in place)
    return Termination(kind, names[kind], advice, fault, side, by, x, y, z)
