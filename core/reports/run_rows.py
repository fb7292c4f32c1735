"""The tables of a run's report: what stands out, horizons, subdomains, throws, products, settings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from graben.finding import CheckResult
from graben.modeling.results import HorizonResult, Subdomain, TerminationType
from graben.modeling.throws import FaultThrow
from graben.reports.along_strike import fitted_name
from graben.reports.check_parts import MOST_ROWS, counts, told
from graben.reports.curve import curve
from graben.reports.json_report import Files
from graben.reports.model_files import ModelFiles
from graben.reports.plain import named
from graben.reports.repair_moves import FaultChange
from graben.reports.run_notes import spot, termination_place
from graben.reports.scene import Space
from graben.reports.style import Frame, nice, rounded
from graben.reports.summary import WALLS
from graben.settings import Parameters, meaning
from graben.words import plural

if TYPE_CHECKING:
    from graben.pipeline import RunResult

#: Changes of faults below this share of the model's size are rounding.
_NOISE = 1e-8
#: Lengths from which on they are told in kilometres, metres.
_FAR = 10_000.0
#: A move below this share of the tolerance says no more than that it is small.
_TELLING = 0.01


def facts(result: RunResult) -> str:
    """Return what kind of model it is, in one line."""
    model = result.model
    said = [sizes(result)]
    said += [f"profile {result.after.profile}", f"unit {model.unit}", f"z is {model.z}"]
    return ", ".join([*said, *([model.crs] if model.crs else [])])


def sizes(result: RunResult) -> str:
    """Return how many horizons and faults a run has, with the faults after repair where these are others."""
    given, repaired = len(result.model.faults), len(result.repaired.faults)
    said = f"{plural(len(result.model.horizons), 'horizon')}, {plural(given, 'fault')}"
    return said if given == repaired else f"{said} ({repaired} after repair)"


def key_figures(
    result: RunResult, throws: Sequence[FaultThrow], changed: Sequence[FaultChange], frame: Frame
) -> list[tuple[str, str, str]]:
    """Return what stands out: a label, a value and a note each."""
    rows = [_modeled(result)]
    if throws:
        rows.append(_largest(result, throws, frame))
        length = sum(t.length for t in throws)
        traces = plural(len(throws), "fault trace")
        rows.append(("Cutoffs", _far(length, frame), traces))
    subdomains = [s for h in result.horizons for s in h.subdomains if s.iterations]
    if subdomains:
        good = sum(s.termination.type is TerminationType.CONVERGED for s in subdomains)
        most_steps = max(s.iterations for s in subdomains)
        noun = "subdomain" if len(subdomains) == 1 else "subdomains"
        note = f"{noun}, in at most {plural(most_steps, 'iteration')}"
        rows.append(("Converged", f"{good} of {len(subdomains)}", note))
    rows.append(("Findings of the checks", *_check_words(result.after, result.before)))
    rows.append(("Repairs", str(len(result.repairs)), _repair_words(result, changed, frame)))
    scored = [h.score for h in result.horizons if h.score is not None]
    if scored:
        worst = max(s.cutoff.percent for s in scored)
        rows.append(("Error of the cutoffs", f"{rounded(worst)} %", "of the largest true throw"))
    return rows


def _modeled(result: RunResult) -> tuple[str, str, str]:
    """Return how many horizons are as they should be, and what the others are."""
    good = sum(h.converged for h in result.horizons)
    cut = sum(bool(h.cutoffs) for h in result.horizons)
    notes = [f"{cut} cut by faults"]
    if good < len(result.horizons):
        notes.append(f"{len(result.horizons) - good} did not converge")
    if result.not_modeled:
        notes.append(f"{len(result.not_modeled)} not modeled")
    return "Horizons modeled", f"{good} of {len(result.model.horizons)}", ", ".join(notes)


def _largest(result: RunResult, throws: Sequence[FaultThrow], frame: Frame) -> tuple[str, str, str]:
    """Return the largest throw of the horizons that converged; of others only, marked, where none did."""
    final = {h.name for h in result.horizons if h.converged}
    most = max(throws, key=lambda t: (t.horizon in final, abs(t.throw)))
    mark = "" if most.horizon in final else ", not final"
    where = f"{fitted_name(most.fault)} on {fitted_name(most.horizon)}{mark}"
    return "Largest throw", frame.length(most.throw), where


def _check_words(after: CheckResult, before: CheckResult) -> tuple[str, str]:
    """Return how many findings fail and warn, and how many did in the input."""
    value, was = (counts(result.findings) or "none" for result in (after, before))
    return value, "as in the input" if value == was else f"in the input {was}"


def _repair_words(result: RunResult, changed: Sequence[FaultChange], frame: Frame) -> str:
    """Return how far repair went at most."""
    if not result.repairs:
        return "nothing was changed"
    words = []
    for what, key in (
        ("moved by up to {}", "largest_move"),
        ("up to {} beyond their rims", "extended"),
        ("cut back by up to {}", "cut_back"),
    ):
        far = max((getattr(c, key) for c in changed), default=0.0)
        if far > _NOISE * result.model.size:
            words.append(what.format(frame.length(far)))
    count = plural(len(changed), "fault")
    return f"{count}: {', '.join(words)}" if words else f"{count} changed"


def _far(length: float, frame: Frame) -> str:
    if frame.unit == "m" and length >= _FAR:
        return f"{rounded(length / 1000.0)} km"
    return frame.length(length)


def settings(run: RunResult, result: HorizonResult, frame: Frame) -> str:
    """Return the step of a horizon and the gamma of each fault on it, in words."""
    unit = f" {frame.unit}" if frame.unit else ""
    step = f"Step {rounded(result.horizon.step)}{unit}"
    faults = [f for f in run.repaired.faults if f.name in result.graph_faults]
    gammas: dict[str, list[str]] = {}
    for f in faults:
        gammas.setdefault(rounded(run.model.gamma(f, result.horizon)), []).append(f.name)
    words = [f"{gamma}{unit} around {named(names)}" for gamma, names in gammas.items()]
    return f"{step}; rebuilt within {', '.join(words)} (gamma)." if gammas else f"{step}."


def _steps(result: RunResult, frame: Frame) -> list[tuple[str, str]]:
    """Return the step and the gamma of each fault as they were used, horizons alike in one row."""
    alike: dict[str, list[str]] = {}
    for h in result.horizons:
        alike.setdefault(settings(result, h, frame).rstrip("."), []).append(h.name)
    return [(f"on {named(names)}", words) for words, names in alike.items()]


def subdomain_rows(result: RunResult, space: Space | None, frame: Frame) -> dict[str, Any]:
    """Return a row for each subdomain, horizon by horizon, and what was left out."""
    both = [(h, s) for h in result.horizons for s in h.subdomains]
    # Those that did not converge are never left out.
    shown = sorted(both, key=lambda p: p[1].termination.type is TerminationType.CONVERGED)[:MOST_ROWS]
    kept = {id(s) for _, s in shown}
    rows = [_subdomain(h, s, result, space, frame) for h, s in both if id(s) in kept]
    more = len(both) - len(rows)
    said = f"{plural(more, 'more subdomain')} that converged: all are in report.json." if more > 0 else ""
    return {"subdomains": rows, "subdomains_more": said}


def _subdomain(
    horizon: HorizonResult, s: Subdomain, result: RunResult, space: Space | None, frame: Frame
) -> dict[str, Any]:
    t, step = s.termination, horizon.horizon.step
    where = [] if t.fault is None else [f"{t.fault}, {WALLS[t.side]}" if t.side else t.fault]
    place = termination_place(s)
    if place is not None:
        where.append(frame.place(place, step))
    if t.short_by is not None:
        where.append(f"short by {frame.length(t.short_by)}")
    return {
        "horizon": told(horizon.name),
        "id": s.id,
        "faults": told(named(s.faults)) or "none",
        "unknowns": f"{s.unknowns:,}",
        "iterations": s.iterations,
        "type": int(t.type),
        "name": t.name if s.iterations or t.type else "not cut",
        "where": told("; ".join(where)),
        "curve": curve(s.history, result.model.tolerance, frame),
        "displacement": _above(s.mean_displacement, result.model.tolerance) if s.iterations else "",
        "deviation": _above(s.mean_deviation, result.model.tolerance) if s.iterations else "",
        **spot(place, space, step),
    }


def _above(value: float, tolerance: float) -> str:
    """Return a length of an iteration; one far below the tolerance is told as that."""
    least = nice(_TELLING * tolerance)
    return f"< {rounded(least)}" if value < least else rounded(value)


def throw_row(throw: FaultThrow, frame: Frame, *, final: bool = True) -> dict[str, str]:
    """Return one fault on one horizon as a row, marked where its throw is not final."""
    pieces = f" in {plural(throw.pieces, 'piece')}" if throw.pieces > 1 else ""
    ends = " to ".join(throw.ends) if len(throw.ends) == 2 else ", ".join(dict.fromkeys(throw.ends))
    return {
        "horizon": told(throw.horizon if final else f"{throw.horizon} (not final)"),
        "sense": str(throw.sense),
        "throw": frame.length(throw.throw),
        "mean": frame.length(throw.mean),
        "heave": frame.length(throw.heave),
        "length": f"{frame.length(throw.length)}{pieces}",
        "ratio": f"{throw.ratio:.3f}",
        "dip": f"{throw.dip:.0f}°",
        "ends": ends,
    }


#: What the scores are the errors of.
_SCORES = {
    "cutoff": "cutoffs",
    "throw": "throw",
    "zone": "rebuilt zone",
    "zone_input": "the same zone of the input",
}


def score_rows(result: RunResult) -> list[dict[str, Any]]:
    """Return the errors against the known answer, horizon by horizon."""
    return [
        {
            "horizon": told(h.name),
            "what": label,
            "value": rounded(getattr(h.score, key).value),
            "percent": f"{getattr(h.score, key).percent:.2f}",
        }
        for h in result.horizons
        if h.score is not None
        for key, label in _SCORES.items()
    ]


#: What the files of a horizon are, for whom.
PRODUCTS = {
    "surface": ("TSurf", "SKUA-GOCAD"),
    "vtp": ("VTP", "ParaView, Python"),
    "grid": ("grid", "RMS, Petrel: Irap"),
    "cutoffs": ("cutoffs", "CSV: throw, heave, dip"),
    "polygons": ("polygons", "GIS: GeoJSON"),
    "pol": ("polygons", "RMS, Petrel: text"),
}
#: What the files of the whole model are.
_WHOLE = {
    "model": "the repaired faults and the horizons as they were modeled: a valid input again",
    "faults": "all faults in one VTU, for ParaView and Python",
    "resqml": "faults and rebuilt horizons as RESQML 2.0.1",
    "resqml_arrays": "the arrays of the RESQML package: keep it beside it",
}
_TABLES = {
    "throws": "length, throw, heave, dip and type of each fault on each horizon",
    "doubts": "where a throw is not as that of a fault should be",
    "misfit": "input less result, by distance from the fault",
    "input": "input points near faults, and how many were left out",
    "iterations": "the largest change in each iteration",
    "findings": "every finding of the last check",
}


def products(result: RunResult, files: Files, whole: ModelFiles, tables: Sequence[str]) -> dict[str, Any]:
    """Return every file of the run: those of each horizon by kind, of the whole model, and the tables."""
    kinds = [key for key in PRODUCTS if any(key in own for own in files.values())]
    rows = []
    for h in result.horizons:
        own: Mapping[str, str] = files.get(h.name, {})
        if own:
            parts = [
                (label.removeprefix("part "), path) for label, path in own.items() if label not in PRODUCTS
            ]
            cells = [(own.get(key, ""), PRODUCTS[key][0]) for key in kinds]
            rows.append({"name": told(h.name), "cells": cells, "parts": parts})
    found = [("report.json", "everything on this page as data")]
    found += [
        (path, _WHOLE[what])
        for what, path in ({"model": _MODEL} | dict(whole.files)).items()
        if what in _WHOLE
    ]
    found += [(f"tables/{name}.csv", _TABLES.get(name, "")) for name in tables]
    return {
        "kinds": [PRODUCTS[key] for key in kinds],
        "product_rows": rows,
        "has_parts": any(row["parts"] for row in rows),
        "whole": found,
        "not_written": [(_WHOLE[what], told(why)) for what, why in whole.not_written.items()],
    }


_MODEL = "model/model.toml"


def parameters(result: RunResult, frame: Frame) -> list[tuple[str, str]]:
    """Return the settings of the run, key by key."""
    model, p = result.model, result.model.parameters
    rows = [
        ("graben", version("graben")),
        ("model file", model.file.name if model.file else ""),
        ("theta", f"{p.theta:g}, {meaning(Parameters, 'theta')[0]}"),
        *(
            (key, f"default: {meaning(Parameters, key)[1]}" if value is None else frame.length(value))
            for key, value in (("length", p.length), ("gamma", p.gamma))
        ),
        *_steps(result, frame),
        ("tolerance", frame.length(model.tolerance)),
        ("max_iterations", str(p.max_iterations)),
        ("min_dip", f"{p.min_dip:g}°"),
        ("acceleration", "on" if p.acceleration else "off: the plain iteration of the paper"),
        ("coordinate system", model.crs or "not given"),
    ]
    return [(told(key), told(value)) for key, value in rows if value]
