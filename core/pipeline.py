"""The full pipeline on values: check, repair, check, model every horizon (no files)."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from scipy.spatial import cKDTree

from graben.arrays import FloatArray, floats
from graben.cleaning.ledger import RepairAction
from graben.cleaning.planner import repaired
from graben.complexes import Complex
from graben.cutgraph import CutGraph
from graben.errors import ModelingError
from graben.finding import CheckResult, Profile
from graben.model import Horizon, Model
from graben.modeling.building import rebuilt
from graben.modeling.filling import ON_GRID, filled
from graben.modeling.preparation import CutHorizon, prepared
from graben.modeling.refinement import refined
from graben.modeling.results import HorizonResult
from graben.modeling.scoring import score
from graben.modeling.tracing import cut_graph
from graben.validators.context import Anchoring, Evidence
from graben.validators.runner import run_checks, shifted

if TYPE_CHECKING:
    import pyvista

#: Called with a stage and what it works on, for a progress display.
Progress = Callable[[str, str], None]


@dataclass(frozen=True, eq=False)
class RepairResult:
    """A repaired model, the ledger, and the findings before and after."""

    model: Model
    actions: tuple[RepairAction, ...]
    before: CheckResult
    after: CheckResult

    def __repr__(self) -> str:
        lines = [
            f"Repair: {len(self.actions)} actions, {'passed' if self.after.passed else 'not passed'} after"
        ]
        lines += [f"  {a.action:<8} {', '.join(a.objects)}: {a.reason} ({a.count})" for a in self.actions]
        return "\n".join(lines)

    def to_pyvista(self) -> pyvista.MultiBlock:
        """Return the surfaces of the repaired model as a named ``pyvista.MultiBlock``."""
        return self.model.to_pyvista()

    def _repr_html_(self) -> str:
        from html import escape

        rows = "".join(
            f"<tr><td>{escape(a.action)}</td><td>{escape(', '.join(a.objects))}</td><td>{a.count}</td>"
            f"<td>{escape(a.reason)}</td></tr>"
            for a in self.actions
        )
        table = f"<table><tr><th>repair</th><th>objects</th><th>count</th><th>reason</th></tr>{rows}</table>"
        return table + self.after._repr_html_()


@dataclass(frozen=True, eq=False)
class RunResult:
    """Everything a run found and made; coordinates are the input's, z is elevation.

    Parameters
    ----------
    model, repaired : Model
        The input, and what was modeled.
    before, after : CheckResult
        Findings of both.
    repairs : tuple of RepairAction
        The ledger.
    horizons : tuple of HorizonResult
        The rebuilt horizons.
    not_modeled : mapping of str to str
        Why a horizon was not modeled, by its name.
    timings : mapping of str to float
        Seconds of each stage.
    peak_memory_mb : float
        Largest memory of the process so far.
    """

    model: Model
    before: CheckResult
    repairs: tuple[RepairAction, ...]
    repaired: Model
    after: CheckResult
    horizons: tuple[HorizonResult, ...]
    not_modeled: Mapping[str, str]
    timings: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    peak_memory_mb: float = 0.0

    @property
    def passed(self) -> bool:
        """Whether the gate passes and every subdomain of every horizon ended with type 0."""
        return self.after.passed and not self.not_modeled and all(h.converged for h in self.horizons)

    def __getitem__(self, name: str) -> HorizonResult:
        """Return the rebuilt horizon of this name."""
        return {h.name: h for h in self.horizons}[name]

    def __repr__(self) -> str:
        lines = [f"Run of {self.model.name!r}: {'passed' if self.passed else 'not passed'}"]
        lines += [f"  {h!r}" for h in self.horizons]
        lines += [f"  {name} not modeled: {why}" for name, why in self.not_modeled.items()]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from html import escape

        return f"<pre>{escape(repr(self))}</pre>{self.after._repr_html_()}"

    def to_pyvista(self) -> pyvista.MultiBlock:
        """Return horizons and faults as a named ``pyvista.MultiBlock``."""
        import pyvista

        blocks = {h.name: h.to_pyvista() for h in self.horizons}
        blocks.update({f.name: f.surface.to_pyvista() for f in self.repaired.faults})
        return pyvista.MultiBlock(blocks)


class _Stages:
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
        self._progress("intersect", f"{len(model.faults)} faults")
        network = refined([f.surface for f in model.faults])
        self.seconds += time.perf_counter() - start
        return network

    def graph(self, model: Model, horizon: Horizon, complex: Complex) -> CutGraph:
        """Return the cut graph of a horizon, its crossed holes filled first."""
        start = time.perf_counter()
        self._progress("trace", horizon.name)
        whole, count = horizon, 0
        for fault in model.faults:
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


def _quiet(stage: str, what: str) -> None:
    """Report no progress."""


def _examined(model: Model, profile: Profile, progress: Progress) -> tuple[CheckResult, Evidence, _Stages]:
    """Return the findings in the model's coordinates, and what was computed in its local frame."""
    origin = model.local_origin()
    stages = _Stages(progress)
    result, evidence = run_checks(model.moved(-origin), profile, stages)
    return shifted(result, origin), evidence, stages


@dataclass(frozen=True, eq=False)
class Examination:
    """What the gate found and what it saw; coordinates are the input's, z is elevation.

    Parameters
    ----------
    model : Model
        The input.
    result : CheckResult
        The findings.
    graphs : mapping of str to CutGraph
        The traces of the faults on each horizon that has some, by its name.
    seconds : float
        How long it took.
    peak_memory_mb : float
        Largest memory of the process so far.
    """

    model: Model
    result: CheckResult
    graphs: Mapping[str, CutGraph]
    seconds: float
    peak_memory_mb: float


def examine(
    model: Model, profile: Profile | str = Profile.EXTENDED, progress: Progress | None = None
) -> Examination:
    """Return the findings of every check with what a report of them shows; parameters as of :func:`check`."""
    begin = time.perf_counter()
    result, evidence, _ = _examined(model, Profile(profile), progress or _quiet)
    graphs = {name: graph.moved(model.local_origin()) for name, graph in evidence.graphs.items()}
    return Examination(
        model, result, MappingProxyType(graphs), time.perf_counter() - begin, _peak_memory_mb()
    )


def check(model: Model, profile: Profile | str = Profile.EXTENDED) -> CheckResult:
    """Return the findings of every check that can run; the model is not changed.

    Parameters
    ----------
    model : Model
        From :func:`graben.read_model` or made in Python.
    profile : Profile or str
        "paper" or "extended".
    """
    return _examined(model, Profile(profile), _quiet)[0]


def repair(model: Model, profile: Profile | str = Profile.EXTENDED) -> RepairResult:
    """Return the model with what fails under the profile repaired, and the ledger of every change.

    This version merges duplicates and turns triangles; every other finding is left and listed.
    """
    profile = Profile(profile)
    before = check(model, profile)
    mended, actions = repaired(model, before, lambda m: check(m, profile))
    after = check(mended, profile) if actions else before
    return RepairResult(mended, actions, before, after)


def build(
    model: Model,
    profile: Profile | str = Profile.EXTENDED,
    *,
    mend: bool = True,
    progress: Progress | None = None,
) -> RunResult:
    """Return the result of the full pipeline: check, repair, check, model every horizon.

    Horizons that a failed blocking check concerns are left out and named with the reason.

    Parameters
    ----------
    model : Model
        The model.
    profile : Profile or str
        "paper" or "extended".
    mend : bool
        Whether to repair.
    progress : callable, optional
        Called with the stage and what it works on.
    """
    begin = time.perf_counter()
    profile, say = Profile(profile), progress or _quiet
    say("check", model.name)
    before, evidence, stages = _examined(model, profile, say)
    checked = time.perf_counter()
    triangulating = stages.seconds
    mended, after = model, before
    actions: tuple[RepairAction, ...] = ()
    if mend and not before.passed:
        say("repair", model.name)
        mended, actions = repaired(model, before, lambda m: check(m, profile))
    mending = time.perf_counter() - checked
    if actions:
        after, evidence, stages = _examined(mended, profile, say)
        triangulating += stages.seconds
    checking = time.perf_counter() - begin - mending - triangulating
    horizons, not_modeled = _modeled(mended, evidence, stages, say)
    seconds = {key: sum(h.seconds.get(key, 0.0) for h in horizons) for key in ("solve", "move", "deform")}
    iterations = sum(s.iterations for h in horizons for s in h.subdomains)
    timings = {
        "check": checking,
        "repair": mending,
        "triangulate": triangulating,
        **seconds,
        "write": 0.0,
        "total": time.perf_counter() - begin,
        "per_iteration": sum(seconds.values()) / iterations if iterations else 0.0,
    }
    return RunResult(
        model, before, actions, mended, after, tuple(horizons), not_modeled, timings, _peak_memory_mb()
    )


def _modeled(
    model: Model, evidence: Evidence, stages: _Stages, say: Progress
) -> tuple[list[HorizonResult], dict[str, str]]:
    """Return the rebuilt horizons in the model's coordinates, and why the others are missing."""
    origin = model.local_origin()
    local = model.moved(-origin)
    horizons: list[HorizonResult] = []
    not_modeled: dict[str, str] = {}
    for horizon in model.horizons:
        blocking = evidence.blocked(horizon.name)
        ready = stages.ready.get(horizon.name)
        if blocking or ready is None or evidence.complex is None:
            reasons = [f.message for f in blocking]
            errors = [evidence.errors[key] for key in ("", horizon.name) if key in evidence.errors]
            reasons += [e for e in errors if not any(e in reason for reason in reasons)]
            not_modeled[horizon.name] = " ".join(reasons) or "It could not be prepared."
            continue
        say("model", horizon.name)
        try:
            result = rebuilt(local, ready, evidence.complex).moved(origin)
        except ModelingError as error:
            not_modeled[horizon.name] = str(error)
            continue
        result = replace(result, warnings=stages.warnings.get(horizon.name, ()) + result.warnings)
        if model.truth is not None:
            result = replace(result, score=score(model.truth, result, model.faults))
        horizons.append(result)
    return horizons, not_modeled


def _peak_memory_mb() -> float:
    """Return the largest resident memory of this process so far, MiB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024.0**2 if sys.platform == "darwin" else 1024.0)
