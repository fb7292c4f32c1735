"""The findings of `graben check` as SARIF 2.1.0, which code hosts and editors show beside lines."""

from __future__ import annotations

import hashlib
import json
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from graben.finding import Finding, Profile, Status
from graben.reports.check_json import parsed
from graben.reports.check_words import Teller
from graben.reports.json_report import as_text
from graben.reports.sarif_places import BASE, Root, locations
from graben.validators.context import Check, Severity
from graben.validators.registry import CHECKS

if TYPE_CHECKING:
    from graben.model import Model
    from graben.pipeline import Examination

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
#: GitHub refuses a file with more results.
MOST_RESULTS = 25_000
_LEVELS = {Status.FAIL: "error", Status.WARN: "warning"}


def check_sarif(examination: Examination) -> str:
    """Return the findings that fail or warn as a SARIF log with one run.

    Each check is a rule. What passes is no result, since readers show every result as an alert; a check that
    was skipped is a notification of the run, with the reason. A result lies in the file of a surface, at the
    line of the triangle that is worst or nearest to the worst place where that line is known, else in line 1;
    without any file in model.toml.

    Parameters
    ----------
    examination : Examination
        Of :func:`graben.pipeline.examine`.

    Returns
    -------
    str
        The text of the file. Paths are relative to the root of the repository around model.toml, see
        :class:`graben.reports.sarif_places.Root`; z counts as in the model file.
    """
    model, result = examination.model, examination.result
    teller, root = Teller.of(model), Root.of(model)
    said = sorted(
        (f for f in result.findings if f.status in _LEVELS), key=lambda f: f.status is not Status.FAIL
    )
    skipped = [_notification(f) for f in result.findings if f.status is Status.SKIPPED]
    results = [_result(f, k, model, teller, root) for f, k in _numbered(said[:MOST_RESULTS])]
    name = f"graben/{result.profile}/{model.name}/"
    return _log(name, result.profile, True, skipped, results, root.words)


def error_sarif(sentence: str, profile: str) -> str:
    """Return the log of a check that could not be made: no results, an execution that failed, and why."""
    told = {"level": "error", "message": {"text": _plain(sentence)}}
    return _log(f"graben/{profile}/", Profile(profile), False, [told], [])


def _log(
    name: str,
    profile: Profile,
    successful: bool,
    notifications: list[dict[str, Any]],
    results: list[dict[str, Any]],
    base: str = "",
) -> str:
    number = version("graben")
    run = {
        "tool": {
            "driver": {
                "name": "graben",
                "version": number,
                "semanticVersion": number,
                "rules": [_rule(check, profile) for check in CHECKS],
            }
        },
        "automationDetails": {"id": name},
        # without its place: the same log wherever the repository lies
        **({"originalUriBaseIds": {BASE: {"description": {"text": base}}}} if base else {}),
        "invocations": [{"executionSuccessful": successful, "toolExecutionNotifications": notifications}],
        "results": results,
        "columnKind": "unicodeCodePoints",
    }
    return as_text({"$schema": SCHEMA, "version": "2.1.0", "runs": [run]})


def is_check_sarif(content: bytes) -> bool:
    """Return whether a file's content is a log that :func:`check_sarif` wrote."""
    found = parsed(content)
    try:
        return bool(found["version"] == "2.1.0" and found["runs"][0]["tool"]["driver"]["name"] == "graben")
    except (LookupError, TypeError):
        return False


def _rule(check: Check, profile: Profile) -> dict[str, Any]:
    warns = check.severity is Severity.WARN or (
        check.severity is Severity.RELAXED and profile is Profile.EXTENDED
    )
    note = f" {check.leniency[:1].upper()}{check.leniency[1:]}." if check.leniency else ""
    return {
        "id": check.id,
        "shortDescription": {"text": check.sentence},
        "fullDescription": {"text": f"{check.sentence} {check.why}"},
        "help": {"text": f"{check.why}{note} Paper: section {check.section}."},
        "defaultConfiguration": {"level": "warning" if warns else "error"},
        "properties": {"tags": ["structural geology"], "section": check.section},
    }


def _numbered(findings: list[Finding]) -> list[tuple[Finding, int]]:
    """Return each finding with its number among those of the same check and objects, from 1."""
    count: dict[tuple[str, ...], int] = {}
    numbered = []
    for finding in findings:
        key = (finding.check, *finding.objects)
        count[key] = count.get(key, 0) + 1
        numbered.append((finding, count[key]))
    return numbered


def _result(finding: Finding, number: int, model: Model, teller: Teller, root: Root) -> dict[str, Any]:
    where = teller.worst(finding)
    sentences = (finding.message, f"Worst: {where}." if where else "", f"To do: {finding.remedy}")
    first, others = locations(finding, model, teller, root)
    known = finding.as_dict(model.z_factor)
    return {
        "ruleId": finding.check,
        "ruleIndex": [check.id for check in CHECKS].index(finding.check),
        "kind": "fail",
        "level": _LEVELS[finding.status],
        "message": {"text": _plain(" ".join(s for s in sentences if s))},
        "locations": [first],
        **({"relatedLocations": others} if others else {}),
        "partialFingerprints": _fingerprints(finding, number),
        "properties": {key: known[key] for key in ("objects", "count", "worst", "repairable", "parts")},
    }


def _fingerprints(finding: Finding, number: int) -> dict[str, str]:
    """Return what names the finding in every run: its check and objects, not its place or line."""
    words = json.dumps([finding.check, *finding.objects])
    digest = f"{hashlib.sha256(words.encode()).hexdigest()[:32]}:{number}"
    # GitHub looks at the second alone.
    return {"grabenFinding/v1": digest, "primaryLocationLineHash": digest}


def _notification(finding: Finding) -> dict[str, Any]:
    index = [check.id for check in CHECKS].index(finding.check)
    return {
        "level": "note",
        "message": {"text": _plain(f"{finding.check} was skipped. {finding.message}")},
        "associatedRule": {"id": finding.check, "index": index},
    }


def _plain(text: str) -> str:
    """Return text in which no name reads as one of SARIF's embedded links, ``[text](target)``."""
    return text.replace("](", "] (")
