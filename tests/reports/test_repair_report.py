"""The report of a repair: moves, additions and cuts told apart, every change and all that is left told."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import jsonschema
import numpy as np
import pytest

from graben.arrays import floats
from graben.finding import Finding, Status
from graben.model import Model
from graben.repairs import RepairResult
from graben.reports import repair_html as page_module
from graben.reports.check_words import Teller
from graben.reports.html import report_html
from graben.reports.json_report import as_text, run_report
from graben.reports.plain import LINE, PAGE
from graben.reports.repair_html import repair_html
from graben.reports.repair_json import repair_report
from graben.reports.repair_moves import compared, fault_changes
from graben.reports.repair_words import TABLE_4, action_words, repair_summary, repair_verdict
from graben.schema import schemas
from graben.validators.registry import known_ids
from tests.reports import sample
from tests.reports.repair_sample import (
    AWAY,
    CUT,
    EXTENSION,
    MOVE,
    findings,
    given,
    normal,
    repaired,
    untouched,
)
from tests.reports.test_html import Page

EVIL = (
    '<script>alert("F1")</script> & $x$', "a\"b'c/..\\d", "\U0001f469\u200d\U0001f52c", "n" * 300,
    "\u202eedoc\n\x1b[31m",
)  # fmt: skip


@pytest.fixture(scope="module")
def text() -> str:
    return repair_html(repaired(), files=True)


@pytest.fixture(scope="module")
def evil() -> str:
    result = repaired(EVIL)
    return repair_html(replace(result, input=replace(result.input, name=EVIL[0])), files=True)


def words(page: str) -> str:
    return re.sub(r"\s+", " ", "".join(Page(page).text))


def report(result: RepairResult) -> dict:
    return repair_report(result, fault_changes(result), {"repair": 1.5, "write": 0.5, "total": 2.0})


def test_moves_additions_and_cuts_are_told_apart():
    f1, f2, f3, f3b, f4, f5 = fault_changes(repaired())
    assert f1.largest_move == pytest.approx(MOVE, rel=1e-6)
    assert f1.extended == 0.0
    assert f1.cut_back == pytest.approx(CUT, abs=150.0)
    assert 0 < f1.mean_move < MOVE / 100
    assert (f2.largest_move, f2.cut_back) == (0.0, 0.0)
    assert f2.extended == pytest.approx(EXTENSION, rel=1e-6)
    assert [c.source for c in (f3, f3b)] == ["F3", "F3"]
    # what is now another fault was not cut off
    assert f3.cut_back == f3b.cut_back < 150.0
    assert not f4.changed
    assert (f4.largest_move, f4.mean_move) == (0.0, 0.0)
    assert (f5.name, f5.after, f5.made) == ("F5", None, None)


def test_a_hole_filled_without_a_new_vertex_counts_as_added():
    whole = given()
    surface = whole.faults[0].surface
    pair = np.isin(np.arange(len(surface.triangles)), [100, 370])  # the two triangles of a cell
    holed = replace(
        whole,
        faults=(replace(whole.faults[0], surface=replace(surface, triangles=surface.triangles[~pair])),),
    )
    (change,) = fault_changes(
        replace(untouched(), input=holed, model=replace(whole, faults=whole.faults[:1]), lineage={})
    )
    assert change.changed
    assert change.largest_move == 0.0
    assert change.added.tolist() == pair.tolist()
    assert 0 < change.extended < surface.median_edge


def test_a_move_is_the_distance_to_the_surface_not_to_the_vertex():
    surface = given().faults[0].surface
    along = surface.vertices[100] - surface.vertices[90]
    slid = surface.vertices[150] + 0.3 * along  # within its own plane
    points = floats([slid, slid + 0.001 * normal(surface), slid + 5.0 * normal(surface)])
    away, beyond = compared(points, surface)
    assert away == pytest.approx([0.0, 0.001, 5.0], abs=1e-7)
    assert not beyond.any()
    rim = surface.vertices[0]  # its lower western corner
    for way, is_beyond in (([-50.0, 0.0, 0.0], True), (20.0 * normal(surface), False)):
        away, beyond = compared(floats([rim + np.array(way)]), surface)
        assert away == pytest.approx([np.linalg.norm(way)], rel=1e-6)
        assert beyond.tolist() == [is_beyond]


@pytest.mark.parametrize("angle", [0.0, 1.0, 2.5])
def test_moves_do_not_depend_on_north(angle):
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    result = repaired()

    def turned(model: Model) -> Model:
        faults = [
            replace(f, surface=f.surface.with_vertices((f.surface.vertices - AWAY) @ turn.T))
            for f in model.faults
        ]
        return replace(model, horizons=(), faults=tuple(faults))

    moved = replace(result, input=turned(result.input), model=turned(result.model))
    for one, other in zip(fault_changes(result), fault_changes(moved), strict=True):
        if one.changed:
            assert other.largest_move == pytest.approx(one.largest_move, abs=1e-6)
            assert other.extended == pytest.approx(one.extended, abs=1e-6)
            assert other.cut_back == pytest.approx(one.cut_back, abs=1e-6)


def test_json_is_what_the_schema_says():
    made = report(repaired(EVIL))
    again = json.loads(as_text(made))
    jsonschema.validate(again, schemas()["report.json"])
    assert [f["name"] for f in again["faults"]][:3] == [*EVIL[:3]]
    assert [r["action"] for r in again["repairs"]] == ["unfold", "contacts", "parts", "specks"]
    assert again["repairs"][1]["size"] == EXTENSION
    assert [m["name"] for m in again["repairs"][2]["after"]] == [EVIL[2], f"{EVIL[2]} (2)"]
    assert again["left"][1]["needed"] == 73.2
    assert again["faults"][-1]["after"] is None
    assert not again["after"]["passed"]


def test_places_of_a_depth_model_are_depths():
    result = repaired()
    deep = replace(result, input=replace(result.input, z="depth"))
    for up, down in zip(report(result)["repairs"], report(deep)["repairs"], strict=True):
        if up["place"] is not None:
            assert up["place"]["z"] == -down["place"]["z"] < 0
    assert report(result)["left"][1]["place"]["z"] == -report(deep)["left"][1]["place"]["z"]
    assert "depth 2010" in words(repair_html(deep))
    assert "depth 2010" in " ".join(repair_summary(deep).split())


def test_a_run_lists_the_same_ledger():
    result, run = repaired(), sample.run_result()
    run = replace(run, repairs=result.actions, left=result.left)
    made = run_report(run, {})
    assert made["repairs"] == report(result)["repairs"]
    assert made["left"] == report(result)["left"]
    jsonschema.validate(json.loads(as_text(made)), schemas()["report.json"])
    shown = words(report_html(run, {}))
    for said in ("It was extended along its own trend.", "260 m", "It needs <more>.", "Raise max_move."):
        assert said in shown


def test_tags_are_closed_and_every_link_arrives(text, evil):
    for page in (text, evil, repair_html(untouched())):
        parsed = Page(page)
        assert parsed.open == []
        ids = [attrs["id"] for _, attrs in parsed.tags if "id" in attrs]
        assert len(ids) == len(set(ids))
        targets = [a["href"][1:] for a in parsed["a"] if a["href"].startswith("#")]
        targets += [b["data-finding"] for b in parsed["button"] if "data-finding" in b]
        assert set(targets) <= set(ids)


def test_verdict_is_the_first_line(text):
    body = words(text).split("Skip to the results")[1].strip()
    assert body.startswith(
        "NOT PASSED: 1 finding still fails (z-monotone), 2 before; 4 changes on 4 of 5 faults."
    )


def test_every_change_and_what_is_left_is_told(text):
    shown = words(text)
    for said in (
        "F1 was unfolded.", "It was extended along its own trend.", "one of 2 parts of F3", "It was a speck.",
        "0.45 km²", "It needs <more>. It would take 73.2 m more.", "Raise max_move.", "A <summit>.",
        "left out",         TABLE_4["z-monotone"], "1 fault is as given, to the bit: F4.", "25 m", "260 m",
    ):  # fmt: skip
        assert said in shown, said
    pictures = Page(text)["img"]
    assert len(pictures) == 5
    assert all(len(p["alt"]) > 20 and p["src"].startswith("data:image/") for p in pictures)


def test_checks_stand_side_by_side(text):
    rows = re.findall(r'<tr><th scope="row" class="id">([\w-]+)</th>(.*?)</tr>', text, re.S)
    assert [check for check, _ in rows] == list(known_ids())
    badges = {check: re.findall(r'badge (\w+)"', row) for check, row in rows}
    assert badges["trace"] == ["fail", "pass"]
    assert badges["near-miss"] == ["pass", "warn"]
    assert badges["z-monotone"] == ["fail", "fail"]


def test_page_asks_nothing_of_the_network(text):
    page = Page(text)
    addresses = [a[key] for _, a in page.tags for key in ("src", "href", "data", "action") if a.get(key)]
    assert all(re.match(r"#|data:|model\.toml$|report\.json$", address) for address in addresses)


def test_names_are_text_everywhere(evil):
    assert evil.count('alert("F1")') == 0
    assert "<script>alert" not in evil
    assert "\u202e" not in evil
    assert "\x1b" not in evil
    assert len([t for t, _ in Page(evil).tags if t == "script"]) == 4
    assert EVIL[0] in "".join(Page(evil).text)
    assert any(EVIL[0] in p["alt"] for p in Page(evil)["img"])


def test_two_reports_are_the_same_bytes_and_small(text):
    assert repair_html(repaired(), files=True) == text
    assert len(text.encode()) < 10_000_000


def test_nothing_changed_is_said_so():
    result = untouched()
    shown = words(repair_html(result))
    assert "PASSED: nothing was changed." in shown
    assert "Every fault is as given, to the bit" in shown
    assert "What is left" not in shown
    assert not Page(repair_html(result))["img"]
    assert repair_summary(result).startswith("PASSED: nothing was changed.")


def test_model_without_anything_to_draw_has_a_report():
    empty = Model("nothing")
    result = replace(untouched(), input=empty, model=empty, lineage={})
    assert "PASSED" in words(repair_html(result))


def test_many_faults_keep_the_page_small(monkeypatch):
    monkeypatch.setattr(page_module, "_MOST_PARTS", 2)
    monkeypatch.setattr(page_module, "MOST_ROWS", 3)
    page = repair_html(repaired())
    assert len(Page(page)["img"]) == 2
    assert "2 of 5 changed faults are shown here; all are in report.json." in words(page)
    assert "3 of 5 changed faults are shown here; all are in report.json." in words(page)


def test_verdicts_in_words():
    assert repair_verdict(repaired(passed=True)) == (
        "PASSED after repair: 4 changes on 4 of 5 faults. "
        "1 warning remains (near-miss), which repair looked at and left."
    )
    vain = repaired()
    vain = replace(vain, model=vain.input, actions=(), after=vain.before)
    assert repair_verdict(vain) == (
        "NOT PASSED: 2 findings still fail (z-monotone, trace), 2 before; nothing was changed."
    )


def test_warnings_are_counted_as_the_report_lists_them():
    """35 findings warn, of which repair looked at one: neither count stands for the other."""
    one = repaired(passed=True)
    others = [Finding("min-dip", Status.WARN, (f"F{k}",)) for k in range(34)]
    many = replace(one, after=findings(*others, *one.after.of("near-miss")))
    said = "35 warnings remain (min-dip 34, near-miss 1), 1 of which repair looked at and left"
    assert repair_verdict(many).endswith(f". {said}.")
    shown = words(repair_html(many))
    assert f"The model passes. {said}." in shown
    assert shown.count("It only warns, and no repair looked at it.") == 34
    assert "34 warnings" in shown and "1 warning" in shown  # check by check
    unseen = replace(many, left=())
    assert repair_verdict(unseen).endswith(". 35 warnings remain (min-dip 34, near-miss 1).")
    # two entries about one finding are one finding
    twice = replace(many, left=one.left * 2)
    assert repair_verdict(twice) == repair_verdict(many)
    assert repair_verdict(repaired()).endswith(
        " 1 warning remains (near-miss), which repair looked at and left."
    )


def test_what_is_left_names_a_fault_once():
    result = repaired()
    near, far = (replace(result.left[0], reason=f"{name} ends short of F1.") for name in ("F2", "F22"))
    lines = repair_summary(replace(result, left=(near, far)), verbose=True).splitlines()
    assert "  near-miss: F2 ends short of F1. It would take 12.5 m more." in lines
    assert "  near-miss, F2: F22 ends short of F1. It would take 12.5 m more." in lines


def test_summary_counts_by_fault_and_fits_a_mail():
    result = repaired()
    lines = repair_summary(result).splitlines()
    assert any("To do: Raise max_move." in line for line in lines)
    # where there is room, each change is told
    few = repair_summary(replace(result, actions=result.actions[:1])).splitlines()
    assert any(line.startswith("    unfold (functional): F1 was unfolded.") for line in few)
    assert "Left (see report): near-miss 1, z-monotone 1" in lines
    named = [replace(a, objects=(f"{a.objects[0]} {k}",)) for k in range(20) for a in result.actions]
    many = replace(result, actions=tuple(named), left=result.left * 20)
    lines = repair_summary(many).splitlines()
    assert len(lines) <= PAGE and all(len(line) <= LINE for line in lines)
    assert any(line.endswith("more: -v lists them.") for line in lines)
    assert "  F1 0: unfold 1; moves up to 25 m" in lines
    assert "\n".join(lines).count("To do: Raise max_move.") == 1
    assert "nothing was written" in repair_summary(result, plan=True)
    assert all(
        line.isprintable() for line in repair_summary(repaired(EVIL)).splitlines() if "\u200d" not in line
    )


def test_verbose_summary_lists_each_change_under_its_fault():
    result = repaired()
    lines = repair_summary(result, verbose=True).splitlines()
    assert "  F1" in lines
    assert "  F2, F1" in lines
    assert any(
        line.startswith("    unfold (functional): F1 was unfolded. (1 element, moves up to 25 m")
        for line in lines
    )
    many = repair_summary(replace(result, actions=result.actions * 20), verbose=True)
    assert many.count("F1 was unfolded.") == 20
    assert "more: -v" not in many


def test_rounding_is_no_move():
    result = repaired()
    still = replace(result.actions[0], max_move=1.4e-9)
    assert "no vertex moved" in action_words(still, Teller.of(result.input))


def test_what_table_4_says_is_said_of_known_checks():
    assert set(TABLE_4) <= set(known_ids())
    assert all(f"type {k}" in " ".join(TABLE_4.values()) for k in (1, 2, 3))
    assert Status.FAIL in {f.status for f in repaired().before.findings}
