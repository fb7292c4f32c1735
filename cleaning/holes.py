"""holes: holes of a fault filled by a patch that continues it (answers `manifold`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
import shapely

from graben.arrays import FloatArray, IntArray, ints
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.limits import joined
from graben.cleaning.shaping.patching import Frame, folds, frame_at, local_edge, outline, patched, with_patch
from graben.cleaning.shaping.shared import shared_vertices
from graben.finding import Finding, Status
from graben.model import Model
from graben.surface import Surface, chained, edge_table
from graben.validators.manifold import HOLE
from graben.validators.measuring.measures import amount, smallest_angles
from graben.validators.measuring.openings import Opening, openings
from graben.validators.self_intersection import TOUCH
from graben.words import plural

#: Smallest angle of a patch that is good enough, degrees; with a worse one the triangles along the rim of
#: the hole are made anew as well.
WANTED_ANGLE = 10.0
#: Smallest angle with which a patch is used at all, degrees: twice what `degenerate` asks for.
_LEAST_ANGLE = 1.0
#: Precision of a hole's width, as a share of its size.
_PRECISE = 1e-3


@dataclass(frozen=True, eq=False)
class Filling:
    """A filled hole.

    Parameters
    ----------
    surface : Surface
        The fault with the patch, or as it was.
    patch : Surface or None
        The patch alone.
    width : float
        Of the hole, model units: twice the largest distance of a point in it from its rim.
    problem : str
        Why it is not filled, in words; empty where it is.
    remade : int
        Triangles along the rim that were made anew.
    angle : float
        Smallest angle of the patch, degrees.
    """

    surface: Surface
    patch: Surface | None
    width: float
    problem: str = ""
    remade: int = 0
    angle: float = 0.0


def hole_width(surface: Surface, loop: IntArray) -> float:
    """Return twice the largest distance of a point in a hole from its rim, in its mean plane, model units.

    ``loop`` (k + 1,) are the vertices of the rim, first = last.
    """
    flat = frame_at(surface, loop).flat(surface.vertices[loop])[:, :2]
    parts = shapely.get_parts(shapely.make_valid(shapely.Polygon(flat)))
    areas = [p for p in parts if p.geom_type == "Polygon" and p.area > 0]
    size = float(np.ptp(flat, axis=0).max())
    # the search for the circle does not end in a crack
    wide = [p for p in areas if p.area > _PRECISE**2 * size**2]
    radii = [shapely.maximum_inscribed_circle(p, tolerance=_PRECISE * size).length for p in wide]
    return 2.0 * max(radii, default=0.0)


def filled(surface: Surface, hole: Opening, touch: float, held: IntArray) -> Filling:
    """Return a surface with a hole filled; all its vertices stay.

    Parameters
    ----------
    surface : Surface
        Its triangles turned one way.
    hole : Opening
        One of its holes.
    touch : float
        Depth of a crossing that counts, model units.
    held : (h,) array
        Vertices on branch lines: edges between two of them stay.
    """
    loop = hole.loop
    width, edge, frame = hole_width(surface, loop), local_edge(surface, loop), frame_at(surface, loop)
    best = Filling(surface, None, width, "its rim cannot be laid flat")
    for removed in (ints([]), _along(surface, loop)):
        if len(removed) and (np.isin(surface.triangles[removed], held).sum(axis=1) > 1).any():
            continue
        made = _tried(surface, loop, removed, frame, edge, touch)
        if made is None:
            continue
        good, known = not made.problem, not best.problem
        if good > known or (good == known and made.angle > best.angle):
            best = replace(made, width=width)
        if not best.problem and best.angle >= WANTED_ANGLE:
            break
    return best


def _tried(
    surface: Surface, loop: IntArray, removed: IntArray, frame: Frame, edge: float, touch: float
) -> Filling | None:
    """Return a hole filled after some triangles along its rim are taken away; None where it cannot be."""
    rim, inner = _rim_without(surface, loop, removed)
    if not len(rim) or outline(surface, frame, rim) is None:
        return None
    kept = np.delete(np.arange(len(surface.triangles)), removed)
    lines = surface.lines[kept] if len(surface.lines) else surface.lines
    rest = replace(surface, triangles=surface.triangles[kept], lines=lines)
    patch = patched(rest, frame, rim, inner, edge)
    if patch is None:
        return None
    whole, alone = with_patch(rest, patch)
    problem = folds(whole, len(patch.triangles), frame, touch)
    before = smallest_angles(surface.vertices, surface.triangles[removed]).min(initial=np.inf)
    if not problem and patch.angle < min(_LEAST_ANGLE, before):
        problem = f"its triangles would have angles of {patch.angle:.2g} degrees"
    return Filling(whole, alone, 0.0, problem, len(removed), patch.angle)


def _along(surface: Surface, loop: IntArray) -> IntArray:
    """Return the triangles of a surface that have an edge of a loop, ascending."""
    edges, sides = edge_table(surface.triangles)
    base = len(surface.vertices)
    asked = np.minimum(loop[:-1], loop[1:]) * base + np.maximum(loop[:-1], loop[1:])
    return ints(np.flatnonzero(np.isin(edges[:, 0] * base + edges[:, 1], asked)[sides].any(axis=1)))


def _rim_without(surface: Surface, loop: IntArray, removed: IntArray) -> tuple[IntArray, IntArray]:
    """Return the rim of a hole widened by some triangles, first = last, and the vertices then inside it.

    An empty rim where it is not one closed line.
    """
    if not len(removed):
        return loop, ints([])
    own = np.sort(np.stack([loop[:-1], loop[1:]], axis=1), axis=1)
    edges, sides = edge_table(surface.triangles[removed])
    every = np.concatenate([edges[sides.ravel()], own])
    unique, count = np.unique(every, axis=0, return_counts=True)
    chains = chained(ints(unique[count == 1]))
    if len(chains) != 1 or chains[0][0] != chains[0][-1]:
        return ints([]), ints([])
    inside = np.setdiff1d(np.union1d(loop, surface.triangles[removed]), chains[0])
    return chains[0], ints(inside)


def _propose(task: Task) -> Sequence[Change | Refusal]:
    """Return each fault with those of its holes filled that are not too wide."""
    made: list[Change | Refusal] = []
    named = {name for finding in task.findings for name in finding.objects}
    for fault in task.model.faults:
        if fault.name in named and frozenset([fault.name]) not in task.vetoed:
            made += _of_fault(task, fault.name)
    return made


def _of_fault(task: Task, name: str) -> list[Change | Refusal]:
    """Return a fault with its holes filled, and why some are not."""
    surface = task.fault(name).surface
    others = [f.surface for f in task.model.faults if f.name != name]
    held = ints(np.flatnonzero(shared_vertices(surface, others)))
    touch = task.model.checks.get("self-intersection", TOUCH * task.model.size)
    steps: list[Step] = []
    left: list[tuple[Opening, Filling]] = []
    declared: Surface | None = None
    for hole in openings(surface):
        wide = hole_width(surface, hole.loop)
        # no place of a patch lies further from the rim than a fault may be extended
        if wide > 2.0 * task.max_extension(name):
            left.append((hole, Filling(surface, None, wide)))
            continue
        made = filled(surface, hole, touch, held)
        if made.problem or made.patch is None:
            left.append((hole, made))
            continue
        count = len(made.surface.triangles) - len(surface.triangles) + made.remade
        steps.append(_step(task, name, hole, made, count, surface.vertices[hole.loop[0]]))
        surface = made.surface
        declared = made.patch if declared is None else joined(declared, made.patch)
    refusals: list[Change | Refusal] = [_left(task, surface, left)] if left else []
    if declared is None:
        return refusals
    return [Change({name: (surface,)}, tuple(steps), MappingProxyType({name: declared})), *refusals]


def _step(task: Task, name: str, hole: Opening, made: Filling, count: int, place: FloatArray) -> Step:
    """Return what is said of a filled hole."""
    wide = f"{amount(made.width, task.unit)} wide and {amount(hole.length, task.unit)} around"
    anew = f", {made.remade} of them in place of those along its rim" if made.remade else ""
    return Step(
        "manifold",
        (name,),
        count,
        place,
        f"A hole of {name}, {wide}, was filled with {plural(count, 'triangle')}{anew}, bent as the fault "
        f"around it; their smallest angle is {made.angle:.2g} degrees.",
        made.width,
        task.unit,
    )


def _left(task: Task, surface: Surface, left: list[tuple[Opening, Filling]]) -> Refusal:
    """Return why some holes of a fault are left, of the widest first."""
    name, limit = surface.name, 2.0 * task.max_extension(surface.name)
    hole, made = max(left, key=lambda pair: pair[1].width)
    wide = amount(made.width, task.unit)
    if made.problem:
        size = f"{wide} wide and {amount(hole.length, task.unit)} around"
        reason = f"A hole of {name}, {size}, was not filled: {made.problem}."
        advice, needed = "Fill it in the interpretation.", None
    else:
        reason = f"A hole of {name} is {wide} wide, over twice max_extension, {amount(limit, task.unit)}."
        advice = "Raise max_extension, fill it by hand, or leave it if the fault does end there."
        needed = (made.width - limit) / 2.0
    if len(left) > 1:
        reason = f"{plural(len(left), 'hole')} of {name} are left. The widest: {reason}"
    place = surface.vertices[hole.loop[0]]
    return Refusal("manifold", (name,), reason, advice, place, needed, task.unit)


def has_hole(finding: Finding, model: Model) -> bool:
    """Return whether a finding names a hole of a fault, and fails, or warns where warnings are repaired.

    A hole that breaks a trace, or the line in which a fault leaves a horizon, is one of `manifold` as well.
    """
    speaks = finding.status is Status.FAIL or (finding.status is Status.WARN and model.repair.warnings)
    return speaks and any(part.kind.startswith(HOLE) for part in finding.parts)


REPAIR = Repair(
    "holes",
    ("manifold", "simplicial-complex"),
    "Fills holes of a fault by patches that continue it.",
    _propose,
    answers=has_hole,
)
