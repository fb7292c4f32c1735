"""report.html: one file that works offline, on paper, in the dark and by keyboard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from graben.arrays import FloatArray
from graben.finding import CheckResult, Finding, Status
from graben.modeling.results import HorizonResult, Subdomain
from graben.reports.figures import convergence_figure, throw_figure
from graben.reports.json_report import Files
from graben.reports.ledger_rows import ledger
from graben.reports.model_files import ModelFiles
from graben.reports.page import Picture, picture, rendered
from graben.reports.plan_map import detail_window, map_figure
from graben.reports.section import section_figure, section_place
from graben.reports.style import Frame, rounded
from graben.reports.summary import horizon_line, plural, verdict
from graben.reports.view3d import scene

if TYPE_CHECKING:
    from graben.pipeline import RunResult

#: True throws at the rows of the cutoffs of each horizon, where a truth is known.
Truth = Mapping[str, Sequence[FloatArray]]

#: Bytes of all figures, so that the page with plotly.js (4.8 MB) and the 3D view stays below 10 MB.
_FIGURES = 3_000_000
_MAP = 4  # times the bytes of another figure
#: Meshes of more triangles are too large as drawings.
_DRAWN = 12_000
#: A section reaches this many gammas to each side.
_SECTION = 2.0
_MOST_SECTIONS = 4
_MARGIN = 2.0  # of a detail map, gammas


def report_html(
    result: RunResult, files: Files, truth: Truth | None = None, whole: ModelFiles | None = None
) -> str:
    """Return report.html of a run.

    Parameters
    ----------
    result : RunResult
        A finished run.
    files : mapping of str to mapping of str to str
        For each horizon the files written for it: what the file is -> path relative to the report.
    truth : mapping of str to sequence of (k,) arrays, optional
        For a horizon the true throws at the rows of its cutoffs.
    whole : ModelFiles, optional
        The files written for the whole model, and why others were not.

    Returns
    -------
    str
        The page. Only the timings and the peak memory differ between two runs on the same input.
    """
    return rendered("report.html", scene(result), **_page(result, files, truth or {}, whole or ModelFiles()))


def _page(result: RunResult, files: Files, truth: Truth, whole: ModelFiles) -> dict[str, Any]:
    """Return what the template shows, all of it plain text."""
    model, frame = result.model, Frame.of(result.model)
    step = max((h.step for h in model.horizons), default=model.size / 100.0 or 1.0)
    shares = sum(2 * _MAP + _MOST_SECTIONS + 2 if h.cutoffs else _MAP for h in result.horizons)
    budget = _FIGURES // max(shares, 1)
    facts = [
        plural(len(model.horizons), "horizon"),
        plural(len(model.faults), "fault"),
        f"profile {result.after.profile}",
    ]
    facts += [f"unit {model.unit}", f"z is {model.z}", *([model.crs] if model.crs else [])]
    facts += [f"theta {model.parameters.theta:g}", f"tolerance {rounded(model.tolerance)}"]
    return {
        "title": model.name,
        "passed": result.passed,
        "verdict": verdict(result),
        "facts": ", ".join(facts),
        "unit": f" [{frame.unit}]" if frame.unit else "",
        "horizons": [
            _horizon(result, h, f"horizon-{k}", files.get(h.name, {}), truth.get(h.name, ()), budget)
            for k, h in enumerate(result.horizons, start=1)
        ],
        "not_modeled": list(result.not_modeled.items()),
        "whole": [(_WHOLE[what], path) for what, path in whole.files.items() if what in _WHOLE],
        "not_written": [(_WHOLE[what], why) for what, why in whole.not_written.items()],
        "horizon_warnings": [(h.name, w) for h in result.horizons for w in h.warnings],
        "repaired": bool(result.repairs),
        "before": _check(result.before, frame, step),
        "after": _check(result.after, frame, step),
        **ledger(result.repairs, result.left, result.after, frame, step),
        "timings": [(stage.replace("_", " "), f"{s:.3f}") for stage, s in result.timings.items()],
        "memory": f"{result.peak_memory_mb:.0f}",
    }


def _settings(run: RunResult, result: HorizonResult, frame: Frame) -> str:
    """Return the step of a horizon and the gamma of each fault on it, in words."""
    unit = f" {frame.unit}" if frame.unit else ""
    step = f"Step {rounded(result.horizon.step)}{unit}"
    faults = [f for f in run.repaired.faults if f.name in result.graph_faults]
    gammas = [f"{rounded(run.model.gamma(f, result.horizon))}{unit} around {f.name}" for f in faults]
    return f"{step}; rebuilt within {', '.join(gammas)} (gamma)." if gammas else f"{step}."


def _horizon(
    run: RunResult,
    result: HorizonResult,
    anchor: str,
    files: Mapping[str, str],
    truth: Sequence[FloatArray],
    budget: int,
) -> dict[str, Any]:
    frame = Frame.of(run.model)
    score = [] if result.score is None else list(_SCORES.items())
    sections = _sections(run, result, frame, budget)
    return {
        "name": result.name,
        "anchor": anchor,
        "line": horizon_line(result, frame),
        "notes": [_settings(run, result, frame), *result.horizon.notes, *result.warnings],
        "figures": [
            *sections[:1],
            *_maps(run, result, frame, budget),
            *_profiles(run, result, frame, truth, budget),
        ],
        "more_figures": sections[1:],
        "subdomains": [_subdomain(s, frame, result.horizon.step) for s in result.subdomains],
        "score": [
            (label, rounded(getattr(result.score, key).value), f"{getattr(result.score, key).percent:.2f}")
            for key, label in score
        ],
        "files": list(files.items()),
    }


#: What the files of the whole model are; the model itself stands above them.
_WHOLE = {
    "faults": "all faults in one VTU",
    "resqml": "faults and horizons as RESQML 2.0.1",
    "resqml_arrays": "the arrays of the RESQML package",
}

_SCORES = {
    "cutoff": "the cutoffs",
    "throw": "the throw",
    "zone": "the rebuilt zone",
    "zone_input": "the same zone of the input",
}


def _maps(run: RunResult, result: HorizonResult, frame: Frame, budget: int) -> list[Picture]:
    drawing, share = len(result.surface.triangles) <= _DRAWN, _MAP * budget
    what = f"Structure map of {result.name} in plan"
    cut = f", cut by {', '.join(dict.fromkeys(c.fault for c in result.cutoffs))}" if result.cutoffs else ""
    caption = f"Structure map, {frame.z_name}."
    pictures = [picture(map_figure(result, frame), f"{what}{cut}.", caption, share, drawing)]
    window = detail_window(result, _MARGIN * _gamma(run, result))
    if window is not None:
        detail, alt = map_figure(result, frame, window), f"{what}, detail at the faults."
        pictures.append(picture(detail, alt, "The same, at the faults.", share, drawing))
    return pictures


def _sections(run: RunResult, result: HorizonResult, frame: Frame, budget: int) -> list[Picture]:
    """Return a section across each fault where its throw is largest, the fault of largest throw first."""
    names = dict.fromkeys(c.fault for c in result.cutoffs)
    places = [
        place
        for name in names
        if (place := section_place(result, name, _gamma(run, result, name))) is not None
    ]
    places.sort(key=lambda place: -abs(float(place[0].throw[place[1]])))
    pictures = []
    for cutoff, row in places[:_MOST_SECTIONS]:
        half = _SECTION * _gamma(run, result, cutoff.fault)
        figure = section_figure(result, cutoff, row, run.repaired.faults, frame, half)
        throw = frame.length(float(cutoff.throw[row]))
        alt = f"Vertical section of {result.name} across {cutoff.fault} near its largest throw; here {throw}."
        caption = f"Section across {cutoff.fault} near its largest throw, off other faults."
        pictures.append(picture(figure, alt, caption, budget))
    return pictures


def _profiles(
    run: RunResult, result: HorizonResult, frame: Frame, truth: Sequence[FloatArray], budget: int
) -> list[Picture]:
    pictures = []
    if result.cutoffs:
        figure = throw_figure(result, frame, truth)
        pictures.append(
            picture(figure, f"Throw of {result.name} along its cutoffs.", "Throw and heave.", budget)
        )
    if any(s.history for s in result.subdomains):
        figure = convergence_figure(result, run.model.tolerance, frame)
        alt = f"Largest change of the cutoffs of {result.name} in each iteration."
        pictures.append(picture(figure, alt, "Largest change ε of a cut node in each iteration.", budget))
    return pictures


def _gamma(run: RunResult, result: HorizonResult, fault: str | None = None) -> float:
    """Return gamma of one fault or the largest on a horizon, model units."""
    faults = [f for f in run.repaired.faults if fault in (None, f.name)]
    return max((run.model.gamma(f, result.horizon) for f in faults), default=4.0 * result.horizon.step)


def _subdomain(subdomain: Subdomain, frame: Frame, step: float) -> dict[str, Any]:
    t = subdomain.termination
    where = [] if t.fault is None else [f"{t.fault}, {t.side}" if t.side else t.fault]
    if t.x is not None and t.y is not None and t.z is not None:
        where.append(frame.place((t.x, t.y, t.z), step))
    if t.short_by is not None:
        where.append(f"short by {frame.length(t.short_by)}")
    return {
        "id": subdomain.id,
        "faults": ", ".join(subdomain.faults) or "none",
        "unknowns": subdomain.unknowns,
        "iterations": subdomain.iterations,
        "type": int(t.type),
        "name": t.name,
        "advice": t.advice,
        "where": "; ".join(where),
        "displacement": rounded(subdomain.mean_displacement),
        "deviation": rounded(subdomain.mean_deviation),
        "remeshings": subdomain.remeshings,
    }


def _check(result: CheckResult, frame: Frame, step: float) -> dict[str, Any]:
    rows = [(f.status, _finding(f, frame, step)) for f in result.findings]
    open_ = (Status.FAIL, Status.WARN)
    word = "Passed" if result.passed else "Not passed"
    counts = ", ".join(f"{n} {status}" for status, n in result.counts().items() if n)
    return {
        "summary": f"{word} (profile {result.profile}): {counts or 'no finding'}.",
        "open": [row for status in open_ for s, row in rows if s is status],
        "rest": [row for s, row in rows if s not in open_],
    }


def _finding(finding: Finding, frame: Frame, step: float) -> dict[str, str]:
    w = finding.worst
    worst = "" if w is None else f"{rounded(w.value)} {w.unit} at {frame.place((w.x, w.y, w.z), step)}"
    return {
        "status": str(finding.status),
        "check": finding.check,
        "objects": ", ".join(finding.objects),
        "count": str(finding.count or ""),
        "message": finding.message,
        "remedy": finding.remedy,
        "worst": worst,
    }
