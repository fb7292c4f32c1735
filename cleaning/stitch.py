"""stitch: rims apart by rounding or a cut become one (answers `strongly-connected`, and crack-like holes)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, IntArray, bools, ints
from graben.cleaning.repairing import Change, Repair, Step, Task, fails
from graben.cleaning.seams import CHECK, sewn_together
from graben.cleaning.shaping.fans import crowded_edges, shortest_rim
from graben.cleaning.shaping.shared import shared_vertices
from graben.finding import Finding
from graben.model import Model
from graben.surface import Surface, boundary_edges
from graben.validators.manifold import HOLE
from graben.validators.measuring.measures import components
from graben.words import plural

#: Share of the shortest edge of the rim at a vertex up to which its gap may be one of rounding.
_OF_EDGE = 1e-2


def stitched(surface: Surface, distance: float, held: BoolArray | None = None) -> Surface:
    """Return the surface with vertices of its rims that lie within a distance of each other merged.

    Of those merged the first stays in its place. A vertex is merged only across a gap far narrower than the
    edges of the rim there, never along the rim, and not where more than two triangles would come to share an
    edge. Without such gaps the surface comes back as it is.

    Parameters
    ----------
    surface : Surface
        A sound surface.
    distance : float
        Model units.
    held : (n,) array, optional
        Vertices that stay rather than others; two of them are not merged.

    >>> halves = Surface("F", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1e-9, 0], [1e-9, 1, 0], [1, 1, 0]],
    ...                  [[0, 1, 2], [3, 5, 4]])
    >>> stitched(halves, 1e-6).triangles.tolist()
    [[0, 1, 2], [1, 3, 2]]
    """
    held = bools(np.zeros(len(surface.vertices))) if held is None else held
    pairs = _facing(surface, distance, held)
    if not len(pairs):
        return surface
    group = components(len(surface.vertices), pairs)
    blocked = _along(surface.triangles, group) | (np.bincount(group, held, minlength=len(group)) > 1)[group]
    known = np.unique(crowded_edges(surface.triangles))
    while True:
        target = _targets(np.where(blocked, len(group) + np.arange(len(group)), group), held)
        crowded = np.setdiff1d(crowded_edges(target[surface.triangles]), known)
        more = np.isin(target, crowded) & ~blocked & (np.bincount(group) > 1)[group]
        if not more.any():
            return _merged(surface, target)
        blocked |= more


def _facing(surface: Surface, distance: float, held: BoolArray) -> IntArray:
    """Return pairs of vertices of the rims within the distance and far below the edges there, (p, 2)."""
    rim = boundary_edges(surface.triangles)
    near = np.minimum(distance, _OF_EDGE * shortest_rim(surface.vertices, rim))
    on_rim = np.flatnonzero(np.isfinite(near) & (near > 0))
    if len(on_rim) < 2:
        return ints([], 0, 2)
    pairs = on_rim[cKDTree(surface.vertices[on_rim]).query_pairs(near[on_rim].max(), output_type="ndarray")]
    gap = np.linalg.norm(surface.vertices[pairs[:, 0]] - surface.vertices[pairs[:, 1]], axis=1)
    fit = (gap <= near[pairs].min(axis=1)) & ~held[pairs].all(axis=1)
    return ints(pairs[fit], -1, 2)


def _along(triangles: IntArray, group: IntArray) -> BoolArray:
    """Return which vertices are of a group two of which are corners of one triangle, shape (n,)."""
    g = group[triangles]
    t, k = np.nonzero((g == np.roll(g, 1, axis=1)) & (triangles != np.roll(triangles, 1, axis=1)))
    return np.asarray(np.isin(group, g[t, k]), dtype=np.bool_)


def _targets(group: IntArray, held: BoolArray) -> IntArray:
    """Return the vertex that each is merged into: the one held, or else the first of its group, (n,)."""
    order = np.lexsort((np.arange(len(group)), ~held, group))
    new = np.ones(len(order), dtype=np.bool_)
    new[1:] = group[order][1:] != group[order][:-1]
    target = np.empty(len(order), dtype=np.int64)
    target[order] = order[new][np.cumsum(new) - 1]
    return target


def _merged(surface: Surface, target: IntArray) -> Surface:
    """Return the surface with each vertex replaced by its target, without those that are gone."""
    kept = target == np.arange(len(target))
    if kept.all():
        return surface
    index = np.cumsum(kept) - 1
    return replace(
        surface, vertices=surface.vertices[kept], triangles=ints(index[target[surface.triangles]], -1, 3)
    )


def cracks(finding: Finding, model: Model) -> bool:
    """Return whether a finding may come from a crack: one that fails, or one that names holes."""
    return fails(finding, model) or any(p.kind.startswith(HOLE) for p in finding.parts)


def propose(task: Task) -> list[Change]:
    """Return for each fault with a gap of rounding, or a cut, between its rims the fault with that closed."""
    faults = {f.name: f.surface for f in task.model.faults}
    changes = []
    named = {n: f for f in reversed(task.findings) for n in f.objects if n in faults}
    for name, finding in named.items():
        held = shared_vertices(faults[name], faults.values())
        made = stitched(faults[name], min(task.contact, task.max_move(name)), held)
        if made is not faults[name]:
            count = len(faults[name].vertices) - len(made.vertices)
            reason = (
                f"{plural(count, 'vertex', 'vertices')} of the rims of {name} merged with the facing ones, "
                "apart by no more than rounding."
            )
            place = finding.places[0] if len(finding.places) else None
            changes.append(Change({name: (made,)}, (Step(finding.check, (name,), count, place, reason),)))
        elif finding.check == CHECK:
            # before cracks are closed edge by edge: these then hold the two sides of a cut at odd places
            made, seams = sewn_together(task, faults[name])
            if seams:
                changes.append(Change({name: (made,)}, tuple(seams)))
    return changes


REPAIR = Repair(
    "stitch",
    ("strongly-connected", "manifold"),
    "Merges vertices of rims that face each other across a gap of rounding, or one by one along a cut.",
    propose,
    answers=cracks,
)
