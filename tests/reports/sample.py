"""A rebuilt horizon made by hand: one fault with known lips, for reports without a solver."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from graben.arrays import FloatArray, IntArray
from graben.cleaning.ledger import RepairAction
from graben.cutgraph import CutGraph, NodeKind
from graben.finding import CheckResult, Finding, Profile, Status, Worst
from graben.model import Fault, GridGeometry, Horizon, Model
from graben.modeling.quality import judged
from graben.modeling.results import (
    Cutoff,
    Error,
    HorizonResult,
    Score,
    Side,
    Subdomain,
    Termination,
    TerminationType,
)
from graben.pipeline import RunResult
from graben.settings import Parameters
from graben.surface import Surface

CONVERGED = Termination(TerminationType.CONVERGED, "converged")
SIZE, STEP, GAMMA = 6000.0, 100.0, 400.0
TAN_DIP = np.tan(np.radians(60.0))
ORIGIN = (432_000.0, 6_780_000.0)
STAGES = ("check", "repair", "triangulate", "solve", "move", "deform", "write", "total", "per_iteration")
EVIL = '<script>alert("F1")</script> & $x$'


def regional(y: FloatArray) -> FloatArray:
    return np.asarray(-2000.0 + 0.05 * (y - ORIGIN[1]) + 25.0 * np.cos((y - ORIGIN[1]) / 900.0))


def trace(y: FloatArray) -> FloatArray:
    return np.asarray(ORIGIN[0] + 3000.0 + 120.0 * np.sin((y - ORIGIN[1]) / 1100.0))


def throw_at(y: FloatArray, throw: float) -> FloatArray:
    r = np.clip((y - ORIGIN[1] - 3000.0) / 2000.0, -1.0, 1.0)
    return np.asarray(throw * (1.0 - r**2) ** 1.5)


def grid_triangles(columns: int, rows: int) -> IntArray:
    i = (np.arange(columns - 1)[:, None] * rows + np.arange(rows - 1)).ravel()
    lower = np.stack([i, i + rows, i + rows + 1], axis=1)
    upper = np.stack([i, i + rows + 1, i + 1], axis=1)
    return np.concatenate([lower, upper])


def fault(name: str = "F1") -> Fault:
    """A surface that dips 60 degrees to the east and meets the regional horizon along the trace."""
    y = ORIGIN[1] + np.linspace(1000.0, 5000.0, 41)
    dz = np.linspace(400.0, -400.0, 11)
    yy, zz = np.meshgrid(y, dz, indexing="ij")
    points = np.stack([trace(yy) - zz / TAN_DIP, yy, regional(yy) + zz], axis=-1).reshape(-1, 3)
    return Fault(Surface(name, points, grid_triangles(41, 11)), GAMMA)


def input_horizon(name: str = "Top A", throw: float = 138.0) -> Horizon:
    """The smeared horizon on a regular grid."""
    count = int(SIZE / STEP) + 1
    grid = GridGeometry(count, count, STEP, STEP, ORIGIN)
    x, y = np.moveaxis(grid.nodes(), -1, 0)
    d = x - trace(y)
    z = regional(y) - 0.5 * throw_at(y, throw) * np.tanh(d / 150.0) * np.exp(-((d / 1500.0) ** 2))
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    return Horizon(name, Surface(name, points, grid_triangles(count, count)), STEP, grid)


def uncut_result(name: str = "Top B") -> HorizonResult:
    horizon = input_horizon(name, 0.0)
    n = len(horizon.surface.vertices)
    return HorizonResult(
        horizon=horizon,
        surface=horizon.surface,
        first=horizon.surface.vertices,
        subdomain=np.zeros(n),
        fixed=np.ones(n, dtype=bool),
        side=np.zeros(n),
        block=np.zeros((n, 0)),
        graph_faults=(),
        smears=np.zeros(0),
        graph=CutGraph(name, np.zeros((0, 3)), np.zeros(0), np.zeros((0, 2)), np.zeros(0)),
        cutoffs=(),
        subdomains=(Subdomain(0, (), n, 0, 0, CONVERGED),),
    )


def cut_result(
    name: str = "Top A", fault_name: str = "F1", throw: float = 138.0, termination: Termination = CONVERGED
) -> HorizonResult:
    """One fault with both tips inside; lips to the bit on the fault of :func:`fault`, by construction.

    The mesh is a grid whose middle column follows the trace; its nodes between the tips are doubled.
    """
    horizon = input_horizon(name, throw)
    count = int(SIZE / STEP) + 1
    middle, low, high = count // 2, 10, count - 11  # rows of the tips
    j = np.tile(np.arange(count), (count, 1))
    i = j.T
    y = ORIGIN[1] + STEP * j
    ends = np.stack([np.full(count, ORIGIN[0]), trace(y[0]), np.full(count, ORIGIN[0] + SIZE)])
    x = np.stack(
        [np.interp(np.arange(count), [0, middle, count - 1], ends[:, k]) for k in range(count)], axis=1
    )
    base = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    base[:, 2] = _interpolated(horizon, base)

    index = np.arange(count * count).reshape(count, count)
    doubled = index[middle, low + 1 : high]
    copies = count * count + np.arange(len(doubled))
    triangles = grid_triangles(count, count)
    hanging_side = triangles.min(axis=1) // count >= middle
    renumbered = np.arange(count * count)
    renumbered[doubled] = copies
    triangles = np.where(hanging_side[:, None], renumbered[triangles], triangles)

    first = np.concatenate([base, base[doubled]])
    sign = np.concatenate([np.where(i.ravel() >= middle, 1.0, -1.0), np.ones(len(doubled))])
    sign[doubled] = -1.0
    sign[index[middle, [low, high]]] = 0.0
    d = first[:, 0] - trace(first[:, 1])
    t = throw_at(first[:, 1], throw)
    fixed = (np.abs(d) > GAMMA) | (np.abs(first[:, 1] - ORIGIN[1] - 3000.0) > 2000.0 + GAMMA)
    points = first.copy()
    points[:, 0] += 0.5 * sign * t / TAN_DIP * np.clip(1.0 - np.abs(d) / GAMMA, 0.0, 1.0)
    points[:, 2] = regional(first[:, 1]) - 0.5 * sign * t * np.exp(-((d / 1500.0) ** 2))
    points[fixed, 2] = first[fixed, 2]

    side = np.zeros(len(first), dtype=np.int64)
    side[doubled], side[copies] = -1, 1
    path = index[middle, low : high + 1]
    foot, hanging = path, renumbered[path]
    # A fault that dips east lies to the right of a way to the north.
    s = np.append(0.0, np.cumsum(np.hypot(*np.diff(first[path, :2], axis=0).T)))
    lips = points[hanging], points[foot]
    kinds = np.full(len(path), NodeKind.INTERIOR)
    kinds[[0, -1]] = NodeKind.TIP
    edges = np.stack([np.arange(len(path) - 1), np.arange(1, len(path))], axis=1)
    unknowns = int((~fixed).sum())
    return HorizonResult(
        horizon=horizon,
        surface=Surface(name, points, triangles),
        first=first,
        subdomain=np.zeros(len(first)),
        fixed=fixed,
        side=side,
        block=np.where(fixed, 0.0, sign)[:, None],
        graph_faults=(fault_name,),
        smears=np.zeros(1),
        graph=CutGraph(name, first[path], kinds, edges, np.zeros(len(edges))),
        cutoffs=(Cutoff(fault_name, s, *lips, lips[1][:, 2] - lips[0][:, 2], (lips[0] - lips[1])[:, 0]),),
        subdomains=(
            Subdomain(
                0,
                (fault_name,),
                len(first),
                unknowns,
                4,
                termination,
                12.5,
                0.01,
                (61.0, 3.2, 0.4, 0.02),
                0,
                MappingProxyType({"solve": 0.2}),
            ),
        ),
        score=Score(Error(3.1, 2.2), Error(5.4, 3.9), Error(1.6, 1.2), Error(10.7, 7.8)),
        seconds=MappingProxyType({"triangulate": 0.1, "solve": 0.2, "move": 0.05, "deform": 0.1}),
    )


def _interpolated(horizon: Horizon, points: FloatArray) -> FloatArray:
    """Return the input horizon at plan positions, bilinearly."""
    from scipy.interpolate import RegularGridInterpolator

    grid = horizon.grid
    assert grid is not None
    values = horizon.surface.vertices[:, 2].reshape(grid.columns, grid.rows)
    axes = (ORIGIN[0] + STEP * np.arange(grid.columns), ORIGIN[1] + STEP * np.arange(grid.rows))
    return np.asarray(RegularGridInterpolator(axes, values)(points[:, :2]))


def check_result(z_factor: float = 1.0, failing: bool = False) -> CheckResult:
    warning = Finding(
        "min-dip",
        Status.WARN,
        ("F1",),
        3,
        Worst(24.0, "degrees", ORIGIN[0] + 3100.0, ORIGIN[1] + 2500.0, -2100.0),
        "3 triangles of F1 dip less than 30 degrees.",
        "Look at the picks there.",
    )
    failure = Finding("acyclic", Status.FAIL, ("F1", "F2"), 1, None, "A cycle of <b>traces</b>.", "Split it.")
    findings = [
        Finding("finite", Status.PASS),
        warning,
        Finding("near-miss", Status.SKIPPED, message="Waits."),
    ]
    return CheckResult(Profile.EXTENDED, (*findings, *([failure] if failing else [])), z_factor)


def model(fault_name: str = "F1", depth: bool = False, names: tuple[str, ...] = ("Top A", "Top B")) -> Model:
    return Model(
        "two horizons",
        tuple(input_horizon(n) for n in names),
        (fault(fault_name),),
        z="depth" if depth else "elevation",
        parameters=Parameters(gamma=GAMMA),
    )


def run_result(fault_name: str = "F1", depth: bool = False, throw: float = 138.0) -> RunResult:
    """A finished run on two horizons, the first of them cut."""
    the_model = model(fault_name, depth)
    check = check_result(the_model.z_factor)
    horizons = (cut_result("Top A", fault_name, throw), uncut_result("Top B"))
    return RunResult(
        model=the_model,
        before=check,
        repairs=(
            RepairAction("weld", "duplicate", (fault_name,), 4, 0.0, (*ORIGIN, -2000.0), "Equal vertices."),
        ),
        repaired=the_model,
        after=check,
        horizons=tuple(judged(h, the_model) for h in horizons),
        not_modeled=MappingProxyType({}),
        timings=MappingProxyType(dict.fromkeys(STAGES, 0.25)),
        peak_memory_mb=210.0,
    )


def failed_run(fault_name: str = "F1") -> RunResult:
    """The same run ended with type 3, a horizon left out and a failing check."""
    stopped = Termination(
        TerminationType.VERTEX_REACHED,
        "guide ended",
        "Extend the fault downwards by 40 m or leave the horizon out.",
        fault_name,
        Side.HANGING,
        37.5,
        ORIGIN[0] + 3000.0,
        ORIGIN[1] + 3000.0,
        -2069.0,
    )
    done = run_result(fault_name)
    return replace(
        done,
        after=check_result(failing=True),
        horizons=(replace(cut_result("Top A", fault_name, termination=stopped), warnings=("Look <here>.",)),),
        not_modeled=MappingProxyType({"Top B": "Top B is not a function of x and y."}),
    )
