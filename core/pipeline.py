"""The full pipeline on values: check, repair, check, model every horizon (no files)."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from os import PathLike
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from graben import tables
from graben.arrays import FloatArray
from graben.cleaning.ledger import Left, RepairAction
from graben.cutgraph import CutGraph
from graben.finding import CheckResult, Profile
from graben.formats.vtk_fields import add_text
from graben.given import given
from graben.horizons import Kept, modeled
from graben.keeping import NotKeptError, from_bytes, to_bytes
from graben.model import Model
from graben.modeling.crossing import crossings
from graben.modeling.quality import judged
from graben.modeling.results import HorizonResult, Subdomain
from graben.notebook import html_table
from graben.repairs import Look, mended
from graben.stages import Progress, Stages, examined, peak_memory_mb, quiet
from graben.validators.runner import run_checks, shifted

if TYPE_CHECKING:
    import pandas
    import pyvista

#: Under this the outcome of the repair is kept.
_REPAIR = "repair"


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
        rows: list[tuple[object, ...]] = [
            (h.name, ", ".join(h.graph_faults), h.largest_throw, _types(h.subdomains)) for h in self.horizons
        ]
        rows += [(name, "", "", f"not modeled: {why}") for name, why in self.not_modeled.items()]
        title = f"Run of {self.model.name!r}: {'passed' if self.passed else 'not passed'}"
        columns = ("horizon", "faults", "largest throw", "ended")
        return html_table(columns, rows, title) + self.after._repr_html_()

    def cutoffs(self) -> pandas.DataFrame:
        """Return all cutoffs: see :func:`graben.tables.cutoffs_table`."""
        return tables.cutoffs_table(self)

    def throws(self) -> pandas.DataFrame:
        """Return throw and length of each fault on each horizon: see :func:`graben.tables.throws_table`."""
        return tables.throws_table(self)

    def iterations(self) -> pandas.DataFrame:
        """Return the course of each iteration: see :func:`graben.tables.iterations_table`."""
        return tables.iterations_table(self)

    def misfit(self) -> pandas.DataFrame:
        """Return the misfit by distance from the faults: see :func:`graben.tables.misfit_table`."""
        return tables.misfit_table(self)

    def to_pyvista(self) -> pyvista.MultiBlock:
        """Return horizons and faults as a ``pyvista.MultiBlock`` by their names.

        Horizons have the point arrays of :meth:`HorizonResult.to_pyvista`. The field arrays ``kind`` (horizon
        or fault) and ``name`` say of each block what it is.
        """
        import pyvista

        blocks = pyvista.MultiBlock()
        named = [("horizon", h.name, h.to_pyvista()) for h in self.horizons]
        named += [("fault", f.name, f.surface.to_pyvista()) for f in self.repaired.faults]
        for kind, name, block in named:
            add_text(block, "kind", kind)
            add_text(block, "name", name)
            blocks.append(block, name)
        return blocks


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


def _types(subdomains: Sequence[Subdomain]) -> str:
    """Return how many subdomains ended in each way, such as "3 converged (type 0)"."""
    ended = [f"{s.termination.name} (type {int(s.termination.type)})" for s in subdomains]
    return ", ".join(f"{ended.count(words)} {words}" for words in dict.fromkeys(ended))


def examine(
    model: Model, profile: Profile | str = Profile.EXTENDED, progress: Progress | None = None
) -> Examination:
    """Return the findings of every check with what a report of them shows; parameters as of :func:`check`."""
    begin = time.perf_counter()
    result, evidence, _ = examined(model, Profile(profile), progress or quiet)
    graphs = {name: graph.moved(model.local_origin()) for name, graph in evidence.graphs.items()}
    return Examination(model, result, MappingProxyType(graphs), time.perf_counter() - begin, peak_memory_mb())


def check(model: Model | str | PathLike[str], profile: Profile | str = Profile.EXTENDED) -> CheckResult:
    """Return the findings of every check that can run; the model is not changed.

    Parameters
    ----------
    model : Model, str or path
        From :func:`graben.read_model` or made in Python; or the path of a model.toml.
    profile : Profile or str
        "paper" or "extended".
    """
    profile = Profile(profile)
    return examined(given(model), profile, quiet)[0]


def build(
    model: Model | str | PathLike[str],
    profile: Profile | str = Profile.EXTENDED,
    *,
    mend: bool = True,
    progress: Progress | None = None,
    executor: Executor | None = None,
    kept: Kept | None = None,
    workers: int | None = None,
) -> RunResult:
    """Return the result of the full pipeline: check, repair, check, model every horizon.

    Horizons that a failed blocking check concerns are left out and named with the reason.

    Parameters
    ----------
    model : Model, str or path
        The model, or the path of its model.toml.
    profile : Profile or str
        "paper" or "extended".
    mend : bool
        Whether to repair.
    progress : callable, optional
        Called with the stage and what it works on.
    executor : Executor, optional
        Of ``concurrent.futures`` or alike: where to rebuild horizons side by side. By default they are
        rebuilt one after the other; the result is the same.
    kept : mutable mapping of str to bytes, optional
        Work that is done, from an earlier call with the same model, profile and ``mend`` that was broken off:
        it is not done again. What ends is added. Seconds of such work count in ``timings``, but not in its
        total.
    workers : int, optional
        Most processes that solve independent parts of a horizon side by side; default one for each processor.
        The result does not depend on it.
    """
    begin = time.perf_counter()
    profile, say = Profile(profile), progress or quiet
    model = given(model)
    say("check", model.name)
    gate = _gate(model, profile, mend, say, kept)
    look = gate.look
    mending = time.perf_counter() - begin - look.seconds - look.stages.seconds
    rebuilt, not_modeled = modeled(gate.repaired, look, say, executor, kept, workers)
    horizons = _with_doubts(rebuilt, gate.repaired)
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
        gate.before,
        gate.repairs,
        gate.repaired,
        gate.after,
        horizons,
        not_modeled,
        gate.left,
        timings,
        peak_memory_mb(),
    )


def _with_doubts(horizons: Sequence[HorizonResult], model: Model) -> tuple[HorizonResult, ...]:
    """Return the horizons with warnings of what is doubtful about them, and of where one crosses another."""
    found = crossings(horizons, [f.surface for f in model.faults], model.tolerance)
    crossed = [
        replace(h, warnings=(*h.warnings, *(c.warning(model.unit) for c in found if c.upper == h.name)))
        for h in horizons
    ]
    return tuple(judged(h, model) for h in crossed)


@dataclass(frozen=True, eq=False)
class _Gate:
    """What check, repair and check came to, and the last look at the model."""

    repaired: Model
    before: CheckResult
    after: CheckResult
    repairs: tuple[RepairAction, ...]
    left: tuple[Left, ...]
    look: Look


def _gate(model: Model, profile: Profile, mend: bool, say: Progress, kept: Kept | None) -> _Gate:
    """Return what stands before the modeling; a repair that was kept is not done again."""
    if not mend:
        result, look = _seen(model, model.local_origin(), profile, say)
        return _Gate(model, result, result, (), (), look)
    known = None if kept is None else _recalled(kept)
    if known is not None:
        whole = replace(model, faults=known.pop("faults"))
        return _Gate(whole, look=_seen(whole, model.local_origin(), profile, say)[1], **known)
    done, look = mended(model, profile, say)
    # A repair that found nothing to do took no longer than the look that a resumed run needs all the same.
    if kept is not None and (done.actions or done.left):
        keys = ("before", "after", "left")
        outcome = {"faults": done.model.faults, "repairs": done.actions}
        kept[_REPAIR] = to_bytes({**outcome, **{key: getattr(done, key) for key in keys}})
    return _Gate(done.model, done.before, done.after, done.actions, done.left, look)


def _seen(model: Model, origin: FloatArray, profile: Profile, say: Progress) -> tuple[CheckResult, Look]:
    """Return the findings in the model's coordinates, and the look in the frame of ``origin``."""
    begin = time.perf_counter()
    stages = Stages(say)
    result, evidence = run_checks(model.moved(-origin), profile, stages)
    spent = time.perf_counter() - begin - stages.seconds
    return shifted(result, origin), Look(origin, evidence, stages, spent)


def _recalled(kept: Kept) -> dict[str, Any] | None:
    """Return what was kept of the repair; None where nothing was, or nothing that can be read."""
    try:
        found: dict[str, Any] | None = from_bytes(kept[_REPAIR]) if _REPAIR in kept else None
    except NotKeptError:
        return None
    return found
