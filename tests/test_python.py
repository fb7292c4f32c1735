"""The Python interface: calls that take a path, values that print in a line, tables, folders."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import graben
from graben.errors import OutputError
from graben.finding import Finding, Status
from graben.modeling.results import HorizonResult
from graben.pipeline import RunResult
from tests.commands import graben as command
from tests.reports import sample

#: A line that a terminal or a notebook shows as it is.
LONGEST = 200


@pytest.fixture(scope="module")
def toml(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("python") / "tee"
    assert command("demo", "tee", "--step", "200", "-o", folder).returncode == 0
    return folder / "model.toml"


@pytest.fixture(scope="module")
def run(toml: Path) -> RunResult:
    return graben.build(graben.read_model(toml))


def test_a_path_is_taken_for_a_model(toml: Path) -> None:
    assert graben.repair(toml).passed
    assert graben.check(str(toml)).passed
    assert graben.build(toml).passed
    for call in (graben.check, graben.repair, graben.build):
        with pytest.raises(TypeError, match=r"not int: see graben\.read_model"):
            call(3)
        with pytest.raises(graben.InputError, match=r"nowhere\.toml"):
            call("nowhere.toml")


def test_an_unknown_profile_names_those_that_there_are(run: RunResult) -> None:
    for call in (graben.check, graben.repair, graben.build):
        with pytest.raises(ValueError, match="no profile 'strict': it is 'paper' or 'extended'"):
            call(run.model, "strict")


def test_values_print_in_a_line(run: RunResult) -> None:
    (horizon,) = run.horizons
    for value in (*horizon.cutoffs, *horizon.subdomains, horizon, *run.after.findings):
        assert len(repr(value)) < LONGEST
        assert "array" not in repr(value)
        assert "\n" not in repr(value)
        assert value._repr_html_().count("<table>") >= 1
    cutoff = horizon.cutoffs[0]
    assert repr(cutoff).startswith(f"Cutoff of {cutoff.fault!r}: {len(cutoff.s)} pairs, s 0 to ")
    assert f"throw {cutoff.throw.min():.4g} to {cutoff.throw.max():.4g}" in repr(cutoff)
    assert repr(horizon.subdomains[0]).endswith("type 0, converged")
    assert "1 subdomain, type 0" in repr(horizon)


def test_names_are_text_in_notebooks() -> None:
    result = sample.cut_result("<b>H", "<i>F")
    for value in (result, *result.cutoffs, *result.subdomains, Finding("trace", Status.FAIL, ("<i>F",))):
        shown = value._repr_html_()
        assert "<b>H" not in shown
        assert "<i>F" not in shown
        assert "&lt;i&gt;F" in shown


def test_throws_stand_at_the_nodes_of_both_lips(run: RunResult) -> None:
    for result in (run.horizons[0], sample.cut_result()):
        throws = result.node_throws()
        assert np.array_equal(np.isfinite(throws), result.side != 0)
        assert np.nanmax(np.abs(throws)) == result.largest_throw
    result = sample.cut_result()
    throws = result.node_throws()
    # the lips of the sample lie in the order of its cutoff, whose ends are tips
    for side in (1, -1):
        assert np.array_equal(throws[result.side == side], result.cutoffs[0].throw[1:-1])
    assert np.isnan(sample.uncut_result().node_throws()).all()
    assert {"subdomain", "fixed", "side", "throw"} <= set(run.horizons[0].to_pyvista().point_data)


def test_a_run_shows_horizons_with_throws_and_types(run: RunResult) -> None:
    shown = run._repr_html_()
    row = f"<td>Top</td><td>F1, F2</td><td>{run['Top'].largest_throw:.4g}</td><td>1 converged (type 0)</td>"
    assert row in shown
    failed = sample.failed_run("<i>F")._repr_html_()
    assert "1 guide ended (type 3)" in failed
    assert "not modeled: Top B is not a function" in failed
    assert "<i>F" not in failed


def test_blocks_have_names_and_say_what_they_are(run: RunResult) -> None:
    blocks = run.to_pyvista()
    names = blocks.keys()
    assert names == ["Top", "F1", "F2"]
    assert [blocks[name].field_data["kind"][0] for name in names] == ["horizon", "fault", "fault"]
    assert [blocks[name].field_data["name"][0] for name in names] == names


def test_a_run_is_written_as_the_command_writes_it(run: RunResult, toml: Path, tmp_path: Path) -> None:
    report = graben.write(run, tmp_path / "python")
    assert report == tmp_path / "python" / "report.html"
    assert command("run", toml, "-o", tmp_path / "command").returncode == 0
    files = [
        {p.relative_to(tmp_path / name) for p in (tmp_path / name).rglob("*")}
        for name in ("python", "command")
    ]
    assert files[0] == files[1]
    for file in ("cutoffs/Top.csv", "horizons/Top.ts", "model/model.toml"):
        assert (tmp_path / "python" / file).read_bytes() == (tmp_path / "command" / file).read_bytes()
    with pytest.raises(OutputError, match="not empty"):
        graben.write(run, tmp_path / "python")


def test_a_repair_is_written_as_well(run: RunResult, tmp_path: Path) -> None:
    report = graben.write(graben.repair(run.model), str(tmp_path / "repaired"))
    assert report.is_file()
    assert graben.read_model(tmp_path / "repaired" / "model.toml").name == run.model.name


def test_the_type_of_a_horizon_result_is_public(run: RunResult) -> None:
    assert isinstance(run["Top"], HorizonResult)
