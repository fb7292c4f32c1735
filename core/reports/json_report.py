"""report.json of a run, strictly valid JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graben.cleaning.ledger import Left, RepairAction
    from graben.model import Model
    from graben.modeling.results import HorizonResult, Subdomain, Termination
    from graben.pipeline import RunResult
    from graben.reports.model_files import ModelFiles

Files = Mapping[str, Mapping[str, str]]


def run_report(result: RunResult, files: Files, whole: ModelFiles | None = None) -> dict[str, Any]:
    """Return report.json of a run as plain dictionaries, lists, numbers and strings.

    Parameters
    ----------
    result : RunResult
        A finished run.
    files : mapping of str to mapping of str to str
        For each horizon the files written for it: what the file is -> path relative to the folder.
    whole : ModelFiles, optional
        The files written for the whole model, and why others were not.

    Returns
    -------
    dict
        As the schema of report.json says; z counts as in the model file. Numbers that are not finite
        are None. Only ``timings`` and ``peak_memory_mb`` differ between two runs on the same input.
    """
    factor = result.model.z_factor
    report = {
        "schema": 1,
        "version": version("graben"),
        "model": result.model.name,
        "before": result.before.as_dict(),
        "repairs": [repair_entry(action, factor) for action in result.repairs],
        "after": result.after.as_dict(),
        "left": [left_entry(left, factor) for left in result.left],
        "horizons": [_horizon(result.model, h, files.get(h.name, {})) for h in result.horizons],
        "not_modeled": dict(result.not_modeled),
        "files": dict(whole.files) if whole else {},
        "not_written": dict(whole.not_written) if whole else {},
        "parameters": {
            **result.model.parameters.model_dump(mode="json"),
            "tolerance": result.model.tolerance,
            "z": result.model.z,
            "unit": result.model.unit,
            "crs": result.model.crs,
        },
        "timings": dict(result.timings),
        "peak_memory_mb": result.peak_memory_mb,
    }
    plain: dict[str, Any] = strict(report)
    return plain


def as_text(report: Mapping[str, Any]) -> str:
    """Return a report as the text of a JSON file."""
    return json.dumps(strict(report), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def strict(value: Any) -> Any:
    """Return a value with numpy numbers turned into Python's and those that are not finite into None.

    >>> strict({"a": [1, float("nan")]})
    {'a': [1, None]}
    """
    if isinstance(value, Mapping):
        return {str(key): strict(item) for key, item in value.items()}
    if hasattr(value, "tolist"):  # numpy's arrays and numbers
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [strict(item) for item in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value


def repair_entry(action: RepairAction, factor: float) -> dict[str, Any]:
    """Return one change of the ledger for JSON; ``factor`` -1 turns elevations into depths."""
    return {
        "action": str(action.action),
        "check": str(action.check),
        "objects": list(action.objects),
        "count": action.count,
        "max_move": action.max_move,
        "place": _place(action.place, factor),
        "reason": action.reason,
        "size": action.size,
        "unit": action.unit,
        "before": [asdict(m) for m in action.before],
        "after": [asdict(m) for m in action.after],
    }


def left_entry(left: Left, factor: float) -> dict[str, Any]:
    """Return what repair left for JSON; ``factor`` -1 turns elevations into depths."""
    return {
        "check": left.check,
        "objects": list(left.objects),
        "action": left.action,
        "place": _place(left.place, factor),
        "reason": left.reason,
        "advice": left.advice,
        "needed": left.needed,
        "unit": left.unit,
    }


def _place(place: tuple[float, float, float] | None, factor: float) -> dict[str, float] | None:
    return None if place is None else {"x": place[0], "y": place[1], "z": factor * place[2]}


def _horizon(model: Model, result: HorizonResult, files: Mapping[str, str]) -> dict[str, Any]:
    factor = model.z_factor
    gammas = {f.name: model.gamma(f, result.horizon) for f in model.faults if f.name in result.graph_faults}
    score = {} if result.score is None else {"score": result.score.as_dict()}
    return {
        "name": result.name,
        "files": dict(files),
        "step": result.horizon.step,
        "gamma": gammas,
        "nodes": len(result.surface.vertices),
        "unknowns": sum(s.unknowns for s in result.subdomains),
        **score,
        "subdomains": [_subdomain(s, factor) for s in result.subdomains],
        "warnings": list(result.warnings),
    }


def _subdomain(subdomain: Subdomain, factor: float) -> dict[str, Any]:
    return {
        "id": subdomain.id,
        "faults": list(subdomain.faults),
        "nodes": subdomain.nodes,
        "unknowns": subdomain.unknowns,
        "iterations": subdomain.iterations,
        "termination": _termination(subdomain.termination, factor),
        "mean_displacement": subdomain.mean_displacement,
        "mean_deviation": subdomain.mean_deviation,
        "history": list(subdomain.history),
        "remeshings": subdomain.remeshings,
    }


def _termination(termination: Termination, factor: float) -> dict[str, Any]:
    t = termination
    return {
        "type": int(t.type),
        "name": t.name,
        "advice": t.advice,
        "fault": t.fault,
        "side": None if t.side is None else str(t.side),
        "short_by": t.short_by,
        "x": t.x,
        "y": t.y,
        "z": None if t.z is None else factor * t.z,
    }
