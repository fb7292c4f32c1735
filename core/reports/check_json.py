"""The verdict of `graben check` as JSON."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from graben.reports.json_report import as_text

if TYPE_CHECKING:
    from graben.pipeline import Examination


def check_json(examination: Examination) -> str:
    """Return the findings as JSON, as the schema "check" of ``graben schema`` says.

    Parameters
    ----------
    examination : Examination
        Of :func:`graben.pipeline.examine`.

    Returns
    -------
    str
        The text of the file; the same model gives the same text. z counts as in the model file.
    """
    verdict = examination.result.as_dict()
    return as_text({"schema": verdict["schema"], "model": examination.model.name, **verdict})


def error_json(sentence: str, profile: str) -> str:
    """Return the JSON of a check that could not be made: not passed, no findings, and ``error`` says why."""
    return as_text({"schema": 1, "profile": profile, "passed": False, "findings": [], "error": sentence})


def is_check_json(content: bytes) -> bool:
    """Return whether a file's content is a verdict that :func:`check_json` wrote."""
    found = parsed(content)
    keys = ("schema", "profile", "passed", "findings")
    return isinstance(found, dict) and found.get("schema") == 1 and all(key in found for key in keys)


def parsed(content: bytes) -> Any:
    """Return the value that JSON text stands for; None where it is no JSON."""
    try:
        return json.loads(content)
    except (ValueError, RecursionError):
        return None
