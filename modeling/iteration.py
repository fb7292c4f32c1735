"""The iteration on one subdomain: solve for u, move the cut, deform the mesh (paper Sect. 7)."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.modeling.acceleration import Anderson
from graben.modeling.algebra import Backend
from graben.modeling.deformation import Deformation
from graben.modeling.energy import Block, EdgePattern, system
from graben.modeling.guides import Guides
from graben.modeling.moves import last_move, valid_move
from graben.modeling.picks import NodeData
from graben.modeling.remeshing import Remeshed, shapes
from graben.modeling.repeated import Repeated
from graben.modeling.respacing import Arms
from graben.modeling.results import TerminationType
from graben.modeling.tangent import Slopes, tangent_step

#: Steps that the acceleration looks back.
_DEPTH = 5
#: Share of the tolerance up to which a solution may be off.
_ACCURACY = 0.01
#: Share of its area on the first mesh that a triangle keeps at least. With heights h the energy has terms of
#: 1 / h^2; a thousandth leaves some digits, a millionth was seen to leave none.
_LEAST_AREA = 1e-3
#: Steps over which the deviation must not have fallen before the boundary is said to oscillate.
_PATIENCE = 8


@dataclass(frozen=True, eq=False)
class Problem:
    """One subdomain, in its own numbering.

    Parameters
    ----------
    points : (n, 2) array
        The first mesh, model units.
    pattern : EdgePattern
        Its adjacency.
    values : (n,) array
        Elevation of the input horizon.
    unknown : (n,) bool array
        Nodes whose elevation is sought.
    fitted : (n,) bool array
        Other nodes that a least-squares fit smooths meanwhile; they keep their elevation.
    cut : (c,) array
        Nodes of the cut.
    guides : Guides
        Of the nodes of the cut.
    deformation : Deformation
        How the mesh follows.
    arms : Arms
        The lips that the nodes of the cut make.
    data, stiffness : NodeData, (k,) array
        What trusted picks and noisy elevations say of nodes (in this numbering), and the weight of each in
        the energy.
    bend : (n, 3) array
        Second derivatives K_xx, K_xy, K_yy at which the energy is least, one over model units; 0 for planes.
    theta, length, tolerance : float
        Parameters of the energy and of the termination; length and tolerance in model units.
    """

    points: FloatArray
    pattern: EdgePattern
    values: FloatArray
    unknown: BoolArray
    fitted: BoolArray
    cut: IntArray
    guides: Guides
    deformation: Deformation
    arms: Arms
    data: NodeData
    stiffness: FloatArray
    bend: FloatArray
    theta: float
    length: float
    tolerance: float

    @cached_property
    def least_areas(self) -> FloatArray:
        """Twice the plan area that each triangle keeps at least when the mesh moves, (m,)."""
        return _LEAST_AREA * shapes(self.points, self.pattern.triangles)[0]

    @cached_property
    def slopes(self) -> Slopes:
        """The slopes of a solution at the nodes of the cut."""
        return Slopes.of(self.pattern.triangles, self.cut)


@dataclass(frozen=True, eq=False)
class Outcome:
    """Where the iteration ended.

    ``points`` (n, 2) and ``values`` (n,) are the result, on the mesh ``remeshed`` if that is not None, else
    on that of the problem; ``remeshings`` is how often the mesh was made anew. ``z`` (c,) and ``guides`` are
    the elevations and the guides of the cut nodes. ``worst`` is the position in ``Problem.cut`` of the node
    that decided a type 1, 2 or 3, -1 for type 0; ``excess`` how far it still moves (type 1) or by how much
    its place lies beyond its guide, negative below (types 2 and 3), model units. ``shortened`` says that the
    last move had to be cut short, since it would have turned triangles over.
    """

    type: TerminationType
    points: FloatArray
    values: FloatArray
    z: FloatArray
    guides: Guides
    history: tuple[float, ...]
    displacement: float
    deviation: float
    worst: int = -1
    excess: float = 0.0
    shortened: bool = False
    remeshed: Remeshed | None = None
    remeshings: int = 0
    seconds: dict[str, float] = field(default_factory=dict)


class _Clock:
    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        start = time.perf_counter()
        yield
        self.seconds[stage] += time.perf_counter() - start


class _Solver:
    """The values of the unknown nodes on a deformed mesh; the symbolic factorization is made once.

    The paper's plain iteration factors every matrix anew; the accelerated one solves with an old factor
    where that serves.
    """

    def __init__(self, problem: Problem, backend: Backend, accelerated: bool) -> None:
        self.problem = problem
        solved = problem.unknown | problem.fitted
        self.unknown = np.flatnonzero(solved)
        self._data = np.searchsorted(self.unknown, problem.data.nodes)
        self._bend = problem.bend if problem.bend.any() else None
        self._own = Block.of(problem.pattern, self.unknown, self.unknown)
        self._systems = Repeated(backend, _ACCURACY * problem.tolerance if accelerated else 0.0)

    def values(self, points: FloatArray) -> FloatArray:
        """Return the minimizer of the energy on the mesh with these positions, shape (n,)."""
        p = self.problem
        matrix, bent = system(points, p.pattern, p.theta, p.length, self._bend)
        own = self._own.of_matrix(matrix)
        # Solved for the difference from the input, whose size is that of the throw, not of the depth.
        shift = points[p.data.nodes] - p.points[p.data.nodes]
        misfit = p.values[p.data.nodes] - p.data.z - (p.data.gradient * shift).sum(axis=1)
        load = (matrix @ p.values - bent)[self.unknown]
        if len(self._data):
            load[self._data] += p.stiffness * misfit
            diagonal = own.diagonal()
            diagonal[self._data] += p.stiffness
            own.setdiag(diagonal)
        result = p.values.copy()
        result[self.unknown] -= self._systems.solve(own, load)
        result[p.fitted] = p.values[p.fitted]
        return result


def iterated(problem: Problem, backend: Backend, max_iterations: int, accelerated: bool) -> Outcome:
    """Return the fixed point of the movement of the cut, or where the iteration had to stop.

    The iterate is the elevation z of each node of the cut; its image is the value of u at the node's
    place P(z) on its guide, on the first mesh deformed by the whole move. An iteration is one solve and
    one move. Where nodes need more than their guides, the iteration is repeated with these continued
    straight on: that tells how much is missing when all nodes have come to rest, and whether it is.

    Parameters
    ----------
    problem : Problem
        The subdomain.
    backend : Backend
        Linear algebra.
    max_iterations : int
        After these, type 1.
    accelerated : bool
        Newton's step along the guides, with Anderson acceleration; False is the paper's plain iteration.
    """
    outcome = _approached(problem, backend, max_iterations, accelerated)
    if outcome.type is not TerminationType.PROJECTION_FAILURE:
        return outcome
    whole = replace(problem, guides=outcome.guides.continued(float(np.ptp(problem.values))))
    beyond = _approached(whole, backend, max_iterations, accelerated)
    if beyond.type is not TerminationType.CONVERGED or beyond.guides is not whole.guides:
        return outcome
    excess = outcome.guides.excess(beyond.z)
    worst = int(np.argmax(np.abs(excess)))
    if abs(excess[worst]) <= problem.tolerance:
        # The way there led beyond the guides, the end does not.
        return replace(beyond, history=outcome.history + beyond.history)
    return replace(outcome, worst=worst, excess=float(excess[worst]))


def _approached(problem: Problem, backend: Backend, max_iterations: int, accelerated: bool) -> Outcome:
    """Return the outcome of one run of the iteration; parameters as of :func:`iterated`."""
    clock = _Clock()
    solver = _Solver(problem, backend, accelerated)
    mixer = Anderson(_DEPTH if accelerated else 0)
    tolerance = problem.tolerance
    mesh, remeshings, shortened = None, 0, False
    z = problem.values[problem.cut]
    points = problem.points
    before, beyond = z, np.zeros(len(z))
    history: list[float] = []
    course: list[float] = []
    ended = TerminationType.STAGNATION
    for _ in range(max_iterations):
        with clock("solve"):
            values = solver.values(points)
        image = values[problem.cut]
        history.append(float(np.abs(image - before).max()))
        away = np.maximum(np.abs(image - before), np.abs(image - z))
        course.append(float(away.max()))
        excess, worst, amount = problem.guides.excess(image), int(np.argmax(away)), course[-1]
        folded = course[-1] < tolerance and problem.arms.folded(problem.guides, z)
        if course[-1] < tolerance and not folded:
            ended, worst, amount = TerminationType.CONVERGED, -1, 0.0
        elif not _oscillates(course) and (short := _short(excess, beyond, tolerance)) >= 0:
            ended, worst, amount = TerminationType.PROJECTION_FAILURE, short, float(excess[short])
        stop = ended is not TerminationType.STAGNATION or _oscillates(course) or folded
        with clock("move"):
            ahead = _ahead(problem, points, values, z, image) if accelerated and not stop else image
            target = problem.guides.clipped(image if stop else mixer.following(z, ahead))
        with clock("deform"):
            at_rest = ended is TerminationType.CONVERGED and not shortened
            last = last_move(problem, points, target) if at_rest else None
            move = last or valid_move(
                problem, z, target, image, backend, patient=not shortened, folded=folded
            )
        shortened = move.z is not target and not move.spaced
        displacement = float(np.hypot(*(move.points[move.problem.cut] - points[problem.cut]).T).mean())
        deviation = float(np.abs(image - before).mean())
        z, points, problem, before, beyond = move.z, move.points, move.problem, image, excess
        if move.remeshed is not None:
            mesh = move.remeshed if mesh is None else mesh.then(move.remeshed)
            remeshings += 1
            solver = _Solver(problem, backend, accelerated)
            values = move.remeshed.weights @ values
        if move.remeshed is not None or move.spaced:
            # Another map than before: what the iteration has learnt of it starts anew.
            mixer, course = Anderson(_DEPTH if accelerated else 0), []
        if move.spaced:
            before, beyond, ended = z, np.zeros(len(z)), TerminationType.STAGNATION
        elif stop:
            break
    values = values.copy()
    values[problem.cut] = z
    return Outcome(
        ended,
        points,
        values,
        z,
        problem.guides,
        tuple(history),
        displacement,
        deviation,
        worst,
        amount,
        shortened,
        mesh,
        remeshings,
        seconds=dict(clock.seconds),
    )


def _ahead(
    problem: Problem, points: FloatArray, values: FloatArray, z: FloatArray, image: FloatArray
) -> FloatArray:
    """Return where the tangents of a solution meet the guides, (c,); ``z`` and ``image`` (c,) as there."""
    slope = problem.slopes.gradients(points, values)
    return tangent_step(z, image, (slope * problem.guides.rates(z)).sum(axis=1))


def _oscillates(course: list[float]) -> bool:
    """Return whether the last steps brought the deviation no lower than it was before them."""
    if len(course) <= _PATIENCE:
        return False
    return min(course[-_PATIENCE:]) >= min(course[:-_PATIENCE])


def _short(excess: FloatArray, before: FloatArray, tolerance: float) -> int:
    """Return the node furthest beyond its guide in two successive steps without coming back; -1 for none."""
    same = (np.abs(excess) > tolerance) & (excess * before > 0) & (np.abs(excess) > 0.5 * np.abs(before))
    if not same.any():
        return -1
    return int(np.argmax(np.where(same, np.abs(excess), 0.0)))
