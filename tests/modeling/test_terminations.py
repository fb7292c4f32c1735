"""How a subdomain ends: each type of termination with its place and advice, and that the advice serves."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from graben.model import Fault, Model
from graben.modeling import iteration
from graben.modeling.iteration import _PATIENCE, _oscillates
from graben.modeling.results import Side, Subdomain, Termination, TerminationType
from graben.modeling.shortfall import shortfall
from graben.pipeline import build
from graben.surface import Surface
from tests.models import grid_horizon, grid_triangles, model_of, plane_fault

THROW = 120.0
DIP = 60.0
#: Rows of a fault whose rim is cut to a shape, and how deep it goes, m.
ROWS, DEEP = 17, -400.0
#: The advice is as exact as its four digits.
DIGITS = 1e-3

Top = Callable[[np.ndarray], np.ndarray]


def smeared(slope: float = 0.0, throw: float = THROW, width: float = 60.0) -> Callable[..., np.ndarray]:
    """A horizon with a smeared throw along x = 0 that dies out at y = -1500 and 1500."""

    def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        taper = np.maximum(1 - (y / 1500.0) ** 2, 0) ** 1.5
        return slope * x - throw / 2 * np.tanh(x / width) * taper

    return height


def lasting(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A horizon with the same smeared throw all along x = 0."""
    return -THROW / 2 * np.tanh(x / 60.0) + 0.0 * y


def sunken(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A level horizon that looks lower than it is, by 60 m, around the line from y = -1000 to 1000."""
    beyond = np.maximum(np.abs(y) - 1000.0, 0.0)
    return -60.0 * np.exp(-(x**2 + beyond**2) / 120.0**2)


def cut_off(top: Top, first: float, last: float) -> Fault:
    """A fault through x = 0, z = 0, of dip 60, whose upper edge lies at elevation ``top`` of y."""
    # With a column on each corner that the tests give to the edge.
    near = np.concatenate([south + np.arange(0.0, 100.0, 10.0) for south in (-2000.0, -1000.0)])
    y = np.unique(np.concatenate([np.linspace(first, last, 41), near]))
    y = y[(y >= first) & (y <= last)]
    z = DEEP + np.linspace(0.0, 1.0, ROWS) * (top(y)[:, None] - DEEP)
    yy = np.broadcast_to(y[:, None], z.shape)
    points = np.stack([-z / np.tan(np.radians(DIP)), yy, z], axis=-1)
    return Fault(Surface("F1", points.reshape(-1, 3), grid_triangles(len(y), ROWS)))


def ended(model: Model) -> tuple[Subdomain, ...]:
    (horizon,) = build(model, mend=False).horizons
    return horizon.subdomains


def only(model: Model, kind: TerminationType) -> Termination:
    """Return the termination of this type; no subdomain ends with another than this and type 0."""
    found = [s.termination for s in ended(model) if s.termination.type is not TerminationType.CONVERGED]
    assert found
    assert {t.type for t in found} == {kind}
    return max(found, key=lambda t: t.short_by or 0.0)


def advised(termination: Termination, words: str) -> float:
    """Return the length by which the advice says to extend; ``words`` are the fault, the way and the end."""
    found = re.search(f"extend {words} by at least ([0-9.e+]+) m, or lower gamma from", termination.advice)
    assert found, termination.advice
    return float(found[1])


def test_type_1_is_a_real_oscillation() -> None:
    """The plain iteration on a fault of 12 degrees against a horizon of 0.25 grows with each step."""
    fault = plane_fault((0, -1500), (0, 1500), dip=12.0)
    horizon = grid_horizon(smeared(0.25, 60.0, 100.0), size=6000.0)
    plain = model_of(horizon, fault, gamma=500.0, acceleration=False)
    (subdomain,) = ended(plain)
    t = only(plain, TerminationType.STAGNATION)
    assert t.name == "stagnation"
    assert subdomain.iterations == _PATIENCE + 1
    assert min(subdomain.history[1:]) > subdomain.history[0]
    assert (t.fault, t.side) in {("F1", Side.HANGING), ("F1", Side.FOOT)}
    assert t.short_by is None
    assert t.y == pytest.approx(0.0, abs=300.0), "the largest throw is in the middle"
    amount = re.search(r"still moved by ([0-9.]+) m: turn acceleration on", t.advice)
    assert amount
    assert float(amount[1]) == pytest.approx(subdomain.history[-1], rel=DIGITS)
    assert "change theta from 0.5 or raise gamma from 500 m" in t.advice
    fast = replace(plain, parameters=plain.parameters.model_copy(update={"acceleration": True}))
    (mended,) = ended(fast)
    assert mended.termination.type is TerminationType.CONVERGED
    assert mended.iterations < _PATIENCE


def test_a_step_uphill_is_no_oscillation() -> None:
    assert not _oscillates([1.0, 5.0, 2.0])
    assert not _oscillates([1.0] + [5.0] * (_PATIENCE - 1) + [0.9])
    assert _oscillates([1.0] + [5.0] * _PATIENCE)


def test_type_1_after_the_last_iteration_says_so() -> None:
    fault = plane_fault((0, -1500), (0, 1500), dip=20.0)
    horizon = grid_horizon(smeared(0.25, 60.0, 100.0), size=6000.0)
    t = only(
        model_of(horizon, fault, gamma=500.0, acceleration=False, max_iterations=5),
        TerminationType.STAGNATION,
    )
    assert t.name == "not converged"
    assert t.fault == "F1"
    assert "at iteration 5: turn acceleration on, allow more" in t.advice


@pytest.mark.parametrize(
    ("course", "expected"),
    [
        ([8.0, 9.0], False),
        ([8.0, 9.0, 4.0, 5.0, 2.0, 3.0, 1.0, 1.5, 0.5, 0.6], False),
        ([8.0] + 7 * [9.0], False),
        ([8.0] + 8 * [9.0], True),
        (5 * [4.0, 3.0], True),
        ([2.0**k for k in range(9)], True),
        ([0.9**k for k in range(40)], False),
        (12 * [0.0], True),
    ],
)
def test_oscillation_needs_many_steps_without_gain(course: list[float], expected: bool) -> None:
    assert _oscillates(course) is expected


def test_type_2_says_where_and_how_far() -> None:
    """The upper edge lies 30 m above the trace, the foot lip needs about 60."""

    def model(top: float) -> Model:
        return model_of(grid_horizon(smeared()), cut_off(lambda y: 0 * y + top, -1500.0, 1500.0))

    t = only(model(30.0), TerminationType.PROJECTION_FAILURE)
    assert (t.name, t.fault, t.side) == ("projection failure", "F1", Side.FOOT)
    assert (t.x, t.z) == pytest.approx((-30.0 / np.tan(np.radians(DIP)), 30.0), abs=1e-6)
    assert t.y == pytest.approx(0.0, abs=300.0), "the largest throw is in the middle"
    length = advised(t, "F1 upwards")
    assert length * np.sin(np.radians(DIP)) == pytest.approx(t.short_by, rel=DIGITS)
    more = length * np.sin(np.radians(DIP))
    assert all(s.termination.type is TerminationType.CONVERGED for s in ended(model(30.0 + more)))
    assert only(model(30.0 + 0.9 * more), TerminationType.PROJECTION_FAILURE).short_by == pytest.approx(
        0.1 * more, rel=0.05
    )


def low_in_the_south(by: float, south: float) -> Top:
    """An upper edge that lies at ``by`` for 50 m in the south and rises to 300 m before the next node."""
    return lambda y: np.interp(y, [south, south + 50.0, south + 90.0], [by, by, 300.0])


@pytest.mark.parametrize(
    ("height", "first", "last", "what", "side"),
    [
        (sunken, -1000.0, 1000.0, "the end of the rim of F1:", None),
        (lasting, -2600.0, 2600.0, "the end of F1 on the outer boundary on its foot lip:", Side.FOOT),
    ],
    ids=["tip", "exit"],
)
def test_type_3_says_which_end(
    height: Callable[..., np.ndarray], first: float, last: float, what: str, side: Side | None
) -> None:
    """The guide of the southern end of the cut ends too early, all others reach far enough."""
    south = max(first, -2000.0)
    start = -40.0 if height is sunken else 20.0

    def model(top: float) -> Model:
        return model_of(grid_horizon(height), cut_off(low_in_the_south(top, south), first, last))

    t = only(model(start), TerminationType.VERTEX_REACHED)
    assert (t.name, t.fault, t.side) == ("vertex reached", "F1", side)
    assert what in t.advice
    assert (t.y, t.z) == pytest.approx((south, start), abs=1e-6)
    assert (t.short_by or 0) > 20.0
    length = advised(t, "F1 upwards at its southern end")
    assert length > 0
    mended = ended(model(start + (1 + DIGITS) * (t.short_by or 0)))
    assert all(s.termination.type is TerminationType.CONVERGED for s in mended)


def test_type_3_at_a_junction_names_the_fault_that_ends() -> None:
    """F2 crosses F1; its upper edge has a notch there, narrower than the distance of two nodes."""
    across = plane_fault((-1500, 0), (1500, 0), dip=88.0, name="F2").surface

    def model(top: float) -> Model:
        x = np.unique(np.concatenate([np.linspace(-1500.0, 1500.0, 41), np.linspace(-80.0, 80.0, 17)]))
        edge = np.interp(x, [-80.0, -40.0, 40.0, 80.0], [300.0, top, top, 300.0])
        z = DEEP + np.linspace(0.0, 1.0, ROWS) * (edge[:, None] - DEEP)
        xx = np.broadcast_to(x[:, None], z.shape)
        points = np.stack([xx, -z / np.tan(np.radians(88.0)), z], axis=-1).reshape(-1, 3)
        notched = Fault(replace(across, vertices=points, triangles=grid_triangles(len(x), ROWS)))
        return model_of(grid_horizon(smeared()), plane_fault((0, -1500), (0, 1500), dip=88.0), notched)

    t = only(model(45.0), TerminationType.VERTEX_REACHED)
    assert (t.name, t.fault) == ("vertex reached", "F2")
    assert t.side in (Side.HANGING, Side.FOOT)
    assert "the end of the line in which F1 and F2 meet" in t.advice
    assert t.z == pytest.approx(45.0, abs=1e-6)
    advised(t, "F2 upwards")
    mended = ended(model(45.0 + (1 + DIGITS) * (t.short_by or 0)))
    assert all(s.termination.type is TerminationType.CONVERGED for s in mended)


def test_a_shortage_on_the_way_is_none_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """What lies beyond its guide while others still move may come back: the fixed point decides."""
    model = model_of(grid_horizon(smeared()), plane_fault((0, -1500), (0, 1500)))
    (calm,) = ended(model)
    claimed = iter([0])
    monkeypatch.setattr(iteration, "_short", lambda excess, before, tolerance: next(claimed, -1))
    (alarmed,) = ended(model)
    assert alarmed.termination.type is TerminationType.CONVERGED
    assert alarmed.iterations == 1 + calm.iterations
    assert alarmed.history[1:] == pytest.approx(calm.history, abs=1e-9)


NORTH = np.array([0.0, 1.0, 0.0])
#: The dip line of a fault of 30 degrees that dips east, per unit of rise.
UP = np.array([-np.sqrt(3.0), 0.0, 1.0])


@pytest.mark.parametrize(
    ("place", "rise", "tangent", "length", "words"),
    [
        (400.0 * UP, 10.0, UP, 20.0, "upwards"),
        (400.0 * UP + 700.0 * NORTH, 10.0, UP, 20.0, "upwards at its northern end"),
        (-400.0 * UP - 700.0 * NORTH, -10.0, UP, 20.0, "downwards at its southern end"),
        (100.0 * UP + 1000.0 * NORTH, 10.0, UP + 3.0 * NORTH, 30.0, "at its northern end"),
        (400.0 * UP, 10.0, 0.0 * UP, 20.0, "upwards"),
    ],
)
def test_shortfall_is_measured_across_the_rim(
    place: np.ndarray, rise: float, tangent: np.ndarray, length: float, words: str
) -> None:
    fault = plane_fault((0, -1000), (0, 1000), dip=30.0).surface
    found = shortfall(fault, place, rise, tangent)
    assert found is not None
    assert found.length == pytest.approx(length)
    assert str(found) == words


@pytest.mark.parametrize(
    ("place", "rise"),
    [(0.0 * UP, 10.0), (400.0 * UP, -10.0), (-400.0 * UP, 10.0)],
    ids=["inside", "back", "in"],
)
def test_no_shortfall_where_the_fault_goes_on(place: np.ndarray, rise: float) -> None:
    assert shortfall(plane_fault((0, -1000), (0, 1000), dip=30.0).surface, place, rise, UP) is None
