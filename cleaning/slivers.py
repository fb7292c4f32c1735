"""slivers: triangles without area or with too small an angle go (answers `degenerate`).

By flips and collapses of edges, else by a new mesh of the patch around, within limits. Rims and what other
faults share stay in place.
"""

from __future__ import annotations

from graben.arrays import IntArray
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.remeshing import followed, shared_edges
from graben.cleaning.shaping.shared import shared_vertices
from graben.cleaning.shaping.sliver_edits import LAST_AWAY, LAST_TURN, bad_triangles, without_slivers
from graben.cleaning.shaping.sliver_patches import with_patches_remeshed
from graben.surface import Surface
from graben.validators.degenerate import ANGLE_LIMIT
from graben.validators.measuring.measures import amount, side_lengths, smallest_angles
from graben.words import plural


def propose(task: Task) -> list[Change | Refusal]:
    """Return for each fault with slivers the fault without them, and which of them had to stay."""
    limit = float(task.model.checks.get("degenerate", ANGLE_LIMIT))
    faults = {f.name: f.surface for f in task.model.faults}
    made: list[Change | Refusal] = []
    for finding in task.findings:
        for name in (n for n in finding.objects if n in faults):
            surface = faults[name]
            bad = bad_triangles(surface, limit)
            if not len(bad):
                reason, advice = f"{name} has no triangles.", "Take it out of the model, or export it again."
                made.append(Refusal("degenerate", (name,), reason, advice))
                continue
            merged, new = _without(task, name, limit)
            left = bad_triangles(new, limit)
            count = len(bad) - len(left)
            if len(left):
                made.append(_left(task, name, new, left, limit))
            if count <= 0:
                continue
            reason = (
                f"{plural(count, 'triangle')} of {name} without area, or with an angle below {limit:g} "
                "degrees, merged into the triangles around by flips and collapses of edges"
                f"{'' if new is merged else ', or meshed anew together with them'}."
            )
            place = surface.vertices[surface.triangles[bad[0]]].mean(axis=0)
            made.append(Change({name: (new,)}, (Step("degenerate", (name,), count, place, reason),)))
    return made


def _without(task: Task, name: str, limit: float) -> tuple[Surface, Surface]:
    """Return a fault without slivers as far as edits go, and as far as meshing patches anew goes."""
    surface, most = task.fault(name).surface, task.max_move(name)
    others = [f.surface for f in task.model.faults if f.name != name]
    held, lines = shared_vertices(surface, others), shared_edges(surface, others)
    new = without_slivers(surface, limit, held, most, lines)

    # what lies further off already is the planner's to judge
    far = max(most, _furthest(task, name, new))

    def fits(made: Surface) -> bool:
        return _furthest(task, name, made) <= far

    return new, with_patches_remeshed(new, limit, *followed(surface, new, held, lines), most, fits)


def _furthest(task: Task, name: str, surface: Surface) -> float:
    """Return how far a surface lies from the reference of a fault at most."""
    return float(distances(surface, [task.references[name]]).max(initial=0.0))


def _left(task: Task, name: str, surface: Surface, left: IntArray, limit: float) -> Refusal:
    """Return why some slivers stay."""
    angles = smallest_angles(surface.vertices, surface.triangles[left])
    place = surface.vertices[surface.triangles[left[0]]].mean(axis=0)
    if not (smallest_angles(surface.vertices, surface.triangles) > 0.0).any():
        reason, advice = f"No triangle of {name} has an area.", "Export the surface again."
    else:
        size = side_lengths(surface.vertices, surface.triangles[left]).max()
        reason = (
            f"{plural(len(left), 'triangle')} of {name} with angles from {angles.min():.2g} degrees "
            f"{'stays' if len(left) == 1 else 'stay'}: "
            "any flip, collapse or new mesh around would move the rim or a line shared with another fault, "
            f"turn a normal by more than {LAST_TURN:g} degrees, or leave the surface by more than "
            f"{amount(LAST_AWAY * size, task.unit)}."
        )
        advice = "Remesh the fault there."
    return Refusal("degenerate", (name,), reason, advice, place, float(limit - angles.min()), "degrees")


REPAIR = Repair(
    "slivers",
    ("degenerate",),
    "Flips the long edge of flat triangles, collapses the short one of needles, or meshes the patch anew.",
    propose,
)
