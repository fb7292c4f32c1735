"""report.json: keys, convention of z, strict JSON."""

from __future__ import annotations

import json
from dataclasses import replace

import jsonschema
import numpy as np
import pytest

from graben.modeling.results import Termination, TerminationType
from graben.reports.json_report import as_text, run_report
from graben.schema import schemas
from tests.reports import sample

KEYS = {"schema", "model", "before", "repairs", "after", "horizons", "timings", "peak_memory_mb"}
SUBDOMAIN_KEYS = {
    "id",
    "faults",
    "unknowns",
    "iterations",
    "termination",
    "mean_displacement",
    "mean_deviation",
    "history",
    "remeshings",
}


def test_has_the_keys_of_the_contract():
    report = run_report(sample.run_result(), {"Top A": {"surface": "horizons/Top_A.ts"}})
    assert report.keys() >= KEYS
    cut, uncut = report["horizons"]
    assert cut["files"] == {"surface": "horizons/Top_A.ts"}
    assert cut["nodes"] == len(sample.cut_result().surface.vertices)
    assert cut["subdomains"][0].keys() >= SUBDOMAIN_KEYS
    assert cut["unknowns"] == cut["subdomains"][0]["unknowns"]
    assert cut["score"].keys() == {"cutoff", "throw", "zone", "zone_input"}
    assert "score" not in uncut
    assert report["repairs"][0].keys() == {
        "action",
        "check",
        "objects",
        "count",
        "max_move",
        "place",
        "reason",
        "size",
        "unit",
        "before",
        "after",
    }


def test_places_of_a_depth_model_are_depths():
    up, down = (run_report(sample.run_result(depth=depth), {}) for depth in (False, True))

    def heights(report):
        findings = [f["worst"]["z"] for f in report["after"]["findings"] if f["worst"]]
        return [*findings, *(r["place"]["z"] for r in report["repairs"])]

    assert heights(up) == [-z for z in heights(down)]
    assert all(z > 0 for z in heights(down))


def test_place_of_a_termination_is_in_the_models_convention():
    result = sample.failed_run()
    place = result.horizons[0].subdomains[0].termination.z
    deep = replace(result, model=replace(result.model, z="depth"))
    for run, factor in ((result, 1.0), (deep, -1.0)):
        termination = run_report(run, {})["horizons"][0]["subdomains"][0]["termination"]
        assert termination["z"] == factor * place
        assert termination["type"] == 3
        assert termination["side"] == "hanging"


def test_numbers_that_are_not_finite_become_null():
    ended = Termination(TerminationType.STAGNATION, "x", short_by=np.inf, x=np.float64("nan"), y=0.0, z=1.0)
    result = replace(sample.run_result(), horizons=(sample.cut_result(termination=ended),))

    def refuse(word: str) -> None:
        pytest.fail(f"{word} is no JSON")

    report = json.loads(as_text(run_report(result, {})), parse_constant=refuse)
    termination = report["horizons"][0]["subdomains"][0]["termination"]
    assert termination["short_by"] is None
    assert termination["x"] is None
    assert termination["y"] == 0.0


def test_text_reads_back_the_same():
    report = run_report(sample.failed_run(sample.EVIL), {})
    assert json.loads(as_text(report)) == report


@pytest.mark.parametrize("result", [sample.run_result(), sample.failed_run()], ids=["passed", "failed"])
def test_keeps_to_its_schema(result):
    report = run_report(result, {"Top A": {"grid": "horizons/Top_A.irap"}})
    assert list(jsonschema.Draft202012Validator(schemas()["report.json"]).iter_errors(report)) == []
