"""What the modeling stage gives to the checks, and a look at a model by all of them."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from dataclasses import replace

from scipy.spatial import cKDTree

from graben.arrays import FloatArray, floats
from graben.complexes import Complex
from graben.cutgraph import CutGraph
from graben.finding import CheckResult, Profile
from graben.model import Horizon, Model
from graben.modeling.filling import ON_GRID, filled, has_undefined
from graben.modeling.preparation import CutHorizon, prepared
from graben.modeling.tracing import cut_graph
from graben.refinement import refined
from graben.validators.context import Anchoring, Evidence
from graben.validators.runner import run_checks, shifted
from graben.words import plural

#: Called with a stage and what it works on, for a progress display.
Progress = Callable[[str, str], None]


class Work(str):
    """What a stage works on, with how far the stage is.

    Parameters
    ----------
    text : str
        What.
    share : float or None
        The share of the stage's work that is done, 0 to 1; None where it is not known.
    passing : bool
        Whether it is only for a display that shows the latest, not for a list of what was done.
    """

    share: float | None
    passing: bool

    def __new__(cls, text: str, share: float | None = None, *, passing: bool = False) -> Work:
        """Return the text with what else is known."""
        made = super().__new__(cls, text)
        made.share, made.passing = share, passing
        return made


class Stages:
    """What the modeling stage gives to the checks, kept for the modeling itself."""

    def __init__(self, progress: Progress) -> None:
        self.seconds = 0.0
        self.ready: dict[str, CutHorizon] = {}
        self.warnings: dict[str, tuple[str, ...]] = {}
        self._filled: dict[str, Horizon] = {}
        self._progress = progress

    def complex(self, model: Model) -> Complex:
        """Return the common refinement of the faults."""
        start = time.perf_counter()
        self._progress("intersect", plural(len(model.faults), "fault"))
        network = refined([f.surface for f in model.faults])
        self.seconds += time.perf_counter() - start
        return network

    def graph(self, model: Model, horizon: Horizon, complex: Complex) -> CutGraph:
        """Return the cut graph of a horizon, its crossed holes filled first."""
        start = time.perf_counter()
        self._progress("trace", horizon.name)
        whole, count = horizon, 0
        for fault in model.faults if has_undefined(horizon) else ():
            whole, more = filled(whole, (fault,), model.gamma(fault, horizon))
            count += more
        if count:
            self.warnings[horizon.name] = (
                f"{count} undefined nodes were filled in holes crossed by a fault.",
            )
        self._filled[horizon.name] = whole
        graph = replace(cut_graph(model, whole, complex), filled=_added(horizon, whole))
        self.seconds += time.perf_counter() - start
        return graph

    def anchoring(self, model: Model, horizon: Horizon, graph: CutGraph) -> tuple[Anchoring, ...]:
        """Return how each subdomain is held; the cut horizon is kept for the modeling."""
        start = time.perf_counter()
        self._progress("triangulate", horizon.name)
        made = prepared(model, self._filled[horizon.name], graph)
        self.ready[horizon.name] = made
        self.seconds += time.perf_counter() - start
        return made.anchors


def _added(horizon: Horizon, whole: Horizon) -> FloatArray:
    """Return the nodes that a horizon has only since its holes were filled, shape (k, 3)."""
    nodes = whole.surface.vertices
    if whole is horizon:
        return nodes[:0]
    away = cKDTree(horizon.surface.vertices[:, :2]).query(nodes[:, :2])[0]
    return floats(nodes[away > ON_GRID * horizon.step])


def quiet(stage: str, what: str) -> None:
    """Report no progress."""


def examined(model: Model, profile: Profile, progress: Progress) -> tuple[CheckResult, Evidence, Stages]:
    """Return the findings in the model's coordinates, and what was computed in its local frame."""
    origin = model.local_origin()
    stages = Stages(progress)
    result, evidence = run_checks(model.moved(-origin), profile, stages)
    return shifted(result, origin), evidence, stages


def peak_memory_mb() -> float:
    """Return the largest resident memory of this process so far, MiB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024.0**2 if sys.platform == "darwin" else 1024.0)
