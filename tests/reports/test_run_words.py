"""The summary of a run: a mail can hold it, and -v leaves nothing out."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import pytest

from graben.finding import CheckResult, Finding, Profile, Status
from graben.modeling.results import Subdomain, Termination, TerminationType
from graben.pipeline import RunResult
from graben.reports.plain import LINE, PAGE, folded
from graben.reports.run_words import run_summary
from graben.reports.summary import ended_words, verdict, with_total
from tests.reports import sample
from tests.reports.check_models import EVIL


def crowded() -> RunResult:
    """A run with many horizons that failed and succeeded, many findings, and names that are long."""
    failed = sample.failed_run()
    names = [f"Horizon number {k} of the northern block" for k in range(30)]
    findings = tuple(
        Finding("min-dip", Status.WARN, (f"F{k}",), 1, None, f"Flat {k} {'words ' * 40}.", f"Mend {k % 9}.")
        for k in range(200)
    )
    # 138 m, open or not
    horizons = tuple(
        sample.cut_result(name, termination=failed.horizons[0].subdomains[0].termination)
        if k % 3 == 0
        else sample.cut_result(name)
        for k, name in enumerate(names)
    )
    return replace(
        failed,
        model=sample.model(names=tuple(names)),
        horizons=horizons,
        after=CheckResult(Profile.EXTENDED, findings),
        not_modeled=MappingProxyType({"Top B": "Top B is not a function of x and y. " * 20}),
    )


def test_it_fits_a_mail() -> None:
    for result in (sample.run_result(), sample.failed_run(), crowded()):
        lines = run_summary(result).splitlines()
        assert all(len(line) <= LINE for line in lines)
        assert len(lines) <= PAGE
        assert " ".join(lines).startswith(verdict(result)[:60])


def test_every_horizon_has_a_line_with_its_throw_and_how_it_ended() -> None:
    passed, failed = run_summary(sample.run_result()), run_summary(sample.failed_run())
    assert "  Top A  1 fault, largest throw 138 m, converged in 4 iterations\n" in passed
    assert "  Top B  no fault cuts it: passed through as it is\n" in passed
    assert "largest throw -90 m" in run_summary(sample.run_result(throw=-90.0))
    said = " ".join(failed.split())
    # a throw that is not final is marked, and the type stands last
    assert "largest throw 138 m (not final), 1 of 1 subdomain did not converge" in said
    assert "runs beyond the end of a rim or branch line of F1 (type 3)" in said
    assert "Top B not modeled: Top B is not a function of x and y." in said


def test_remedies_are_said_once_and_findings_counted() -> None:
    result = crowded()
    text = run_summary(result)
    assert "Warns (see report): min-dip 200, notes on horizons 0" not in text
    assert "Warns (see report): min-dip 200." in text
    assert text.count("Mend 1.") <= 1
    assert "-v lists them" in text
    failed = run_summary(sample.failed_run())
    assert "Fails (see report): acyclic 1.\nWarns (see report): min-dip 1, notes on horizons 1." in failed
    assert failed.count("Extend the fault downwards by 40 m or leave the horizon out.") == 1


def test_verbose_lists_everything_in_lines_that_a_search_finds() -> None:
    result = crowded()
    lines = run_summary(result, verbose=True).splitlines()
    for finding in result.after.findings:
        assert any(finding.message in line and finding.remedy in line for line in lines)
    assert sum("not converged" in line or "did not converge" in line for line in lines) >= 10
    assert sum(line.lstrip().startswith("subdomain 0 (F1)") for line in lines) == 30
    assert any(
        "note: Top A: Look <here>." in line
        for line in run_summary(sample.failed_run(), verbose=True).splitlines()
    )
    assert "subdomain 0" not in run_summary(sample.run_result())


def test_a_name_that_a_note_says_is_not_said_again() -> None:
    result = sample.run_result()
    noted = replace(result.horizons[0], warnings=("Top A lies below Top B in 8 places.",))
    text = run_summary(replace(result, horizons=(noted, result.horizons[1])), verbose=True)
    assert "  note: Top A lies below Top B in 8 places." in text.splitlines()


def test_the_seconds_are_those_of_the_command() -> None:
    result = with_total(sample.run_result(), 7.0)
    assert result.timings["total"] == 7.0
    assert result.timings["read"] == pytest.approx(7.0 - 0.25)
    assert "; 7 s, 210 MB." in run_summary(result)
    assert "; 12.3 s, 210 MB." in run_summary(result, seconds=12.34)


def test_evil_names_steer_no_terminal() -> None:
    for verbose in (False, True):
        text = run_summary(sample.failed_run(EVIL[0]), verbose=verbose)
        assert all(line.isprintable() for line in text.splitlines())


@pytest.mark.parametrize(
    ("type_", "name", "says"),
    [
        (TerminationType.CONVERGED, "converged", "converged (type 0)"),
        (TerminationType.STAGNATION, "stagnation", "does not come to rest at F1 (type 1)"),
        (TerminationType.STAGNATION, "not anchored", "nothing holds it (type 1)"),
        (TerminationType.STAGNATION, "unstable", "its cuts lie too close to solve (type 1)"),
        (TerminationType.PROJECTION_FAILURE, "projection failure", "runs beyond the end of F1 (type 2)"),
        (TerminationType.VERTEX_REACHED, "vertex reached", "rim or branch line of F1 (type 3)"),
    ],
)
def test_types_in_plain_words(type_: TerminationType, name: str, says: str) -> None:
    ended = Subdomain(0, ("F1",), 9, 5, 3, Termination(type_, name, fault="F1"))
    assert ended_words(ended).endswith(says)


def test_folded_lines_hold_every_word() -> None:
    text = "word " * 60 + "n" * 250
    lines = folded(text, "  ", 40)
    assert all(len(line) <= 40 for line in lines)
    assert "".join("".join(lines).split()) == "".join(text.split())


def test_what_to_do_names_what_it_is_about() -> None:
    advice = "Set gamma to about 4 steps."
    found = [
        Finding("horizon", Status.WARN, (name, "F1"), 1, None, "Smeared.", advice) for name in ("A", "B")
    ]
    found += [Finding("trace", Status.WARN, ("F1",), 1, None, "Short.", "Extend F1.")]
    result = sample.run_result()
    noted = replace(result.horizons[0], warnings=("gamma is few steps. To do: raise gamma.",))
    text = run_summary(replace(result, after=CheckResult(Profile.EXTENDED, tuple(found)), horizons=(noted,)))
    assert f"  - horizon, A, F1, B: {advice}\n" in text
    assert "  - trace: Extend F1.\n" in text
    assert text.endswith(f"  - {noted.name}: Raise gamma.")
