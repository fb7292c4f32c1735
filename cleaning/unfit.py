"""unfit: vertices that are no place are restored from their neighbours or go (answers `finite`)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import spsolve

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.regular import regular_places
from graben.surface import Surface
from graben.validators.finite import usable
from graben.validators.measuring.measures import components
from graben.words import plural

#: Most vertices without a place that are put in the mean where they are neighbours: more of them the mean of
#: what is around would draw together.
MOST_TOGETHER = 3


@dataclass(frozen=True, eq=False)
class Fit:
    """A surface whose coordinates and indices are fit, and what that took.

    Parameters
    ----------
    surface : Surface
        The result.
    restored : (k,) array
        Vertices of the result that got a place.
    lost : int
        How many vertices without a place are gone.
    dropped : int
        How many triangles are gone.
    """

    surface: Surface
    restored: IntArray
    lost: int
    dropped: int


def made_fit(surface: Surface) -> Fit:
    """Return a surface of places only, all indices in range; one that is fit comes back as it is.

    A vertex without a place that sound triangles surround gets the mean of its neighbours, so that the
    surface stays closed there. Up to ``MOST_TOGETHER`` of them next to each other get places each of which is
    the mean of its neighbours. More of them, and those on a rim, are put where a regular mesh would have
    them, see :func:`regular_places`. All others go with their triangles.

    >>> x = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [float("nan")] * 3]
    >>> fit = made_fit(Surface("F", x, [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]))
    >>> fit.surface.vertices[4].tolist(), fit.dropped
    ([1.0, 1.0, 0.0], 0)
    """
    n = len(surface.vertices)
    sound = bools(usable(surface.vertices).all(axis=1))
    there = ((surface.triangles >= 0) & (surface.triangles < n)).all(axis=1)
    if sound.all() and there.all():
        return Fit(surface, ints([]), 0, 0)
    triangles = surface.triangles[there]
    back = _restorable(n, triangles, sound)
    vertices = np.array(surface.vertices)
    vertices[back] = _means(vertices, triangles, sound, back)
    fit = bools(sound | np.isin(np.arange(n), back))
    vertices = regular_places(replace(surface, vertices=vertices, triangles=triangles, lines=ints([])), ~fit)
    fit = bools(usable(vertices).all(axis=1))
    back = ints(np.flatnonzero(fit & ~sound))
    kept = np.array(there)
    kept[there] = fit[triangles].all(axis=1)
    index = np.cumsum(fit) - 1
    made = replace(
        surface,
        vertices=floats(vertices[fit], -1, 3),
        triangles=ints(index[surface.triangles[kept]], -1, 3),
        lines=surface.lines[kept] if len(surface.lines) else surface.lines,
    )
    return Fit(made, ints(index[back]), int((~fit).sum()), int((~kept).sum()))


def _restorable(n: int, triangles: IntArray, sound: BoolArray) -> IntArray:
    """Return the vertices without a place whose whole cluster has a closed ring of triangles each."""
    bad = np.flatnonzero(~sound)
    at = np.flatnonzero(~sound[triangles].all(axis=1))
    corners = triangles[at]
    vertex = corners.ravel()
    # in a closed ring of triangles around a vertex each neighbour appears twice
    others = np.stack([np.roll(corners, -1, axis=1).ravel(), np.roll(corners, 1, axis=1).ravel()], axis=1)
    pairs, times = np.unique(
        np.stack([np.repeat(vertex, 2), others.ravel()], axis=1), axis=0, return_counts=True
    )
    open_end = np.zeros(n, dtype=np.bool_)
    open_end[pairs[times != 2, 0]] = True
    open_end[vertex[(vertex[:, None] == others).any(axis=1)]] = True
    used = np.zeros(n, dtype=np.bool_)
    used[vertex] = True
    links = pairs[~sound[pairs[:, 0]] & ~sound[pairs[:, 1]]]
    cluster = components(n, links)
    whole = np.bincount(cluster[bad], open_end[bad] | ~used[bad], minlength=n) == 0
    few = np.bincount(cluster[bad], minlength=n) <= MOST_TOGETHER
    return np.asarray(bad[(whole & few)[cluster[bad]]], dtype=np.int64)


def _means(vertices: FloatArray, triangles: IntArray, sound: BoolArray, back: IntArray) -> FloatArray:
    """Return places for the vertices ``back``, each the mean of its neighbours, shape (k, 3)."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges = np.unique(np.concatenate([edges, edges[:, ::-1]]), axis=0)
    edges = edges[np.isin(edges[:, 0], back)]
    row, other = np.searchsorted(back, edges[:, 0]), edges[:, 1]
    k, known = len(back), sound[other]
    total = np.stack(
        [np.bincount(row[known], vertices[other[known], j], minlength=k) for j in range(3)], axis=1
    )
    between = ~known
    matrix = csr_array(
        (
            np.concatenate([np.bincount(row, minlength=k), -np.ones(int(between.sum()))]),
            (
                np.concatenate([np.arange(k), row[between]]),
                np.concatenate([np.arange(k), np.searchsorted(back, other[between])]),
            ),
        ),
        shape=(k, k),
    )
    return np.asarray(spsolve(matrix.tocsc(), total)).reshape(k, 3) if k else np.zeros((0, 3))


def propose(task: Task) -> list[Change | Refusal]:
    """Return for each fault with an unfit coordinate or index the fault without it."""
    faults = {f.name: f.surface for f in task.model.faults}
    made: list[Change | Refusal] = []
    for finding in task.findings:
        for name in (n for n in finding.objects if n in faults):
            fit = made_fit(faults[name])
            place = finding.places[0] if len(finding.places) else None
            if not len(fit.surface.triangles):
                made.append(
                    Refusal(
                        "finite",
                        (name,),
                        f"No triangle of {name} has three vertices with a place.",
                        "Export the surface again.",
                        place,
                    )
                )
                continue
            step = Step("finite", (name,), finding.count, place, _reason(name, fit))
            made.append(Change({name: (fit.surface,)}, (step,), _declared(name, fit)))
    return made


def _declared(name: str, fit: Fit) -> dict[str, Surface]:
    """Return the triangles around restored vertices: the input has none there to measure a move from."""
    around = np.isin(fit.surface.triangles, fit.restored).any(axis=1)
    if not around.any():
        return {}
    return {name: Surface(name, fit.surface.vertices, fit.surface.triangles[around])}


def _reason(name: str, fit: Fit) -> str:
    said = []
    if len(fit.restored):
        verb = "was" if len(fit.restored) == 1 else "were"
        count = plural(len(fit.restored), "vertex", "vertices")
        said.append(f"{count} without a place {verb} put where the triangles around want them")
    if fit.lost or fit.dropped:
        vertices = f"{plural(fit.lost, 'vertex', 'vertices')} without a place" if fit.lost else ""
        triangles = plural(fit.dropped, "triangle") if fit.dropped else ""
        verb = "was" if fit.lost + fit.dropped == 1 else "were"
        said.append(f"{' and '.join(filter(None, (vertices, triangles)))} {verb} left out")
    return f"In {name} {'; '.join(said)}."


REPAIR = Repair(
    "unfit",
    ("finite",),
    "Puts vertices without a place where the mesh around wants them, or leaves them out.",
    propose,
)
