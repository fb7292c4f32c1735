"""What is said of files, keys and units that are not what they should be: the cause, its place, the mend."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from graben.arrays import FloatArray, floats
from graben.drafting import draft_model
from graben.errors import InputError
from graben.finding import CheckResult, Finding, Status
from graben.guessing import guesses
from graben.model import Fault, GridGeometry, Horizon, Model
from graben.nulls import MARKS, null_marks
from graben.pipeline import check
from graben.reading import read_model
from graben.surface import Surface
from tests.models import grid_horizon, model_of, plane_fault
from tests.test_reading import folder_of, section

FAULT = plane_fault((0, -900), (0, 900))


def bed(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.asarray(0.02 * x + 0.01 * y - 20.0 * np.sign(x))


def of_trace(result: CheckResult) -> list[Finding]:
    return [f for f in result.of("trace") if f.status is not Status.PASS]


def refused(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        read_model(path)
    return str(caught.value)


def test_a_step_is_refused_for_a_grid(tmp_path: Path) -> None:
    said = refused(folder_of(tmp_path, section("horizons", name="Top", file="top.irap", step=50.0)))
    assert all(word in said for word in ("step = 50", "'Top'", "grid", "take the key step out"))


def test_a_misspelled_key_is_told_before_the_one_that_is_missing_for_it(tmp_path: Path) -> None:
    said = refused(folder_of(tmp_path, section("horizons", name="Top", fiel="top.irap")))
    assert "'fiel'" in said
    assert "did you mean 'file'?" in said


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            section("horizons", name="Top"),
            "'file' is missing in [[horizons]] number 1 ('Top'); add it: grid,",
        ),
        (section("faults", name="F"), "number 1 ('F'); add it: triangulated surface, or fault sticks."),
        (
            '[[contacts]]\nfaults = ["A", "B"]\n',
            "'rule' is missing in [[contacts]] number 1; add it: `accept`",
        ),
    ],
)
def test_a_key_that_is_missing_is_told_with_its_meaning(tmp_path: Path, text: str, says: str) -> None:
    assert says in refused(folder_of(tmp_path, text))


def test_a_table_that_is_missing_is_told_with_its_meaning(tmp_path: Path) -> None:
    (tmp_path / "model.toml").write_text("[parameters]\n")
    assert "the table 'model' is missing; add it: what the model is called" in refused(
        tmp_path / "model.toml"
    )


def test_backslashes_in_paths_are_told_to_be_slashes(tmp_path: Path) -> None:
    file = folder_of(tmp_path, '[[horizons]]\nname = "Top"\nfile = "data\\Xop.irap"\n')
    said = refused(file)
    assert "line 7" in said
    assert "write / in paths" in said
    file.write_text(file.read_text().replace('"data\\Xop.irap"', "'data\\Xop.irap'"))
    assert "write /" in refused(file)


@pytest.mark.parametrize(("name", "held"), [("p.csv", "points"), ("top.irap", "grid"), ("f1.ts", "TSurf")])
def test_data_given_for_a_model_are_named(tmp_path: Path, name: str, held: str) -> None:
    folder_of(tmp_path, "")
    said = refused(tmp_path / name)
    assert held in said
    assert "not a model: graben init" in said


def test_an_empty_model_says_how_one_is_made(tmp_path: Path) -> None:
    (tmp_path / "model.toml").write_text("\n")
    assert "graben init" in refused(tmp_path / "model.toml")


@pytest.mark.parametrize("mark", ["-999.25", "1e30"])
def test_null_values_of_points_are_named_with_file_and_line(tmp_path: Path, mark: str) -> None:
    file = folder_of(tmp_path, section("horizons", name="P", file="p.csv"))
    lines = (tmp_path / "p.csv").read_text().splitlines()
    lines = [line if k != 40 else ";".join([*line.split(";")[:2], mark]) for k, line in enumerate(lines)]
    # Elevations from -1100 to -1000: -999.25 is one of them, unless they lie further off.
    lines = [lines[0], *(line.replace(";-1", ";-3") for line in lines[1:])]
    (tmp_path / "p.csv").write_text("\n".join(lines))
    (found,) = [f for f in check(read_model(file)).of("finite") if f.status is Status.FAIL]
    assert found.objects == ("P",)
    assert found.count == 1
    assert "p.csv" in found.message
    assert "line 41" in found.message
    assert f"z = {float(mark):g} is likely a null value" in found.message


def test_null_values_of_a_grid_are_taken_as_undefined(tmp_path: Path) -> None:
    from graben.formats.irap import write_irap_ascii

    grid = GridGeometry(6, 5, 50.0, 50.0, (0.0, 0.0))
    values = np.full((6, 5), -2000.0) + np.arange(5)
    values[0, 0] = -999.25
    file = folder_of(tmp_path, section("horizons", name="Top", file="n.irap"))
    write_irap_ascii(tmp_path / "n.irap", grid, floats(values))
    (horizon,) = read_model(file).horizons
    assert len(horizon.surface.vertices) == 29
    assert any("1 grid nodes of -999.25" in note for note in horizon.notes)


def test_a_mark_among_true_values_is_a_value() -> None:
    values = np.array([-1010.0, -990.0, *MARKS])
    assert null_marks(floats([-1010.0, -990.0, -999.25])).tolist() == [False] * 3
    assert null_marks(values).tolist() == [m in MARKS and not -1030.0 <= m <= -970.0 for m in values.tolist()]


def with_horizon(horizon: Horizon, *offset: float) -> Model:
    return replace(model_of(horizon, FAULT), horizons=(horizon.moved(floats(offset)),))


@pytest.mark.parametrize(
    ("offset", "where", "cause"),
    [((0, 0, 9000), "above all faults", "sign of z"), ((90_000, 0, 0), "beside all", "coordinate system")],
)
def test_a_horizon_far_from_all_faults_is_told_with_likely_causes(offset, where, cause) -> None:
    near, far = grid_horizon(bed), replace(grid_horizon(bed), name="far")
    far = replace(far, surface=replace(far.surface, name="far")).moved(floats(offset))
    result = check(replace(model_of(near, FAULT), horizons=(near, far)))
    assert result.passed
    (said,) = of_trace(result)
    assert said.objects == ("far",)
    assert where in said.message
    assert cause in said.remedy


def test_where_no_fault_cuts_anything_it_is_said() -> None:
    result = check(with_horizon(grid_horizon(bed), 0.0, 0.0, 9000.0))
    assert result.passed
    said = {f.objects: f for f in of_trace(result)}
    assert set(said) == {("H",), ("F1",)}
    assert "No fault of the model cuts any" in said[("F1",)].message
    assert all(word in said[("F1",)].remedy for word in ("sign of z", "unit", "coordinate system"))


def test_a_horizon_above_its_fault_is_not_far() -> None:
    """A bed above the tip of a fault is no mistake: only that the fault cuts nothing is said."""
    (said,) = of_trace(check(with_horizon(grid_horizon(bed), 0.0, 0.0, 700.0)))
    assert said.objects == ("F1",)


def test_a_step_longer_than_the_fault_is_too_coarse() -> None:
    short = plane_fault((0, -90), (0, 90), depth=100.0, parts=(9, 5))
    (said,) = of_trace(check(model_of(grid_horizon(bed, step=200.0), short)))
    assert said.objects == ("H", "F1")
    assert "too coarse for F1" in said.message
    assert "a step of 22.5 m or less" in said.remedy


def test_a_gamma_wider_than_the_horizon_is_told_with_its_place() -> None:
    result = check(model_of(grid_horizon(bed), FAULT, gamma=4e6))
    (said,) = of_trace(result)
    assert said.worst is not None
    assert said.worst.value == 4e6
    assert abs(said.worst.x) < 100.0
    assert "400 m" in said.remedy
    assert not of_trace(check(model_of(grid_horizon(bed), FAULT, gamma=400.0)))


def test_a_fault_given_as_a_horizon_is_called_one() -> None:
    surface = Surface("H", FAULT.surface.vertices, FAULT.surface.triangles)
    model = model_of(Horizon("H", surface, 100.0), Fault(FAULT.surface))
    (said,) = of_trace(check(model))
    assert said.status is Status.FAIL
    assert "dips 60 degrees" in said.message
    assert "[[faults]]" in said.remedy


def test_init_names_the_file_whose_z_has_the_other_sign(tmp_path: Path) -> None:
    for name, sign in (("a", 1), ("b", 1), ("c", -1)):
        rows = [f"{x},{y},{sign * (1500 + x)}" for x in range(0, 500, 50) for y in range(0, 500, 50)]
        (tmp_path / f"{name}.csv").write_text("X,Y,Z\n" + "\n".join(rows))
    made = guesses([tmp_path])
    assert [g.name for g in made.surfaces if "other sign" in g.reason] == ["c"]
    assert made.z == "depth"


def test_init_writes_what_the_defaults_come_to(tmp_path: Path) -> None:
    folder_of(tmp_path, "")
    for name in ("model.toml", "two.ts", "unstated.ts", "s.pol"):
        (tmp_path / name).unlink()
    draft_model([tmp_path], tmp_path / "drafted.toml")
    text = (tmp_path / "drafted.toml").read_text()
    (horizon,) = read_model(folder_of(tmp_path, section("horizons", name="P", file="p.csv"))).horizons
    assert f"# step = {horizon.step:#.4g}" in text
    assert f"gamma is {4 * horizon.step:.4g} by default" in text
    assert "gamma is 160 by default, 4 x its own step, 40" in text
    assert "# gamma = 160.0           # half-width of the zone beside a fault; default 4 steps" in text
    assert f"160 to {4 * horizon.step:.4g} here" in text
    assert "# max_move = 20.00" in text
