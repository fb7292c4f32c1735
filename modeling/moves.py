"""One move of the mesh after its cut, and what is done where triangles would turn over (paper Sect. 5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from graben.arrays import BoolArray, FloatArray
from graben.modeling.algebra import Backend
from graben.modeling.deformation import Deformation
from graben.modeling.energy import EdgePattern
from graben.modeling.noise import node_areas
from graben.modeling.outline import Run
from graben.modeling.picks import NodeData
from graben.modeling.remeshing import Remeshed, remeshed, shapes

if TYPE_CHECKING:
    from graben.modeling.iteration import Problem

#: A move that turns triangles over is halved at most this often.
_HALVINGS = 6
#: The height of a triangle over its longest side is at least this, on meshes that were made anew between
#: close lips too.
_FLATTEST = 1e-4


@dataclass(frozen=True, eq=False)
class Move:
    """A move of the mesh.

    ``points`` (n, 2) are the positions, ``z`` (c,) the elevations of the cut nodes that it was made for.
    ``problem`` is the one given, or another in its place: with a stiffer interior, with the mesh of
    ``remeshed``, with other guides where nodes were ``spaced`` anew.
    """

    points: FloatArray
    z: FloatArray
    problem: Problem
    remeshed: Remeshed | None = None
    spaced: bool = False

    @property
    def flat(self) -> BoolArray:
        """Which triangles are turned over, or as good as without area, (m,)."""
        area, longest = shapes(self.points, self.problem.pattern.triangles)
        return np.asarray((area < self.problem.least_areas) | (area < _FLATTEST * longest), dtype=bool)


def last_move(problem: Problem, points: FloatArray, z: FloatArray) -> Move | None:
    """Return the move of the cut nodes alone, from a mesh (n, 2) to elevations ``z`` (c,) that it almost has.

    At the end they move by less than the tolerance: the rest of the mesh need not follow. None where a
    triangle would turn over for all that.
    """
    moved = points.copy()
    moved[problem.cut] = problem.guides.places(z)
    move = Move(moved, z, problem)
    return None if move.flat.any() else move


def valid_move(
    problem: Problem,
    z: FloatArray,
    target: FloatArray,
    image: FloatArray,
    backend: Backend,
    *,
    patient: bool,
    folded: bool,
) -> Move:
    """Return the move of the mesh when its cut nodes go from elevations ``z`` to ``target``, (c,) each.

    Where triangles would turn over, these are tried one after the other: a shorter step; nodes spaced anew
    where lips fold or nodes run together; the whole step with the interior stiffer where triangles are small;
    the whole step with the mesh made anew around those triangles; half the step, and so on, in the same ways.
    The last resort is to stay.

    Parameters
    ----------
    problem : Problem
        The subdomain.
    z, target, image : (c,) arrays
        Elevations of the cut nodes, model units; ``image`` is where the solution for ``z`` has them.
    backend : Backend
        Linear algebra.
    patient : bool
        Whether a shorter step will do. The iteration asks for one at a time: it goes on from there, and often
        well; when the next is too long as well, something else than the step is wrong.
    folded : bool
        Whether all is at rest with lips that fold, which is no end.
    """
    moves = _moves(problem, z, target, image, backend, patient)
    if folded:
        moves = chain(_spaced(problem, image, backend), moves)
    return next((m for m in moves if not m.flat.any()), None) or _plain(problem, z)


def _moves(
    problem: Problem, z: FloatArray, target: FloatArray, image: FloatArray, backend: Backend, patient: bool
) -> Iterator[Move]:
    """Yield the moves that :func:`valid_move` tries, its parameters, in their order."""
    whole, *shorter = _steps(z, target)
    yield _plain(problem, whole)
    if patient:
        yield from (_plain(problem, step) for step in shorter)
    folded = problem.arms.folded(problem.guides, target)
    if folded or problem.arms.crowded(problem.guides, target):
        yield from _spaced(problem, image, backend)
    if not folded:
        yield from _changed(problem, whole, backend)
    for step in shorter:
        yield _plain(problem, step)
        if not problem.arms.folded(problem.guides, step):
            yield from _changed(problem, step, backend)


def _steps(z: FloatArray, target: FloatArray) -> Iterator[FloatArray]:
    """Yield the elevations of the whole step, of half of it, and so on."""
    for _ in range(_HALVINGS):
        yield target
        target = (z + target) / 2


def _plain(problem: Problem, z: FloatArray) -> Move:
    return Move(_deformed(problem, z), z, problem)


def _changed(problem: Problem, z: FloatArray, backend: Backend) -> Iterator[Move]:
    """Yield the moves with a stiffer interior and with a new mesh."""
    stiff = replace(problem, deformation=problem.deformation.stiffened(problem.pattern, backend))
    yield _plain(stiff, z)
    moving = problem.deformation.moving
    held = np.ones(len(moving), dtype=bool)
    held[problem.deformation.free] = False
    plain = _plain(problem, z)
    allowed = np.asarray(moving[problem.pattern.triangles].any(axis=1), dtype=bool)
    made = remeshed(plain.points, problem.pattern.triangles, held, allowed, plain.flat)
    if made is not None:
        yield Move(made.points, z, _carried(problem, made, plain.points, backend), made)


def _spaced(problem: Problem, image: FloatArray, backend: Backend) -> Iterator[Move]:
    """Yield the moves to lips on which the nodes are spaced anew; the lips as they are in ``image``, (c,)."""
    guides, z = problem.arms.spaced(problem.guides, image)
    if problem.arms.folded(guides, z):
        return
    spaced = replace(problem, guides=guides)
    yield replace(_plain(spaced, z), spaced=True)
    yield from (replace(move, spaced=True) for move in _changed(spaced, z, backend))


def _deformed(problem: Problem, z: FloatArray) -> FloatArray:
    return problem.deformation.deformed(problem.cut, problem.guides.places(z))


def _carried(problem: Problem, made: Remeshed, points: FloatArray, backend: Backend) -> Problem:
    """Return the problem on a new mesh, which is its first mesh from now on.

    ``points`` (n, 2): where the nodes of the old mesh lay when it was made anew.
    """
    count = len(points)
    pattern = EdgePattern.of(made.triangles, len(made.points))
    fresh = np.ones(len(made.points) - len(made.kept), dtype=bool)
    before = problem.deformation
    held = np.zeros(count, dtype=bool)
    held[before.held] = True
    cut = made.renumbered(problem.cut, count)
    deformation = Deformation.of(
        made.points,
        pattern,
        np.append(before.moving[made.kept], fresh),
        np.append(held[made.kept], ~fresh),
        cut,
        [Run(made.renumbered(r.nodes, count), r.arcs, r.line, r.line_arcs) for r in before.runs],
        backend,
    )
    data, stiffness = _data(problem, made, points)
    return replace(
        problem,
        points=made.points,
        pattern=pattern,
        values=made.weights @ problem.values,
        unknown=np.append(problem.unknown[made.kept], fresh),
        fitted=np.append(problem.fitted[made.kept], ~fresh),
        cut=cut,
        deformation=deformation,
        data=data,
        stiffness=stiffness,
        bend=made.weights @ problem.bend,
    )


def _data(problem: Problem, made: Remeshed, points: FloatArray) -> tuple[NodeData, FloatArray]:
    """Return what picks say of the nodes of a new mesh, and its weights; parameters as of :func:`_carried`.

    A new node knows what all nodes know between which it lies. The weight of a node is in proportion to the
    area around it, that of a node that stayed is left as it is.
    """
    old = problem.data
    if len(old.nodes) == 0:
        return old, problem.stiffness
    table = np.zeros((len(points), 4))
    shift = points[old.nodes] - problem.points[old.nodes]
    table[old.nodes, 0] = old.z + (old.gradient * shift).sum(axis=1)
    table[old.nodes, 1:3] = old.gradient
    table[old.nodes, 3] = problem.stiffness / node_areas(problem.points, problem.pattern.triangles)[old.nodes]
    silent = np.ones(len(points))
    silent[old.nodes] = 0.0
    known = np.flatnonzero(made.weights @ silent == 0.0)
    z, slope_x, slope_y, density = (made.weights @ table)[known].T
    weight = density * node_areas(made.points, made.triangles)[known]
    stays = known < len(made.kept)
    own = np.zeros(len(points))
    own[old.nodes] = problem.stiffness
    weight[stays] = own[made.kept[known[stays]]]
    return NodeData(known, z, np.stack([slope_x, slope_y], axis=1)), weight
