"""The JSON Schemas of model.toml and of what graben writes as JSON."""

from __future__ import annotations

from typing import Any

from graben.finding import Profile, Status
from graben.settings import ModelFile

_DRAFT = "https://json-schema.org/draft/2020-12/schema"
_TEXT = {"type": "string"}
_NUMBER = {"type": "number"}
_COUNT = {"type": "integer", "minimum": 0}
_FLAG = {"type": "boolean"}


def schemas() -> dict[str, dict[str, Any]]:
    """Return the JSON Schemas by what they describe: "model.toml", "report.json" and "check" (--json).

    >>> sorted(schemas())
    ['check', 'model.toml', 'report.json']
    """
    model = {"$schema": _DRAFT, **ModelFile.model_json_schema(), "title": "graben model.toml"}
    check = {"$schema": _DRAFT, "title": "graben check", **_check()}
    return {"model.toml": model, "report.json": _report(), "check": check}


def _object(required: dict[str, Any], optional: dict[str, Any] | None = None) -> dict[str, Any]:
    return {"type": "object", "required": list(required), "properties": {**required, **(optional or {})}}


def _list(items: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


def _names() -> dict[str, Any]:
    """Return the schema of texts by name: paths of files by what they are, reasons by what they concern."""
    return {"type": "object", "additionalProperties": _TEXT}


def _or_null(schema: dict[str, Any]) -> dict[str, Any]:
    return {"anyOf": [schema, {"type": "null"}]}


def _check() -> dict[str, Any]:
    """Return the schema of a verdict and its findings."""
    worst = _object({"value": _NUMBER, "unit": _TEXT, "x": _NUMBER, "y": _NUMBER, "z": _NUMBER})
    part = _object(
        {
            "kind": _TEXT,
            "count": _COUNT,
            "objects": _list(_TEXT),
            "value": _or_null(_NUMBER),
            "unit": _TEXT,
            **dict.fromkeys("xyz", _NUMBER),
        }
    )
    finding = _object(
        {
            "check": _TEXT,
            "status": {"enum": [str(s) for s in Status]},
            "objects": _list(_TEXT),
            "count": _COUNT,
            "worst": _or_null(worst),
            "message": _TEXT,
            "remedy": _TEXT,
            "repairable": _FLAG,
            "parts": _list(part),
        }
    )
    return _object(
        {
            "schema": {"const": 1},
            "profile": {"enum": [str(p) for p in Profile]},
            "passed": _FLAG,
            "findings": _list(finding),
        },
        {"model": _TEXT, "error": _TEXT},
    )


def _report() -> dict[str, Any]:
    """Return the schema of report.json; what only a run, or only a repair, knows is optional."""
    stages = ["read", "check", "repair", "triangulate", "solve", "move", "deform", "write", "per_iteration"]
    body = _object(
        {
            "schema": {"const": 1},
            "model": _TEXT,
            "before": {"$ref": "#/$defs/check"},
            "repairs": _list(_repair()),
            "after": {"$ref": "#/$defs/check"},
        },
        {
            "left": _list(_left()),
            "files": _names(),
            "not_written": _names(),
            "faults": _list(_fault()),
            "blocks": _blocks(),
            "horizons": _list(_horizon()),
            "timings": _object({"total": _NUMBER}, dict.fromkeys(stages, _NUMBER)),
            "peak_memory_mb": _NUMBER,
            "version": _TEXT,
        },
    )
    return {"$schema": _DRAFT, "title": "graben report.json", **body, "$defs": {"check": _check()}}


def _place() -> dict[str, Any]:
    return _or_null(_object(dict.fromkeys("xyz", _NUMBER)))


def _repair() -> dict[str, Any]:
    return _object(
        {
            "action": _TEXT,
            "check": _TEXT,
            "objects": _list(_TEXT),
            "count": _COUNT,
            "max_move": _or_null(_NUMBER),
            "place": _place(),
            "reason": _TEXT,
        },
        {
            "size": _or_null(_NUMBER),
            "unit": _TEXT,
            "before": _list(_measures()),
            "after": _list(_measures()),
        },
    )


def _left() -> dict[str, Any]:
    return _object(
        {
            "check": _TEXT,
            "objects": _list(_TEXT),
            "action": _TEXT,
            "place": _place(),
            "reason": _TEXT,
            "advice": _TEXT,
            "needed": _or_null(_NUMBER),
            "unit": _TEXT,
        }
    )


def _measures() -> dict[str, Any]:
    counts = dict.fromkeys(("vertices", "triangles", "components"), _COUNT)
    return _object({"name": _TEXT, **counts, **dict.fromkeys(("area", "rim", "dip"), _or_null(_NUMBER))})


def _fault() -> dict[str, Any]:
    lengths = ("largest_move", "mean_move", "extended_by", "cut_back_by")
    return _object(
        {
            "name": _TEXT,
            "from": _TEXT,
            "changed": _FLAG,
            "before": _measures(),
            "after": _or_null(_measures()),
            **dict.fromkeys(lengths, _NUMBER),
        }
    )


def _blocks() -> dict[str, Any]:
    """Return the schema of fault blocks: what was made, or the reason why nothing was."""
    names = dict.fromkeys(("faults", "neighbours"), _list(_TEXT))
    block = _object({"block": _TEXT, "file": _TEXT, "volume": _NUMBER, "share": _NUMBER, **names})
    numbers = dict.fromkeys(("top", "bottom", "prism_volume", "sum_error"), _NUMBER)
    made = _object({**numbers, "depths": {"enum": ["shared", "full"]}, "files": _list(block)})
    none = _object({"reason": _TEXT, "files": {"type": "array", "maxItems": 0}})
    return {"anyOf": [made, none]}


def _horizon() -> dict[str, Any]:
    termination = _object(
        {"type": {"enum": [0, 1, 2, 3]}, "name": _TEXT, "advice": _TEXT},
        {
            "fault": _or_null(_TEXT),
            "side": _or_null({"enum": ["hanging", "foot"]}),
            **{key: _or_null(_NUMBER) for key in ("short_by", "x", "y", "z")},
        },
    )
    subdomain = _object(
        {
            "id": _COUNT,
            "faults": _list(_TEXT),
            "unknowns": _COUNT,
            "iterations": _COUNT,
            "termination": termination,
            "mean_displacement": _NUMBER,
            "mean_deviation": _NUMBER,
            "history": _list(_NUMBER),
            "remeshings": _COUNT,
        }
    )
    error = _object({"value": _NUMBER, "percent": _NUMBER})
    return _object(
        {
            "name": _TEXT,
            "files": _names(),
            "nodes": _COUNT,
            "unknowns": _COUNT,
            "subdomains": _list(subdomain),
        },
        {"score": _or_null(_object(dict.fromkeys(("cutoff", "throw", "zone", "zone_input"), error)))},
    )
