"""The findings of `graben check` as JUnit XML, which CI systems show as tests."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from graben.finding import Finding, Status
from graben.reports.check_words import Teller
from graben.validators.registry import CHECKS

if TYPE_CHECKING:
    from graben.pipeline import Examination
    from graben.validators.context import Check

#: What XML 1.0 does not allow in a text.
_UNFIT = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def check_junit(examination: Examination) -> str:
    """Return the findings as JUnit XML: a testsuite for each check, a testcase for each finding.

    A finding that fails is a failure, one that warns passes with its text in system-out, a skipped one says
    what it waits for. The checks share their work, so that only the whole has a time: it stands at the root.

    Parameters
    ----------
    examination : Examination
        Of :func:`graben.pipeline.examine`.

    Notes
    -----
    JUnit XML has no standard. Only elements and attributes are used that Jenkins, GitLab and the readers of
    GitHub Actions share; ``file`` and ``line`` are not among them and stand in the texts.
    """
    result = examination.result
    everything = result.counts()
    teller = Teller.of(examination.model)
    files = {s.name: str(s.file) for s in examination.model.surfaces if s.file is not None}
    counts = everything[Status.FAIL], 0, everything[Status.SKIPPED]
    root = ET.Element("testsuites", {"name": "graben", **_numbers(len(result.findings), *counts)})
    root.set("time", _seconds(examination.seconds))
    for check in CHECKS:
        findings = result.of(check.id)
        if findings:
            _add_suite(root, check, findings, teller, files)
    return _whole(root)


def error_junit(sentence: str, model: str) -> str:
    """Return the JUnit XML of a check that could not be made: one testcase with an error.

    Parameters
    ----------
    sentence : str
        Why.
    model : str
        What was to be checked.
    """
    numbers = _numbers(1, failures=0, errors=1, skipped=0)
    root = ET.Element("testsuites", {"name": "graben", **numbers})
    suite = ET.SubElement(root, "testsuite", {"name": "read", **numbers})
    name = _line(model)
    case = ET.SubElement(suite, "testcase", classname="graben.read", name=name, time=_seconds(0.0))
    ET.SubElement(case, "error", message=_line(sentence), type="read").text = _fit(sentence)
    return _whole(root)


def _whole(root: ET.Element) -> str:
    ET.indent(root)
    body = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{body}\n'


def _numbers(tests: int, failures: int, errors: int, skipped: int) -> dict[str, str]:
    """Return the attributes that a suite and all suites have alike."""
    counts = {"tests": tests, "failures": failures, "errors": errors, "skipped": skipped}
    return {**{name: str(count) for name, count in counts.items()}, "time": _seconds(0.0)}


def _seconds(value: float) -> str:
    return f"{value:.3f}"


def is_check_junit(content: bytes) -> bool:
    """Return whether a file's content is a report that :func:`check_junit` wrote."""
    try:
        root = ET.fromstring(content)
    except (ET.ParseError, ValueError, LookupError):
        return False
    return root.tag == "testsuites" and root.get("name") == "graben"


def _add_suite(
    root: ET.Element, check: Check, findings: tuple[Finding, ...], teller: Teller, files: Mapping[str, str]
) -> None:
    status = [f.status for f in findings]
    counts = status.count(Status.FAIL), 0, status.count(Status.SKIPPED)
    suite = ET.SubElement(root, "testsuite", {"name": check.id, **_numbers(len(findings), *counts)})
    for finding in findings:
        name = _line(", ".join(finding.objects) or check.id)
        case = ET.SubElement(suite, "testcase", classname=f"graben.{check.id}", name=name)
        case.set("time", _seconds(0.0))
        if finding.status is Status.FAIL:
            failure = ET.SubElement(case, "failure", message=_line(finding.message), type=check.id)
            failure.text = _text(finding, check, teller, files)
        elif finding.status is Status.WARN:
            ET.SubElement(case, "system-out").text = _text(finding, check, teller, files)
        elif finding.status is Status.SKIPPED:
            ET.SubElement(case, "skipped", message=_line(finding.message))


def _text(finding: Finding, check: Check, teller: Teller, files: Mapping[str, str]) -> str:
    """Return a finding in lines: what, where, why it matters, what to do, in which files, its parts."""
    where = teller.worst(finding)
    own = dict.fromkeys(files[name] for name in finding.objects if name in files)
    lines = [
        f"{finding.status}: {finding.message}",
        f"Worst: {where}" if where else "",
        f"Why it matters: {check.why}",
        f"To do: {finding.remedy}" if finding.remedy else "",
        f"Files: {', '.join(own)}" if own else "",
        *(f"- {teller.part(part)}" for part in finding.parts),
    ]
    return _fit("\n".join(line for line in lines if line))


def _line(text: str) -> str:
    """Return text fit for an attribute, in one line."""
    return " ".join(_fit(text).split())


def _fit(text: str) -> str:
    r"""Return text with the characters that XML does not allow written out, such as ``\x1b``."""
    return _UNFIT.sub(lambda found: found.group().encode("unicode_escape").decode(), text)
