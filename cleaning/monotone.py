"""monotone: patches of faults given one way up and one way down (answers `z-monotone`, `min-dip`)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from graben.arrays import BoolArray, FloatArray, floats
from graben.cleaning.joint import Joint, joint_move, sound_with
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task, fails
from graben.cleaning.shaping.limits import reaches
from graben.cleaning.shaping.shared import shared_vertices
from graben.cleaning.shaping.slope_patches import Turned, around, patches, slivers, within
from graben.cleaning.shaping.slope_program import Bounds
from graben.finding import Finding, Status
from graben.model import Model
from graben.surface import Surface, boundary_edges, triangle_dips
from graben.validators.measuring.measures import amount
from graben.validators.measuring.plan import VERTICAL
from graben.validators.min_dip import ROUNDING
from graben.validators.z_monotone import LEVEL, critical_points
from graben.words import plural

#: The way of all moves. Moves along the mean normal of a patch were tried: on faults of 45 degrees and more
#: they mend few defects, where both serve they go further, and they bend the plan.
UP = floats([0.0, 0.0, 1.0])
#: Degrees by which a triangle is brought past the least dip: more than coordinates of four digits of an edge
#: undo, less than anyone sees.
MARGIN = 0.02
#: Rounds in which the normals at vertices are averaged over their neighbours, to tell the direction of dip.
SMOOTHING = 6
#: Least level part of a normal that has a direction of dip: 1 degree.
_LEVEL_PART = 0.0175
#: Rings of triangles around a defect that may move with it; a wider patch is tried where it does not suffice.
RINGS = (3, 6, 12)
#: A patch is solved so often, each time with the vertices that the last solution made critical.
_MOST_ROUNDS = 4


@dataclass(frozen=True, eq=False)
class _Fault:
    """A fault and what of it is to be changed.

    Parameters
    ----------
    surface, turned : Surface, Turned
        As it is, and its triangles from the top.
    directions : (n, 2) array
        The plan direction of dip at each vertex, unit vectors; 0 where there is none.
    critical : (n,) array
        The vertices all triangles of which must dip the same way.
    flat : (k,) array
        The triangles, of those kept, that must be steeper.
    least : float
        The dip they are brought to, degrees.
    shared, rim : (n,) arrays
        Vertices of other faults as well, and those on the rim.
    """

    surface: Surface
    turned: Turned
    directions: FloatArray
    critical: BoolArray
    flat: BoolArray
    least: float
    shared: BoolArray
    rim: BoolArray

    @property
    def core(self) -> BoolArray:
        """The vertices of what is to be changed."""
        core = self.critical.copy()
        core[self.turned.triangles[self.flat]] = True
        return core


@dataclass(frozen=True, eq=False)
class _Try:
    """One way to mend a patch: which vertices move, and how the dip is measured."""

    movable: BoolArray
    directions: FloatArray


def propose(task: Task) -> list[Change | Refusal]:
    """Return each fault with the patches mended that lack a way up and down, or are too flat."""
    faults = {f.name for f in task.model.faults}
    checks: dict[str, list[str]] = {}
    for finding in task.findings:
        for name in (n for n in finding.objects if n in faults and frozenset([n]) not in task.vetoed):
            checks.setdefault(name, []).append(finding.check)
    found: list[Change | Refusal] = []
    for name, asked in checks.items():
        found += _mended(task, name, asked)
    return found


def _mended(task: Task, name: str, checks: list[str]) -> list[Change | Refusal]:
    """Return the change of one fault and of those it takes along, and what of it is left.

    What cannot be made as steep as is asked gets a way up and down at least.
    """
    before = surface = task.fault(name).surface
    count, least, place = 0, 0.0, None
    others: dict[str, Surface] = {}
    left: list[Change | Refusal] = []
    for check in sorted(set(checks)):
        steepen = check == "min-dip"
        fault = _examined(task, surface, steepen)
        core, triangles = fault.core, fault.turned.triangles
        # patches follow each other, each on what the ones before have left: their surroundings may overlap
        for patch in patches(triangles, around(triangles, core, RINGS[0])):
            now = _examined(task, surface, steepen)
            mine = patch & core & now.core
            if not mine.any():
                continue
            made = _patch(task, now, mine, others)
            if made is None:
                left.append(_refused(task, check, now, mine))
                continue
            place = surface.vertices[np.flatnonzero(mine)[0]] if place is None else place
            surface, others = made.surface, {**others, **made.others}
            count, least = count + int(mine.sum()), max(least, now.least)
    if surface is before:
        return left
    along = f", and {', '.join(sorted(others))} along their common line" if others else ""
    step = Step(
        checks[0],
        (name, *sorted(others)),
        count,
        place,
        f"{plural(count, 'vertex', 'vertices')} of {name} without one way up and one way down, or in too "
        f"flat triangles, and their surroundings were moved to a dip of {_degrees(least)}{along}.",
    )
    return [Change({name: (surface,)} | {n: (s,) for n, s in others.items()}, (step,)), *left]


def _examined(task: Task, surface: Surface, steepen: bool) -> _Fault:
    """Return what of a fault is to be changed."""
    turned = Turned.of(surface)
    model = task.model
    least = model.repair.dip_floor
    found = critical_points(surface, model.checks.get("z-monotone", LEVEL))
    flat = np.isin(turned.kept, found.level)
    if steepen:
        least = max(least, float(model.checks.get("min-dip", model.parameters.min_dip)))
        flat |= triangle_dips(surface.vertices, turned.triangles) < least - ROUNDING
    rim = np.zeros(len(surface.vertices), dtype=np.bool_)
    rim[boundary_edges(surface.triangles)] = True
    critical = np.zeros(len(rim), dtype=np.bool_)
    critical[found.vertices] = True
    # a vertex of a level triangle is looked at once that triangle has a dip
    critical[surface.triangles[found.level]] = True
    shared = shared_vertices(surface, [f.surface for f in model.faults if f.name != surface.name])
    return _Fault(surface, turned, _directions(surface, turned), critical & ~rim, flat, least, shared, rim)


def _directions(surface: Surface, turned: Turned) -> FloatArray:
    """Return the smoothed plan direction of dip at vertices, where there is none that of all, (n, 2).

    Where the normals of all cancel in plan, the direction along which they spread most stands in.
    """
    normals = turned.at_vertices(len(surface.vertices), SMOOTHING)
    size = np.linalg.norm(normals, axis=1)
    level = np.hypot(normals[:, 0], normals[:, 1])
    mean = turned.normals.sum(axis=0)[:2]
    total = np.linalg.norm(turned.normals, axis=1).sum()
    if np.hypot(*mean) <= _LEVEL_PART * total:
        spread = turned.normals[:, :2].T @ turned.normals[:, :2]
        values, vectors = np.linalg.eigh(spread)
        mean = vectors[:, 1] if values[1] > (_LEVEL_PART * total / len(turned.normals)) ** 2 else np.zeros(2)
        mean = mean * (
            -1.0 if mean @ (turned.normals[:, :2] * turned.normals[:, 2:]).sum(axis=0) < 0 else 1.0
        )
    mean = mean / (np.hypot(*mean) or 1.0)
    clear = level > _LEVEL_PART * size
    own = normals[:, :2] / np.where(clear, level, 1.0)[:, None]
    return np.asarray(np.where(clear[:, None], own, mean))


def _patch(task: Task, fault: _Fault, core: BoolArray, taken: Mapping[str, Surface]) -> Joint | None:
    """Return the fault with one patch mended and the faults that move with it, or None.

    A patch that leaves no triangle thinner than it was is taken before one that does.
    """
    second: Joint | None = None
    thin = slivers(fault.surface.vertices, fault.turned.triangles)
    held = (fault.rim | fault.shared, fault.shared, np.zeros_like(core))
    for attempt in _attempts(fault, core, held, RINGS):
        moved = _moved(task, fault, core, attempt, task.max_move(fault.surface.name))
        made = None if moved is None else joint_move(task, fault.surface, moved, taken)
        if made is None or not sound_with(task, made, taken):
            continue
        if slivers(made.surface.vertices, fault.turned.triangles) <= thin:
            return made
        second = second or made
    return second


def _moved(task: Task, fault: _Fault, core: BoolArray, attempt: _Try, limit: float) -> Surface | None:
    """Return the fault with one patch mended in one way, within a distance (model units), or None."""
    surface, critical = fault.surface, fault.critical & core
    near = around(fault.turned.triangles, attempt.movable, 1)
    for _ in range(_MOST_ROUNDS):
        bounds = _bounds(fault, attempt, core, critical)
        if bounds is None:
            return None
        reference = task.references[surface.name]
        found = within(surface, fault.turned, UP, bounds, attempt.movable, limit, reference)
        if found is None:
            return None
        moved = surface.with_vertices(surface.vertices + found[:, None] * UP)
        worse = _worse(task, moved, near) & ~fault.rim
        if not worse.any():
            return moved
        if not (worse & ~critical).any():
            return None
        critical = critical | worse
    return None


def _lacking(task: Task, fault: _Fault, core: BoolArray) -> float | None:
    """Return how far beyond the limit the smallest moves of the widest patch go; None without any."""
    name, most = fault.surface.name, []
    for attempt in _attempts(fault, core, (np.zeros_like(core),), RINGS[-1:]):
        moved = _moved(task, fault, core, attempt, np.inf)
        if moved is not None:
            most.append(float(reaches(moved, [task.references[name]]).max()))
    return min(most) - task.max_move(name) if most else None


def _attempts(
    fault: _Fault, core: BoolArray, held: Sequence[BoolArray], rings: Sequence[int]
) -> Iterator[_Try]:
    """Yield ways to mend a patch with some vertices held, what disturbs least first, each once.

    The dip is measured with the direction of each vertex, and where that asks too much with one for all.
    """
    triangles = fault.turned.triangles
    mean = fault.directions[core].sum(axis=0)
    single = np.broadcast_to(mean / (np.hypot(*mean) or 1.0), fault.directions.shape)
    seen = set()
    for fixed, count in product(held, rings):
        patch = around(triangles, core, count)
        movable = np.asarray(patch & ~fixed, dtype=np.bool_)
        for directions in (fault.directions, single):
            key = (movable.tobytes(), directions[patch].tobytes())
            if movable.any() and key not in seen:
                seen.add(key)
                yield _Try(movable, directions)


def _bounds(fault: _Fault, attempt: _Try, core: BoolArray, critical: BoolArray) -> Bounds | None:
    """Return the constraints of a patch; None where it has no direction of dip.

    Asked of the triangles around critical vertices, with the direction of each such vertex, and of flat
    ones with their own. All others that move must not become flatter than the floor, nor vertical.
    """
    triangles, normals = fault.turned.triangles, fault.turned.normals
    floor = np.tan(np.radians(fault.least + MARGIN))
    size = np.linalg.norm(normals, axis=1)
    concerned = np.flatnonzero(attempt.movable[triangles].any(axis=1))
    star, corner = np.nonzero(critical[triangles])
    flat = np.flatnonzero(fault.flat & core[triangles].all(axis=1))
    own = attempt.directions[triangles].sum(axis=1)
    own = own / np.where((most := np.hypot(own[:, 0], own[:, 1])) > 0, most, 1.0)[:, None]
    asked = np.concatenate([star, flat])
    level = np.concatenate([attempt.directions[triangles[star, corner]], own[flat]])
    if (np.hypot(level[:, 0], level[:, 1]) == 0).any():
        return None
    ways = np.c_[level, np.full(len(level), -floor)]
    bounds = Bounds(asked, ways, np.zeros(len(asked)))
    guard = np.c_[own[concerned], np.full(len(concerned), -floor)]
    rest = (normals[concerned] * guard).sum(axis=1) / size[concerned]
    bounds = bounds.joined(Bounds(concerned, guard, np.minimum(rest, 0.0)))
    steep = 1.0 / np.tan(np.radians(VERTICAL - MARGIN))
    guard = np.c_[-steep * own[concerned], np.ones(len(concerned))]
    rest = (normals[concerned] * guard).sum(axis=1) / size[concerned]
    return bounds.joined(Bounds(concerned, guard, np.minimum(rest, 0.0)))


def _worse(task: Task, moved: Surface, near: BoolArray) -> BoolArray:
    """Return the critical vertices of a moved surface, and those of level triangles, near its patch, (n,)."""
    found = critical_points(moved, task.model.checks.get("z-monotone", LEVEL))
    worse = np.zeros(len(near), dtype=np.bool_)
    worse[found.vertices] = True
    worse[moved.triangles[found.level]] = True
    return worse & near


def _refused(task: Task, check: str, fault: _Fault, core: BoolArray) -> Refusal:
    """Return why a patch was left."""
    name, excess = fault.surface.name, _lacking(task, fault, core)
    limit = amount(task.max_move(name), task.unit)
    needed = excess if excess is not None and excess > 0 else None
    if needed is not None:
        why = f"would take {amount(needed, task.unit)} more than max_move = {limit}"
    elif not np.hypot(*fault.directions[core].T).any():
        tilt = _tilt(fault)
        needed = tilt - task.max_move(name) if tilt > task.max_move(name) else None
        why = (
            f"would tilt a level fault, which moves its rim by {amount(tilt, task.unit)} at least (max_move "
            f"is {limit}), to a side that its surface does not tell"
        )
    elif (core & fault.shared).any():
        why = "would spoil the faults that it shares vertices with"
    else:
        why = "is not reached by moving vertices up and down"
    places = fault.surface.vertices[core]
    count = plural(len(places), "vertex", "vertices")
    return Refusal(
        check,
        (name,),
        f"A dip of {_degrees(fault.least)} at {count} of {name} {why}.",
        "Redraw the fault there, or cut it in two along the crest or trough.",
        places[np.argmin(np.linalg.norm(places - places.mean(axis=0), axis=1))],
        needed,
        task.unit,
    )


def _tilt(fault: _Fault) -> float:
    """Return how far the rim of a level fault moves when it is tilted across its smaller width."""
    plan = fault.surface.vertices[np.unique(fault.turned.triangles), :2]
    across = np.linalg.eigh(np.cov(plan.T))[1][:, 0]
    return 0.5 * float(np.ptp(plan @ across) * np.tan(np.radians(fault.least)))


def _degrees(angle: float) -> str:
    return f"{angle:g} degree" if angle == 1 else f"{angle:g} degrees"


def _asks(finding: Finding, model: Model) -> bool:
    """Return whether a finding asks for it: a failure, or too flat a dip where that is to be steepened."""
    flat = finding.check == "min-dip" and finding.status is Status.WARN and model.repair.steepen
    return flat or (finding.check == "z-monotone" and fails(finding, model))


REPAIR = Repair(
    "monotone",
    ("z-monotone", "min-dip"),
    "Moves vertices of faults up and down as little as possible until every place has a way up and down.",
    propose,
    answers=_asks,
)
