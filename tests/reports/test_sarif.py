"""SARIF of a check: valid, and with the file and line of each finding."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sarif_kit.validate import validation_errors

from graben.finding import Element, Finding, Status, Worst
from graben.formats.writing import write_model
from graben.pipeline import Examination, examine
from graben.reading import read_model
from graben.reports.sarif import check_sarif
from graben.reports.sarif_places import MOST_RELATED, Root
from graben.validators.registry import known_ids
from tests.reports.check_models import MODELS, all_but_pass, made, with_sliver
from tests.zoo.shapes import AT_MIDDLE, F60, MIDDLE, NAN, faults, moved_vertex


@pytest.fixture(scope="module", params=MODELS)
def examined(request: pytest.FixtureRequest) -> Examination:
    return examine(MODELS[request.param]())


def sarif(examination: Examination) -> dict:
    log = json.loads(check_sarif(examination))
    assert validation_errors(log) == []
    (run,) = log["runs"]
    return run


def test_sarif_is_valid_and_holds_what_fails_and_warns(examined: Examination) -> None:
    run = sarif(examined)
    rules = run["tool"]["driver"]["rules"]
    assert [rule["id"] for rule in rules] == list(known_ids())
    assert all(
        len(rule[key]["text"]) < 1024 for rule in rules for key in ("shortDescription", "fullDescription")
    )
    told = {(r["ruleId"], tuple(r["properties"]["objects"]), r["level"]) for r in run["results"]}
    levels = {Status.FAIL: "error", Status.WARN: "warning"}
    assert told == {(f.check, f.objects, levels[f.status]) for f in all_but_pass(examined)}
    assert len(run["results"]) == len(all_but_pass(examined))
    prints = [r["partialFingerprints"]["primaryLocationLineHash"] for r in run["results"]]
    assert len(set(prints)) == len(prints)
    for result in run["results"]:
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"]
        assert "](" not in result["message"]["text"]
        assert len(result.get("relatedLocations", [])) <= MOST_RELATED
        names = [place["name"] for place in result["locations"][0]["logicalLocations"]]
        assert names == result["properties"]["objects"]
    (invocation,) = run["invocations"]
    skipped = [n["associatedRule"]["id"] for n in invocation["toolExecutionNotifications"]]
    assert skipped == [f.check for f in examined.result.findings if f.status is Status.SKIPPED]


def test_sarif_rules_follow_the_profile() -> None:
    def levels(profile: str) -> dict[str, str]:
        rules = sarif(examine(faults(F60), profile))["tool"]["driver"]["rules"]
        return {rule["id"]: rule["defaultConfiguration"]["level"] for rule in rules}

    assert levels("paper")["z-monotone"] == "error"
    assert levels("extended")["z-monotone"] == "warning"
    assert levels("paper")["min-dip"] == "warning"


def line_of(place: dict, folder: Path) -> str:
    """The line that a location names, from the file that it names."""
    physical = place["physicalLocation"]
    assert physical["artifactLocation"]["uriBaseId"] == "%SRCROOT%"
    uri = physical["artifactLocation"]["uri"]
    assert re.fullmatch(r"[A-Za-z0-9._~%/-]+", uri)
    return (folder / uri).read_text().splitlines()[physical["region"]["startLine"] - 1]


def test_sarif_names_the_line_of_the_worst_triangle(tmp_path: Path) -> None:
    fault = with_sliver(F60, "F")
    write_model(faults(fault, replace(F60, name="G").moved(np.array([0.0, 900.0, 0.0]))), tmp_path)
    examination = examine(read_model(tmp_path / "model.toml"))
    (finding,) = examination.result.of("degenerate")
    (result,) = [r for r in sarif(examination)["results"] if r["ruleId"] == "degenerate"]
    lines = [line_of(place, tmp_path) for place in (*result["locations"], *result["relatedLocations"])]
    triangles = [[int(word) - 1 for word in line.split()[1:]] for line in lines]
    assert sorted(map(sorted, triangles)) == sorted(
        sorted(t) for t in fault.triangles[finding.elements].tolist()
    )
    middle = fault.vertices[triangles[0]].mean(axis=0)
    assert finding.worst is not None
    assert np.allclose(middle, [finding.worst.x, finding.worst.y, finding.worst.z], atol=1e-6)
    assert [place["id"] for place in result["relatedLocations"]] == list(range(1, len(lines)))


def test_sarif_names_a_triangle_that_uses_the_vertex(tmp_path: Path) -> None:
    write_model(faults(moved_vertex(F60, MIDDLE, [NAN, 0.0, 0.0])), tmp_path)
    run = sarif(examine(read_model(tmp_path / "model.toml")))
    (result,) = [r for r in run["results"] if r["ruleId"] == "finite"]
    assert str(MIDDLE + 1) in line_of(result["locations"][0], tmp_path).split()[1:]


def test_sarif_names_the_triangle_nearest_to_any_other_place(tmp_path: Path) -> None:
    folder = tmp_path / "my model"
    write_model(faults(F60), folder)
    model = read_model(folder / "model.toml")
    where = AT_MIDDLE + np.array([1.0, 0.5, 0.0])
    worst = Worst(1.0, "m", *where)
    finding = Finding("near-miss", Status.WARN, ("F",), 1, worst, places=where[None], element=Element.NODE)
    (result,) = sarif(made((finding,), model))["results"]
    assert str(MIDDLE + 1) in line_of(result["locations"][0], folder).split()[1:]


def test_sarif_paths_are_relative_only_inside_the_folder(tmp_path: Path) -> None:
    inside, outside = tmp_path / "my model" / "a b#%.ts", tmp_path / "elsewhere" / "é.ts"
    finding = Finding("finite", Status.FAIL, ("F",))
    expected = {inside: "a%20b%23%25.ts", outside: outside.as_uri()}
    for file, uri in expected.items():
        model = replace(faults(replace(F60, file=file)), file=tmp_path / "my model" / "model.toml")
        (result,) = sarif(made((finding,), model))["results"]
        artifact = result["locations"][0]["physicalLocation"]["artifactLocation"]
        assert artifact["uri"] == uri
        assert ("uriBaseId" in artifact) is (file == inside)
    # nothing but the model is known
    (result,) = sarif(made((Finding("finite", Status.FAIL),), model))["results"]
    assert result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] == "model.toml"
    (result,) = sarif(made((finding,), faults(F60)))["results"]
    assert "physicalLocation" not in result["locations"][0]


def placed(model: Path, working: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[dict, dict]:
    """The base that a log of a finding names, and where the finding lies, with a working directory."""
    monkeypatch.chdir(working)
    known = replace(faults(replace(F60, file=model.parent / "faults" / "F 1.ts")), file=model)
    run = sarif(made((Finding("finite", Status.FAIL, ("F",)),), known))
    (result,) = run["results"]
    return run["originalUriBaseIds"]["%SRCROOT%"], result["locations"][0]["physicalLocation"][
        "artifactLocation"
    ]


@pytest.mark.parametrize("mark", ["folder", "file"])
def test_sarif_paths_are_relative_to_the_repository(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mark: str
) -> None:
    """Whatever the working directory: a code host knows the root of the repository alone."""
    model = tmp_path / "fields" / "north" / "model.toml"
    model.parent.mkdir(parents=True)
    git = tmp_path / ".git"
    git.mkdir() if mark == "folder" else git.write_text("gitdir: elsewhere\n")
    logs = [placed(model, working, monkeypatch) for working in (tmp_path, model.parent, tmp_path.parent)]
    expected = {"uri": "fields/north/faults/F%201.ts", "uriBaseId": "%SRCROOT%"}
    assert [place for _, place in logs] == [expected] * 3
    assert all("repository" in base["description"]["text"] and "uri" not in base for base, _ in logs)
    # a model.toml that is named by a path relative to the working directory
    monkeypatch.chdir(tmp_path / "fields")
    assert Root.of(replace(faults(F60), file=Path("north/model.toml"))).folder == tmp_path


def test_sarif_paths_outside_a_repository_are_relative_to_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = tmp_path / "north" / "model.toml"
    model.parent.mkdir()
    base, place = placed(model, tmp_path, monkeypatch)
    assert place["uri"] == "north/faults/F%201.ts"
    assert "working directory" in base["description"]["text"]
    (tmp_path / "south").mkdir()
    base, place = placed(model, tmp_path / "south", monkeypatch)
    assert place["uri"] == "faults/F%201.ts"
    assert "folder of model.toml" in base["description"]["text"]


def test_fingerprints_know_a_finding_again_wherever_it_moves() -> None:
    def prints(*findings: Finding) -> list[str]:
        return [r["partialFingerprints"]["grabenFinding/v1"] for r in sarif(made(findings))["results"]]

    here = Finding("trace", Status.FAIL, ("H", "F"), 1, Worst(1.0, "m", 1.0, 2.0, 3.0))
    there = replace(here, count=2, worst=Worst(2.0, "m", 5.0, 2.0, 3.0), message="Other.")
    assert prints(here) == prints(there)
    assert prints(here) != prints(replace(here, objects=("H", "G")))
    assert len(set(prints(here, there))) == 2
