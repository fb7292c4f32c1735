"""Every horizon of a model rebuilt: one after the other or side by side, and none that was kept again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, MutableMapping
from concurrent.futures import BrokenExecutor, Executor, as_completed
from dataclasses import fields, replace
from typing import Any

from graben.complexes import Complex
from graben.counting import Counted
from graben.errors import GrabenError, ModelingError
from graben.keeping import NotKeptError, from_bytes, to_bytes
from graben.model import Model
from graben.modeling.algebra import Backend, Cholmod
from graben.modeling.building import rebuilt
from graben.modeling.preparation import CutHorizon
from graben.modeling.results import HorizonResult
from graben.modeling.scoring import score
from graben.repairs import Look
from graben.stages import Progress, Work
from graben.words import plural

#: Work that is done, as bytes by what it is.
Kept = MutableMapping[str, bytes]

#: What a result has in common with what it was made from, which a resumed run makes anew.
_GIVEN = ("horizon", "graph")


def modeled(
    model: Model,
    look: Look,
    say: Progress,
    executor: Executor | None = None,
    kept: Kept | None = None,
    workers: int | None = None,
) -> tuple[list[HorizonResult], dict[str, str]]:
    """Return the rebuilt horizons in the model's coordinates, and why the others are missing.

    Parameters
    ----------
    model : Model
        In its own coordinates.
    look : Look
        What the gate saw of it.
    say : callable
        Progress.
    executor : Executor, optional
        Where to rebuild horizons side by side; by default they are rebuilt here, one after the other.
    kept : mutable mapping of str to bytes, optional
        Horizons that are there are not rebuilt again; each is added as it ends.
    workers : int, optional
        Most processes here that solve independent parts of a horizon; default one for each processor.
    """
    local = model.moved(-look.origin)
    not_modeled: dict[str, str] = {}
    ready: dict[str, CutHorizon] = {}
    for horizon in model.horizons:
        why = _missing(horizon.name, look)
        if why is None:
            ready[horizon.name] = look.stages.ready[horizon.name]
        else:
            not_modeled[horizon.name] = why
    results: dict[str, HorizonResult] = {}
    for name, ended in _ended(local, ready, look.evidence.complex, say, executor, kept, workers):
        if isinstance(ended, str):
            not_modeled[name] = ended
            continue
        result = ended.moved(look.origin)
        warnings = look.stages.warnings.get(name, ()) + result.warnings
        rating = None if model.truth is None else score(model.truth, result, model.faults)
        results[name] = replace(result, warnings=warnings, score=rating)
    order = [h.name for h in model.horizons]
    return (
        [results[name] for name in order if name in results],
        {name: not_modeled[name] for name in order if name in not_modeled},
    )


def _missing(name: str, look: Look) -> str | None:
    """Return why a horizon cannot be modeled; None where it can."""
    evidence = look.evidence
    blocking = evidence.blocked(name)
    if not blocking and name in look.stages.ready and evidence.complex is not None:
        return None
    reasons = [f.message for f in blocking]
    errors = [evidence.errors[key] for key in ("", name) if key in evidence.errors]
    reasons += [e for e in errors if not any(e in reason for reason in reasons)]
    return " ".join(reasons) or "It could not be prepared."


def _ended(
    local: Model,
    ready: dict[str, CutHorizon],
    network: Complex | None,
    say: Progress,
    executor: Executor | None,
    kept: Kept | None,
    workers: int | None,
) -> Iterator[tuple[str, HorizonResult | str]]:
    """Yield each horizon that is ready as it ended, in the local frame, or why it could not be rebuilt."""
    if network is None:
        return
    keys = {name: f"horizon-{number}" for number, name in enumerate(ready, start=1)}
    known = {} if kept is None else {n: _recalled(kept, keys[n], given) for n, given in ready.items()}
    yield from ((name, ended) for name, ended in known.items() if ended is not None)
    todo = {name: given for name, given in ready.items() if known.get(name) is None}
    # A mapping proxy cannot be sent to another process, and the modeling does not ask for the checks.
    lean = replace(local, checks={})
    if executor is not None and len(todo) > 1:
        for name, content in _elsewhere(lean, todo, network, say, executor):
            if kept is not None:
                kept[keys[name]] = content
            yield name, _unpacked(content, ready[name])
        return
    for name, telling in _told(todo, say):
        ended = _rebuilt(lean, todo[name], network, workers, Counted(Cholmod(), telling))
        # After the only horizon of a run nothing is left to break off but the writing.
        if kept is not None and len(ready) > 1:
            kept[keys[name]] = _packed(ended)
        yield name, ended


def _told(todo: dict[str, CutHorizon], say: Progress) -> Iterator[tuple[str, Callable[[int], None]]]:
    """Yield each horizon as its turn comes, with what tells how many systems were solved for it.

    The share that is done goes by the nodes that are looked for.
    """
    sizes = {name: int(given.unknown.sum()) for name, given in todo.items()}
    whole, done = max(sum(sizes.values()), 1), 0
    for number, name in enumerate(todo, start=1):
        what = f"{name}, horizon {number} of {len(todo)}, {plural(sizes[name], 'unknown')}"
        say("model", Work(what, done / whole))

        def telling(count: int, what: str = what, share: float = done / whole) -> None:
            say("model", Work(f"{what}, solve {count}", share, passing=True))

        yield name, telling
        done += sizes[name]


def _elsewhere(
    local: Model, todo: dict[str, CutHorizon], network: Complex, say: Progress, executor: Executor
) -> Iterator[tuple[str, bytes]]:
    """Yield horizons rebuilt side by side, packed, in the order in which they end."""
    futures = {executor.submit(_rebuilt_bytes, local, given, network): n for n, given in todo.items()}
    say("model", f"{plural(len(todo), 'horizon')} side by side")
    for count, future in enumerate(as_completed(futures), start=1):
        try:
            content = future.result()
        except BrokenExecutor as error:
            raise GrabenError(
                f"A worker ended before horizon {futures[future]!r} did ({error}), as happens for want of "
                "memory: give it more."
            ) from error
        say("model", Work(f"{count} of {len(todo)} horizons done", count / len(todo)))
        yield futures[future], content


def _rebuilt(
    local: Model,
    given: CutHorizon,
    network: Complex,
    workers: int | None,
    backend: Backend | None = None,
) -> HorizonResult | str:
    try:
        return rebuilt(local, given, network, backend=backend, workers=workers)
    except ModelingError as error:
        return str(error)


def _rebuilt_bytes(local: Model, given: CutHorizon, network: Complex) -> bytes:
    # The executor has as many workers as there are processors for.
    return _packed(_rebuilt(local, given, network, workers=1))


def _packed(ended: HorizonResult | str) -> bytes:
    if isinstance(ended, str):
        return to_bytes(ended)
    return to_bytes({f.name: getattr(ended, f.name) for f in fields(ended) if f.name not in _GIVEN})


def _unpacked(content: bytes, given: CutHorizon) -> HorizonResult | str:
    told: dict[str, Any] | str = from_bytes(content)
    return told if isinstance(told, str) else HorizonResult(given.horizon, graph=given.graph, **told)


def _recalled(kept: Kept, key: str, given: CutHorizon) -> HorizonResult | str | None:
    """Return what was kept of a horizon; None where nothing was, or nothing that can be read."""
    try:
        return _unpacked(kept[key], given) if key in kept else None
    except (NotKeptError, TypeError):
        return None
