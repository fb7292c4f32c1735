"""The full pipeline on values: check, repair, check, model every horizon (no files)."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from graben.cleaning.ledger import Left, RepairAction
from graben.cutgraph import CutGraph
from graben.errors import ModelingError
from graben.finding import CheckResult, Profile
from graben.model import Model
from graben.modeling.building import rebuilt
from graben.modeling.results import HorizonResult
from graben.modeling.scoring import score
from graben.repairs import Look, mended
from graben.stages import Progress, examined, peak_memory_mb, quiet

if TYPE_CHECKING:
    import pyvista


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
    left : tuple of Left
        What repair left, and why.
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
    left: tuple[Left, ...] = ()
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
    result, evidence, _ = examined(model, Profile(profile), progress or quiet)
    graphs = {name: graph.moved(model.local_origin()) for name, graph in evidence.graphs.items()}
    return Examination(model, result, MappingProxyType(graphs), time.perf_counter() - begin, peak_memory_mb())


def check(model: Model, profile: Profile | str = Profile.EXTENDED) -> CheckResult:
    """Return the findings of every check that can run; the model is not changed.

    Parameters
    ----------
    model : Model
        From :func:`graben.read_model` or made in Python.
    profile : Profile or str
        "paper" or "extended".
    """
    return examined(model, Profile(profile), quiet)[0]


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
    profile, say = Profile(profile), progress or quiet
    say("check", model.name)
    actions: tuple[RepairAction, ...] = ()
    left: tuple[Left, ...] = ()
    if mend:
        done, look = mended(model, profile, say)
        whole, before, after = done.model, done.before, done.after
        actions, left = done.actions, done.left
    else:
        before, evidence, stages = examined(model, profile, say)
        whole, after = model, before
        spent = time.perf_counter() - begin - stages.seconds
        look = Look(model.local_origin(), evidence, stages, spent)
    mending = time.perf_counter() - begin - look.seconds - look.stages.seconds
    horizons, not_modeled = _modeled(whole, look, say)
    seconds = {key: sum(h.seconds.get(key, 0.0) for h in horizons) for key in ("solve", "move", "deform")}
    iterations = sum(s.iterations for h in horizons for s in h.subdomains)
    timings = {
        "check": look.seconds,
        "repair": mending,
        "triangulate": look.stages.seconds,
        **seconds,
        "write": 0.0,
        "total": time.perf_counter() - begin,
        "per_iteration": sum(seconds.values()) / iterations if iterations else 0.0,
    }
    return RunResult(
        model,
        before,
        actions,
        whole,
        after,
        tuple(horizons),
        not_modeled,
        left,
        timings,
        peak_memory_mb(),
    )


def _modeled(model: Model, look: Look, say: Progress) -> tuple[list[HorizonResult], dict[str, str]]:
    """Return the rebuilt horizons in the model's coordinates, and why the others are missing."""
    origin, evidence, stages = look.origin, look.evidence, look.stages
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
