"""unfold: overturned and vertical patches of faults brought back to functions (answers `functional`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import shapely

from graben.arrays import BoolArray, FloatArray, IntArray, bools
from graben.cleaning.joint import Joint, joint_move, sound_with
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.limits import reaches
from graben.cleaning.shaping.shared import shared_vertices
from graben.cleaning.shaping.slope_patches import Turned, around, patches, slivers, within
from graben.cleaning.shaping.slope_program import Bounds, Smooth, hinges
from graben.surface import Surface, boundary_edges
from graben.validators.measuring.measures import amount
from graben.validators.measuring.plan import (
    VERTICAL,
    covers_once,
    doubled_in_plan,
    narrowest_overlap,
    projected,
)
from graben.words import plural

#: Dip up to which a patch is brought, degrees: below the dip at which a triangle is vertical, by a margin
#: that coordinates written with four digits of an edge keep.
STEEPEST = VERTICAL - 0.05
#: Weight of flatness across the edges of a patch over that of the moves. Without it a patch that was pushed
#: over stays as a bump at the limit of the vertical. On faults of 70 to 80 degrees, of which 1 to 5 % were
#: pushed by 0.4 of an edge, the area then was wrong by up to 0.6 %, with 10 by 0.02 %, with 100 by 0.05 %.
SMOOTHNESS = 10.0
#: Rings of triangles around a patch that move with it; whether the rim, and the vertices of other faults,
#: may; and whether the patch is drawn flat, which may go beyond the limit where the smallest moves do not.
#: Tried in this order.
ATTEMPTS = (
    *((3, False, False, True), (8, False, False, True)),
    *((3, True, False, True), (8, True, False, True)),
    *((3, True, True, True), (8, True, True, True), (8, True, True, False)),
)
#: A patch is solved so often, each time with the triangles that the last solution turned over.
_MOST_ROUNDS = 3


@dataclass(frozen=True, eq=False)
class _Fault:
    """A fault and what of it must not move.

    Parameters
    ----------
    surface : Surface
        As it is.
    turned : Turned
        Its triangles from the top.
    bad : (k,) array
        Which of those kept are vertical or overturned.
    shared, rim : (n,) arrays
        Vertices of other faults as well, and those on the rim.
    """

    surface: Surface
    turned: Turned
    bad: BoolArray
    shared: BoolArray
    rim: BoolArray


def propose(task: Task) -> list[Change | Refusal]:
    """Return each fault that is no function of x and y with the patches brought back that allow it."""
    faults = {f.name: f.surface for f in task.model.faults}
    found: list[Change | Refusal] = []
    for finding in task.findings:
        for name in (n for n in finding.objects if n in faults and frozenset([n]) not in task.vetoed):
            found += _unfolded(task, finding.check, name)
    return found


def _unfolded(task: Task, check: str, name: str) -> list[Change | Refusal]:
    """Return the change of one fault and what of it is left.

    Patches follow each other, each on what the ones before have left, since their surroundings may overlap.
    """
    fault = _fault(task, task.fault(name).surface)
    surface, turned = fault.surface, fault.turned
    if not fault.bad.any():
        least = narrowest_overlap(surface, projected(surface))
        return [] if covers_once(surface, least) else [_doubled(task, check, surface)]
    upright = _upright_parts(turned)
    left: list[Change | Refusal] = [
        _vertical(task, check, fault, k) for k in np.unique(turned.part[fault.bad]) if upright[k]
    ]
    core = np.zeros(len(surface.vertices), dtype=np.bool_)
    core[turned.triangles[fault.bad & ~upright[turned.part]]] = True
    count, others = 0, dict[str, Surface]()
    for patch in patches(turned.triangles, around(turned.triangles, core, ATTEMPTS[0][0])):
        now = _fault(task, surface)
        mine = now.bad & (patch & core)[now.turned.triangles].all(axis=1)
        if not mine.any():
            continue
        made = _patch(task, now, patch & core, others)
        if made is None:
            left.append(_refused(task, check, now, patch & core))
            continue
        surface, others = made.surface, {**others, **made.others}
        count += int(mine.sum())
    if surface is fault.surface:
        return left
    along = f", and {', '.join(sorted(others))} along their common line" if others else ""
    step = Step(
        check,
        (name, *sorted(others)),
        count,
        _middle(fault.surface.vertices[core]),
        f"{plural(count, 'triangle')} of {name} that stood upright or leaned over were brought below "
        f"{STEEPEST:g} degrees, with their surroundings as flat as the moves allow{along}.",
    )
    return [Change({name: (surface,)} | {n: (o,) for n, o in others.items()}, (step,)), *left]


def _fault(task: Task, surface: Surface) -> _Fault:
    """Return what of a fault is bad and what must not move."""
    turned = Turned.of(surface)
    rim = np.zeros(len(surface.vertices), dtype=np.bool_)
    rim[boundary_edges(surface.triangles)] = True
    others = [f.surface for f in task.model.faults if f.name != surface.name]
    return _Fault(surface, turned, _bad(surface, turned), shared_vertices(surface, others), rim)


def _bad(surface: Surface, turned: Turned) -> BoolArray:
    """Return which of the triangles kept are vertical or overturned."""
    plan = projected(surface)
    return np.isin(turned.kept, np.union1d(plan.vertical, plan.overturned))


def _upright_parts(turned: Turned) -> BoolArray:
    """Return which components stand upright as a whole: no side towards which they dip."""
    mean = np.stack([np.bincount(turned.part, turned.normals[:, k]) for k in range(3)], axis=1)
    dip = np.degrees(np.arctan2(np.hypot(mean[:, 0], mean[:, 1]), mean[:, 2]))
    return np.asarray(dip > VERTICAL, dtype=np.bool_)


def _patch(task: Task, fault: _Fault, core: BoolArray, taken: Mapping[str, Surface]) -> Joint | None:
    """Return the fault with one patch brought back and what moves with it, or None.

    A patch that leaves no triangle thinner than it was is taken before one that does.
    """
    thin = slivers(fault.surface.vertices, fault.turned.triangles)
    limit = task.max_move(fault.surface.name)
    second, seen = None, set()
    for rings, rim_moves, shared_move, flat in ATTEMPTS:
        movable = around(fault.turned.triangles, core, rings)
        movable = bools(movable & (rim_moves | ~fault.rim) & (shared_move | ~fault.shared))
        key = (movable.tobytes(), flat)
        moved = None if key in seen else _brought_back(task, fault, core, movable, flat, limit)
        seen.add(key)
        made = None if moved is None else joint_move(task, fault.surface, moved, taken)
        if made is None or not sound_with(task, made, taken):
            continue
        if slivers(made.surface.vertices, fault.turned.triangles) <= thin:
            return made
        second = second or made
    return second


def _lacking(task: Task, fault: _Fault, core: BoolArray) -> float | None:
    """Return how far beyond the limit the smallest moves of the widest patch go; None without any."""
    name = fault.surface.name
    movable = around(fault.turned.triangles, core, ATTEMPTS[-1][0])
    moved = _brought_back(task, fault, core, movable, flat=False, limit=np.inf)
    if moved is None:
        return None
    return float(reaches(moved, [task.references[name]]).max()) - task.max_move(name)


def _brought_back(
    task: Task, fault: _Fault, core: BoolArray, movable: BoolArray, flat: bool, limit: float
) -> Surface | None:
    """Return the fault with one patch brought back by some vertices, within a distance, or None."""
    surface, turned, reference = fault.surface, fault.turned, task.references[fault.surface.name]
    asked = fault.bad & core[turned.triangles].all(axis=1)
    concerned = movable[turned.triangles].any(axis=1) | asked
    way = _way(turned, concerned)
    if way is None or not movable.any():
        return None
    edges = concerned[turned.joints // 3].any(axis=1)
    rows = hinges(surface.vertices, turned.triangles, turned.joints[edges], way)
    smooth = Smooth(rows, SMOOTHNESS) if flat else None
    for _ in range(_MOST_ROUNDS):
        bounds = _bounds(turned, way, np.flatnonzero(concerned), asked)
        found = within(surface, turned, way, bounds, movable, limit, reference, smooth)
        if found is None:
            return None
        moved = surface.with_vertices(surface.vertices + found[:, None] * way)
        left = _bad(moved, turned) & concerned
        if not left.any():
            return moved
        if not (left & ~asked).any():
            return None
        asked = asked | left
    return None


def _way(turned: Turned, chosen: BoolArray) -> FloatArray | None:
    """Return the plan direction of dip of some triangles, a unit vector, shape (3,); None without one."""
    mean = turned.mean(chosen)
    level = np.array([mean[0], mean[1], 0.0])
    size = float(np.linalg.norm(level))
    return np.asarray(level / size, dtype=np.float64) if size > 0 else None


def _bounds(turned: Turned, way: FloatArray, concerned: IntArray, asked: BoolArray) -> Bounds:
    """Return the constraints that keep triangles below the steepest dip, those asked for brought there.

    With d the way and e the level direction normal to it, n_d does not change, and
    n_z >= cot(dip) (|n_d| + |n_e|) is linear in the moves.
    """
    normals = turned.normals[concerned]
    size = np.linalg.norm(normals, axis=1)
    cotangent = 1.0 / np.tan(np.radians(STEEPEST))
    across = np.array([-way[1], way[0], 0.0])
    up = np.array([0.0, 0.0, 1.0])
    parts = []
    for side in (-1.0, 1.0):
        g = np.broadcast_to(up + side * cotangent * across, (len(concerned), 3))
        least = cotangent * np.abs(normals @ way) / size
        rest = (normals * g).sum(axis=1) / size
        least = np.where(asked[concerned], least, np.minimum(least, rest))
        parts.append(Bounds(concerned, g, least))
    return parts[0].joined(parts[1])


def _refused(task: Task, check: str, fault: _Fault, core: BoolArray) -> Refusal:
    """Return why a patch was left."""
    name = fault.surface.name
    count = int((fault.bad & core[fault.turned.triangles].all(axis=1)).sum())
    limit = amount(task.max_move(name), task.unit)
    excess = _lacking(task, fault, core)
    needed = excess if excess is not None and excess > 0 else None
    if needed is not None:
        why = f"would take {amount(needed, task.unit)} more than max_move = {limit}"
    elif (core & fault.shared).any():
        why = "would spoil the faults that it shares vertices with"
    else:
        why = "is not reached by moving its vertices along the dip"
    return Refusal(
        check,
        (name,),
        f"Bringing back {plural(count, 'upright or overturned triangle')} of {name} {why}.",
        "Redraw the fault there, cut it in two along the fold, or use profile extended, which takes it as "
        "it is.",
        _middle(fault.surface.vertices[core]),
        needed,
        task.unit,
    )


def _vertical(task: Task, check: str, fault: _Fault, part: int) -> Refusal:
    """Return why a component that stands upright as a whole is left, and what the least lean would take."""
    surface, turned = fault.surface, fault.turned
    name, mine = surface.name, turned.part == part
    mean, way = turned.mean(mine), _way(turned, mine)
    needed = None
    if way is not None:
        bounds = _bounds(turned, way, np.flatnonzero(mine), mine & fault.bad)
        movable = np.zeros(len(surface.vertices), dtype=np.bool_)
        movable[turned.triangles[mine]] = True
        found = within(surface, turned, way, bounds, movable, np.inf, surface)
        if found is not None:
            leaning = surface.with_vertices(surface.vertices + found[:, None] * way)
            needed = float(reaches(leaning, [surface]).max())
    lean = (
        "no lean of it is a function of x and y"
        if needed is None
        else f"the least lean to {STEEPEST:g} degrees everywhere moves it by up to "
        f"{amount(needed, task.unit)} (max_move is {amount(task.max_move(name), task.unit)}), to a side that "
        "its surface does not tell"
    )
    return Refusal(
        check,
        (name,),
        f"{name} stands upright as a whole (mean dip {_dip(mean):.2f} degrees): {lean}.",
        "Use profile extended, under which vertical faults are taken as they are, or give it a dip.",
        _middle(surface.vertices[turned.triangles[mine]].reshape(-1, 3)),
        None if needed is None or needed <= task.max_move(name) else needed - task.max_move(name),
        task.unit,
    )


def _dip(normal: FloatArray) -> float:
    return float(np.degrees(np.arctan2(np.hypot(normal[0], normal[1]), normal[2])))


def _middle(points: FloatArray) -> FloatArray:
    return np.asarray(points[np.argmin(np.linalg.norm(points - points.mean(axis=0), axis=1))])


def _doubled(task: Task, check: str, surface: Surface) -> Refusal:
    """Return why a fault that lies over itself without a fold is left."""
    faces = doubled_in_plan(surface).faces
    areas, around_it = shapely.area(faces), shapely.length(faces)
    worst = int(np.argmax(areas)) if len(areas) else -1
    width = float(2.0 * areas[worst] / around_it[worst]) if worst >= 0 else None
    place = None
    if worst >= 0:
        x, y = shapely.get_coordinates(shapely.point_on_surface(faces[worst]))[0]
        nearest = np.argmin(np.hypot(surface.vertices[:, 0] - x, surface.vertices[:, 1] - y))
        place = surface.vertices[nearest]
    wide = "" if width is None else f", {amount(width, task.unit)} wide on average"
    return Refusal(
        check,
        (surface.name,),
        f"{surface.name} lies over itself in plan without a fold{wide}: no triangle leans over that could be "
        "brought back.",
        "Cut the fault in two there, or take one of the two sheets away.",
        place,
    )


REPAIR = Repair(
    "unfold",
    ("functional",),
    "Brings overturned and vertical patches of faults back to functions of x and y.",
    propose,
)
