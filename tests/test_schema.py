from __future__ import annotations

import tomllib
from pathlib import Path

import jsonschema
import pytest

from graben.finding import CheckResult, Finding, Profile, Status, Worst
from graben.schema import schemas

DATA = Path(__file__).parents[2] / "shared" / "data"


def test_they_are_schemas() -> None:
    for schema in schemas().values():
        jsonschema.Draft202012Validator.check_schema(schema)


def valid(content: object, name: str) -> bool:
    return jsonschema.Draft202012Validator(schemas()[name]).is_valid(content)


@pytest.mark.parametrize("name", ["claudius", "drogon", "hecho"])
def test_real_models_are_valid(name: str) -> None:
    path = DATA / name / "model.toml"
    if not path.is_file():
        pytest.skip("shared data are not here")
    assert valid(tomllib.loads(path.read_text(encoding="utf-8")), "model.toml")


@pytest.mark.parametrize(
    ("text", "good"),
    [
        ('[model]\nname = "M"', True),
        ('[model]\nname = "M"\nz = "down"', False),
        ('[model]\nname = "M"\n[[horizons]]\nname = "H"', False),
        ('[model]\nname = "M"\n[[horizons]]\nname = "H"\nfile = "h"\nstepp = 3', False),
        ('[model]\nname = "M"\n[[contacts]]\nfaults = ["a", "b"]\nrule = "force"', True),
        ('[model]\nname = "M"\n[[contacts]]\nfaults = ["a"]\nrule = "force"', False),
        ('[model]\nname = "M"\n[parameters]\ntheta = 2', False),
        ("", False),
    ],
)
def test_model_keys(text: str, good: bool) -> None:
    assert valid(tomllib.loads(text), "model.toml") is good


def test_a_verdict_is_valid_alone_and_in_a_report() -> None:
    worst = Worst(3.0, "m", 1.0, 2.0, -3.0)
    findings = (Finding("finite", Status.FAIL, ("F1",), 2, worst), Finding("oriented", Status.PASS))
    check = CheckResult(Profile.PAPER, findings).as_dict()
    assert valid(check, "check")
    report = {"schema": 1, "model": "M", "before": check, "repairs": [], "after": check}
    assert valid(report, "report.json")
    assert not valid({**report, "after": {**check, "passed": "yes"}}, "report.json")
    assert not valid({key: value for key, value in check.items() if key != "profile"}, "check")
