"""Every file of `graben check` on models that pass, fail and have names made to break a format."""

from __future__ import annotations

import io
import json
import re
from collections import Counter
from dataclasses import replace
from xml.etree import ElementTree as ET

import jsonschema
import numpy as np
import pytest
import shapely
from junitparser import Failure, JUnitXml, Skipped
from rich.console import Console

from graben.finding import CheckResult, Finding, Part, Profile, Status, Worst
from graben.pipeline import Examination, examine
from graben.reports.check_files import REPORTS
from graben.reports.check_json import check_json, is_check_json
from graben.reports.check_table import check_table
from graben.reports.check_words import counted, seen, statuses, verdict
from graben.reports.junit import check_junit, is_check_junit
from graben.reports.places import MOST, check_places, is_check_places
from graben.reports.plain import LINE, PAGE
from graben.reports.sarif import check_sarif, is_check_sarif
from graben.schema import schemas
from graben.validators.registry import CHECKS, known_ids
from tests.reports.check_models import EVIL, MODELS, all_but_pass, evil_model, made
from tests.zoo.shapes import F60, NAN, faults


@pytest.fixture(scope="module", params=MODELS)
def examined(request: pytest.FixtureRequest) -> Examination:
    return examine(MODELS[request.param]())


@pytest.fixture(scope="module")
def evil() -> Examination:
    return examine(evil_model())


def test_the_models_are_what_they_are_called(evil: Examination) -> None:
    assert examine(MODELS["passing"]()).result.passed
    assert {name for f in evil.result.of("degenerate") for name in f.objects} == set(EVIL)


# JSON


def test_json_is_the_verdict_and_valid(examined: Examination) -> None:
    found = json.loads(check_json(examined))
    jsonschema.validate(found, schemas()["check"])
    assert found.pop("model") == examined.model.name
    assert found == examined.result.as_dict()
    assert list(dict.fromkeys(f["check"] for f in found["findings"])) == list(known_ids())


# JUnit

#: Elements with their attributes and children, each known to Jenkins, GitLab and the readers of GitHub.
JUNIT = {
    "testsuites": ({"name", "tests", "failures", "errors", "skipped", "time"}, {"testsuite"}),
    "testsuite": ({"name", "tests", "failures", "errors", "skipped", "time"}, {"testcase"}),
    "testcase": ({"name", "classname", "time"}, {"failure", "skipped", "system-out"}),
    "failure": ({"message", "type"}, set()),
    "skipped": ({"message"}, set()),
    "system-out": (set(), set()),
}


def test_junit_has_a_suite_for_each_check_and_a_case_for_each_finding(examined: Examination) -> None:
    text = check_junit(examined)
    root = ET.fromstring(text)
    for element in root.iter():
        attributes, children = JUNIT[element.tag]
        assert set(element.attrib) == attributes
        assert {child.tag for child in element} <= children
        assert all("\n" not in value for value in element.attrib.values())
    report = JUnitXml.fromstring(text.encode())
    findings = examined.result.findings
    assert [suite.name for suite in report] == list(known_ids())
    assert report.tests == len(findings)
    for suite in report:
        own = examined.result.of(suite.name)
        cases = list(suite)
        kinds = Counter(type(r) for case in cases for r in case.result)
        status = Counter(f.status for f in own)
        assert (suite.tests, suite.failures, suite.skipped) == (len(own), kinds[Failure], kinds[Skipped])
        assert (kinds[Failure], kinds[Skipped]) == (status[Status.FAIL], status[Status.SKIPPED])
        assert suite.errors == 0
        assert sum(case.is_passed for case in cases) == status[Status.PASS] + status[Status.WARN]
        for case, finding in zip(cases, own, strict=True):
            assert case.classname == f"graben.{suite.name}"
            assert (case.system_out is not None) is (finding.status is Status.WARN)
            said = (
                case.system_out
                if finding.status is Status.WARN
                else "".join(r.text or "" for r in case.result)
            )
            if finding.remedy:
                # names may hold characters that XML does not allow, which are written out
                start = " ".join(finding.remedy.split()[:5])
                told = "".join(c if c >= " " else c.encode("unicode_escape").decode() for c in start)
                assert told in " ".join((said or "").split())
    counts = examined.result.counts()
    assert (report.failures, report.skipped) == (counts[Status.FAIL], counts[Status.SKIPPED])
    assert float(report.time) == pytest.approx(examined.seconds, abs=1e-3)


def test_junit_writes_out_what_xml_does_not_allow(evil: Examination) -> None:
    names = {case.get("name") for case in ET.fromstring(check_junit(evil)).iter("testcase")}
    for name in EVIL:
        shown = name.replace("\x1b", "\\x1b").replace("\x07", "\\x07").replace("\n", " ").replace("\t", " ")
        assert shown in names


# GeoJSON


def test_geojson_has_every_place_in_the_models_convention(examined: Examination) -> None:
    found = json.loads(check_places(examined))
    model, factor = examined.model, examined.model.z_factor
    assert found["graben"]["z"] == model.z
    assert ("crs" in found) is (model.crs is not None)
    by_key: dict[tuple, list] = {}
    for feature in found["features"]:
        shape = shapely.from_geojson(json.dumps(feature["geometry"]))
        assert shape.is_valid
        assert shape.has_z
        known = feature["properties"]
        assert known["left_out" if "left_out" in known else "check"]
        by_key.setdefault((known["check"], known["status"], known["message"]), []).append((shape, known))
    for finding in all_but_pass(examined):
        own = by_key.get((finding.check, str(finding.status), finding.message), [])
        points = {shape.coords[0] for shape, _ in own if shape.geom_type == "Point"}
        places = [(x, y, factor * z) for x, y, z in finding.places.tolist()][: MOST // 2]
        assert set(places) <= points
        if finding.worst is not None:
            values = [k["value"] for shape, k in own if k["kind"] == "worst"]
            assert values == [finding.worst.value]
        assert sum(shape.geom_type == "LineString" for shape, _ in own) == len(finding.paths)


@pytest.mark.parametrize(
    ("crs", "name"), [("EPSG:23031", "urn:ogc:def:crs:EPSG::23031"), ("ED50 / UTM zone 31N",) * 2]
)
def test_geojson_names_the_coordinate_system(crs: str, name: str) -> None:
    found = json.loads(check_places(examine(replace(faults(F60), crs=crs))))
    assert found["crs"] == {"type": "name", "properties": {"name": name}}


def test_geojson_says_what_it_leaves_out_and_leaves_out_what_is_no_place() -> None:
    count = MOST + 7
    places = np.c_[np.arange(count), np.zeros((count, 2))]
    places[-1] = NAN
    line = np.array([[0.0, 0, 0], [1, 1, 1]])
    parts = (Part("gap", 2, (-1.0, 0.0, 5.0), 12.5, "m", ("F", "G")),)
    finding = Finding("near-miss", Status.WARN, ("F",), places=places, paths=(line, line[:1]), parts=parts)
    features = json.loads(check_places(made((finding,), replace(faults(F60), z="depth"))))["features"]
    points = [f for f in features if f["geometry"]["type"] == "Point"]
    assert len(points) == MOST
    # the part, and all places but the last, less what is written
    assert {f["properties"]["left_out"] for f in features} == {1 + count - 1 - MOST}
    assert points[0]["properties"]["kind"] == "gap"
    assert points[0]["properties"]["objects"] == ["F", "G"]
    assert points[0]["geometry"]["coordinates"] == [-1.0, 0.0, -5.0]
    (path,) = [f for f in features if f["geometry"]["type"] == "LineString"]
    assert path["geometry"]["coordinates"] == [[0.0, 0.0, 0.0], [1.0, 1.0, -1.0]]


# What graben knows as its own


def test_each_kind_knows_its_own_and_no_other(evil: Examination) -> None:
    kinds = {
        is_check_json: check_json(evil),
        is_check_junit: check_junit(evil),
        is_check_sarif: check_sarif(evil),
        is_check_places: check_places(evil),
    }
    for knows in kinds:
        for made_by, text in kinds.items():
            assert knows(text.encode()) is (knows is made_by)
    foreign = [
        b"",
        b"{}",
        b"[]",
        b"null",
        b"\xff\xfe",
        b"[" * 100_000,
        b'{"schema": 1, "model": "M", "before": {}, "after": {}}',
        b'{"type": "FeatureCollection", "features": []}',
        b'{"version": "2.1.0", "runs": [{"tool": {"driver": {"name": "other"}}}]}',
        b'{"version": "2.1.0", "runs": []}',
        b'<testsuites name="pytest tests"/>',
        b'<?xml version="1.0" encoding="nonsense"?><testsuites name="graben"/>',
        b"<html><head></head><body>graben</body></html>",
    ]
    for content in foreign:
        assert not any(report.ours(content) for report in REPORTS.values()), content


# The table


def test_the_table_tells_everything_in_lines_of_their_own(examined: Examination) -> None:
    text = check_table(examined, verbose=True)
    lines = text.splitlines()
    assert lines[0] == verdict(examined.result)
    assert lines[0].startswith("PASSED" if examined.result.passed else "NOT PASSED")
    mended = any(f.repairable for f in all_but_pass(examined))
    assert lines[-3 if mended else -2] == seen(counted(examined.result))
    assert lines[-2].startswith("graben repair may mend: ") is mended
    assert "\x1b" not in text
    assert all(line == line.rstrip() for line in lines)
    for finding in all_but_pass(examined):
        assert any(line.endswith(seen(finding.message)) for line in lines)
        assert f"  To do: {seen(finding.remedy)}" in lines
    failing = dict.fromkeys(f.check for f in examined.result.findings if f.status is Status.FAIL)
    assert list(failing) == re.findall(r"^fail +(\S+),", text, re.MULTILINE)


def test_without_v_the_table_fits_a_mail(examined: Examination) -> None:
    lines = check_table(examined).splitlines()
    assert all(len(line) <= LINE for line in lines)
    assert " ".join(" ".join(lines).split()).startswith(verdict(examined.result))
    for check in {f.check for f in examined.result.findings if f.status in (Status.FAIL, Status.WARN)}:
        assert any(re.match(rf"(fail|warn) +{check},", line) for line in lines)


def test_what_warns_is_cut_to_names_before_what_fails() -> None:
    words = "A long sentence about what is wrong there and why it matters to those who read it. " * 5
    warning = [
        Finding(c, Status.WARN, ("F",), 1, None, words, f"Mend {c}.") for c in ("trace", "min-dip")
    ] * 9
    failing = Finding("junction", Status.FAIL, ("F", "G"), 1, None, words, "Mend it.")
    lines = check_table(made((failing, *warning))).splitlines()
    assert len(lines) <= PAGE
    assert "warn    trace, 9 findings: F" in lines
    assert "fail    junction, 1 finding" in lines
    assert "To do: Mend min-dip." in " ".join(lines)


def test_names_stay_what_they_are(evil: Examination) -> None:
    text = check_table(evil, verbose=True)
    for name in EVIL:
        assert seen(name) in text
    assert "esc\\x1b[31m\\x07" in text
    assert "two\\nlines\\ttab" in text


@pytest.mark.parametrize("width", [40, 80, 200])
def test_on_a_terminal_nothing_is_cut(evil: Examination, width: int) -> None:
    console = Console(file=io.StringIO(), width=width, force_terminal=True, color_system="standard")
    shown = check_table(evil, verbose=True, console=console)
    assert "\x1b[1;31mNOT PASSED" in shown
    plain = re.sub(r"\x1b\[[0-9;]*m", "", shown)
    assert all(len(line) <= width for line in plain.splitlines() if line.isascii())
    # the longest name is folded
    assert sum(len(run) for run in re.findall("n{3,}", plain)) >= 290
    assert "…" not in plain


def test_places_are_in_the_models_convention() -> None:
    finding = Finding("trace", Status.FAIL, ("H", "F"), 1, Worst(12.34, "m", 1.0, 2.0, -1500.0), "Wrong.")
    up = made((finding,))
    assert "Worst: 12.3 m at x 1.00, y 2.00, elevation -1500.00" in check_table(up)
    down = replace(up, model=replace(up.model, z="depth"))
    assert "depth 1500.00" in check_table(down)


def test_many_findings_of_a_check_are_listed_when_asked() -> None:
    findings = tuple(Finding("min-dip", Status.WARN, (f"F{k}",), 1, None, f"Flat {k}.") for k in range(50))
    examination = made((*findings, Finding("finite", Status.PASS, message="All finite.")))
    short, long = check_table(examination), check_table(examination, verbose=True)
    assert 0 < short.count("Flat") <= PAGE
    assert f"and {50 - short.count('Flat')} more, of F{short.count('Flat')}, " in short
    assert long.count("Flat") == 50
    assert "All finite." in long
    assert "All finite." not in short
    assert "1.0 s" in long


def test_counts_are_of_checks_and_say_what_is_waited_for() -> None:
    findings = (
        Finding("finite", Status.PASS),
        Finding("functional", Status.WARN, ("F",)),
        Finding("functional", Status.FAIL, ("H",)),
        Finding("trace", Status.SKIPPED, message="Not looked at: H; waits for functional."),
        Finding("junction", Status.SKIPPED, message="Not looked at: H; waits for functional."),
    )
    result = CheckResult(Profile.PAPER, findings)
    assert statuses(result)["functional"] is Status.FAIL
    assert verdict(result) == "NOT PASSED: 1 check fails (functional)."
    assert counted(result) == (
        "4 checks: 1 passed, 0 warn, 1 fail, 2 skipped: "
        "trace, junction (Not looked at: H; waits for functional)."
    )
    assert (
        verdict(CheckResult(Profile.PAPER, findings[:2]))
        == "PASSED: no check fails, 1 check warns (functional)."
    )


def test_notebooks_show_the_worst_place_and_names_as_text() -> None:
    finding = Finding("trace", Status.FAIL, ("<b>x",), 3, Worst(12.5, "m", 1.0, 2.0, -1500.0), "<i>")
    shown = CheckResult(Profile.PAPER, (finding,), z_factor=-1.0)._repr_html_()
    assert "<td>3</td><td>12.5 m at 1.00, 2.00, 1500.00</td>" in shown
    assert "<b>x" not in shown
    assert "<i>" not in shown


# All of them


def test_the_same_model_gives_the_same_text() -> None:
    makers = (check_json, check_junit, check_sarif, check_places, check_table)
    first, second = ([make(examine(evil_model())) for make in makers] for _ in range(2))
    for texts in (first, second):
        texts[1] = re.sub(r'(<testsuites [^>]* time=)"[0-9.]+"', r"\1", texts[1])
    assert first == second


def test_every_check_can_be_named_in_every_output() -> None:
    findings = tuple(Finding(c.id, Status.FAIL, ("F",), 1, None, f"{c.id} is wrong.") for c in CHECKS)
    examination = made(findings)
    for make in (check_json, check_junit, check_sarif, check_table):
        text = make(examination)
        assert all(f"{c.id} is wrong." in text for c in CHECKS)
