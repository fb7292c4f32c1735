"""A repaired model as a folder: what did not change is copied to the byte, the rest reads back to the bit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from graben.errors import OutputError
from graben.formats.model_file import load_model_file
from graben.formats.repaired import write_repaired
from graben.formats.tsurf_writer import write_tsurf
from graben.formats.writing import write_model
from graben.model import Fault, Model
from graben.pipeline import check
from graben.reading import read_model
from graben.surface import Surface
from tests.formats.test_meshes import fault_files
from tests.formats.zmap_samples import PLAIN
from tests.reports.check_models import EVIL
from tests.zoo.shapes import F60

HEAD = '[model]\nname = "files"\nz = "depth"\ncrs = "EPSG:23031"\n'
SETTINGS = """
[parameters]
theta = 0.25
gamma = 300.0
[repair]
max_move = 7.5
skip = ["weld"]
[[contacts]]
faults = ["F1", "F2"]
rule = "accept"
[checks]
near-miss = 33.0
"""
STICKS = "\n".join(f"0 {y} 100\n-60 {y} 200\n999 999 999" for y in (0, 500, 1000))


def shifted(name: str, north: float) -> Surface:
    return replace(F60.moved(np.array([430_000.1, 6_780_000.0 + north, 0.3])), name=name)


def stored(folder: Path) -> Model:
    """A model of every kind of file: two faults in one, one alone, sticks, a grid and points."""
    (folder / "deep").mkdir(parents=True)
    write_tsurf(folder / "deep" / "both.ts", [shifted("F1", 0.0), shifted("F2", 3000.0)], z="depth")
    # An object that says neither its sign of z nor a name of its own.
    write_tsurf(folder / "alone", [shifted("inner", 6000.0)], z="depth")
    plain = (folder / "alone").read_text().replace("ZPOSITIVE Depth\n", "")
    (folder / "alone").write_text(plain)
    (folder / "sticks.pol").write_text(STICKS)
    (folder / "grid.zmap").write_text(PLAIN)
    rng = np.random.default_rng(0)
    picks = np.round(np.c_[rng.uniform(0, 1000, (300, 2)), rng.uniform(1000, 1020, 300)], 3)
    np.savetxt(folder / "points.csv", picks, "%.3f", delimiter=";", header="X;Y;Z", comments="")
    entries = "\n".join(
        [
            '[[horizons]]\nname = "P"\nfile = "points.csv"\nnoise = 2.0',
            '[[horizons]]\nname = "G"\nfile = "grid.zmap"',
            '[[faults]]\nfile = "deep/both.ts"\ngamma = 250.0',
            '[[faults]]\nname = "F3"\nfile = "alone"',
            '[[faults]]\nname = "F4"\nfile = "sticks.pol"\ngamma = 111.0',
        ]
    )
    (folder / "model.toml").write_text(HEAD + entries + SETTINGS)
    return read_model(folder / "model.toml")


def with_fault(model: Model, name: str, *made: Surface) -> Model:
    """The model with surfaces in place of a fault, which keep its gamma."""
    faults = [
        f
        for old in model.faults
        for f in ([old] if old.name != name else [Fault(s, old.gamma) for s in made])
    ]
    return replace(model, faults=tuple(faults))


def same(one: Model, other: Model) -> bool:
    return [s.name for s in one.surfaces] == [s.name for s in other.surfaces] and all(
        np.array_equal(a.vertices, b.vertices, equal_nan=True) and np.array_equal(a.triangles, b.triangles)
        for a, b in zip(one.surfaces, other.surfaces, strict=True)
    )


def settings(model: Model) -> tuple[object, ...]:
    gammas = [f.gamma for f in model.faults]
    noise = [(h.step, h.noise, h.grid, h.smoothing) for h in model.horizons]
    plain = (model.name, model.z, model.unit, model.crs, model.parameters, model.repair)
    return (*plain, dict(model.checks), gammas, noise)


def test_a_model_that_did_not_change_is_copied_to_the_byte(tmp_path: Path) -> None:
    model = stored(tmp_path / "in")
    path = write_repaired(model, model, tmp_path / "out")
    for source in ("deep/both.ts", "alone", "sticks.pol", "points.csv", "grid.zmap"):
        copy = tmp_path / "out" / Path(source).name
        assert copy.read_bytes() == (tmp_path / "in" / source).read_bytes()
    again = read_model(path)
    assert same(again, model)
    assert settings(again) == settings(model)
    assert again.contacts == model.contacts


@pytest.mark.parametrize("name", ["F1", "F3", "F4"])
def test_a_changed_fault_is_written_alone(name: str, tmp_path: Path) -> None:
    model = stored(tmp_path / "in")
    surface = next(f.surface for f in model.faults if f.name == name)
    bent = surface.with_vertices(surface.vertices + np.pi * 1e-3)
    changed = with_fault(model, name, bent)
    again = read_model(write_repaired(model, changed, tmp_path / "out"))
    assert same(again, changed)
    assert settings(again) == settings(changed)
    kept = {"F1": ["alone", "sticks.pol"], "F3": ["both.ts", "sticks.pol"], "F4": ["both.ts", "alone"]}[name]
    files = {p.name for p in (tmp_path / "out").iterdir()}
    assert files >= {*kept, "points.csv"}
    # the other fault of a file that holds a changed one is written as well, and the file is not copied
    assert ("both.ts" in files) is (name != "F1")
    assert ("F2.ts" in files) is (name == "F1")


def test_parts_of_a_split_fault_keep_its_gamma_and_place(tmp_path: Path) -> None:
    model = stored(tmp_path / "in")
    whole = model.faults[1].surface
    half = len(whole.triangles) // 2
    parts = (
        replace(whole, triangles=whole.triangles[:half]),
        replace(whole, name="F2 (2)", triangles=whole.triangles[half:]),
    )
    changed = with_fault(model, "F2", *parts)
    again = read_model(write_repaired(model, changed, tmp_path / "out"))
    assert [f.name for f in again.faults] == ["F1", "F2", "F2 (2)", "F3", "F4"]
    assert [f.gamma for f in again.faults] == [250.0, 250.0, 250.0, None, 111.0]
    assert same(again, changed)


def test_a_fault_left_out_takes_its_contacts_along(tmp_path: Path) -> None:
    model = stored(tmp_path / "in")
    again = read_model(write_repaired(model, with_fault(model, "F2"), tmp_path / "out"))
    assert [f.name for f in again.faults] == ["F1", "F3", "F4"]
    assert again.contacts == ()


def test_a_file_that_no_longer_says_the_same_is_not_copied(tmp_path: Path) -> None:
    """In Python a model may be altered after it was read, and keeps the names of its files."""
    model = stored(tmp_path / "in")
    altered = model.moved(np.array([100.0, 0.0, 0.0]))
    again = read_model(write_repaired(altered, altered, tmp_path / "out"))
    assert [
        np.array_equal(a.surface.vertices, b.surface.vertices)
        for a, b in zip(again.faults, altered.faults, strict=True)
    ] == [True] * 4
    (tmp_path / "in" / "alone").unlink()
    assert same(read_model(write_repaired(model, model, tmp_path / "gone")), model)


@pytest.mark.parametrize("suffix", ["obj", "ply", "stl", "vtp"])
def test_mesh_files_are_copied_to_the_byte(tmp_path: Path, suffix: str) -> None:
    (tmp_path / "in").mkdir()
    file = fault_files(tmp_path / "in", F60)[suffix]
    keys = f'[model]\nname = "M"\nz = "depth"\n[[faults]]\nname = "F"\nfile = "{file.name}"\n'
    (tmp_path / "in" / "model.toml").write_text(keys)
    model = read_model(tmp_path / "in" / "model.toml")
    again = read_model(write_repaired(model, model, tmp_path / "out"))
    assert (tmp_path / "out" / file.name).read_bytes() == file.read_bytes()
    assert same(again, model)


def test_files_of_one_name_from_two_folders_stay_apart(tmp_path: Path) -> None:
    for folder, north in (("a", 0.0), ("b", 3000.0)):
        (tmp_path / folder).mkdir()
        write_tsurf(tmp_path / folder / "Model.ts", [shifted(folder, north)])
    text = '[model]\nname = "x"\n[[faults]]\nfile = "a/Model.ts"\n[[faults]]\nfile = "b/Model.ts"\n'
    (tmp_path / "model.toml").write_text(text)
    model = read_model(tmp_path / "model.toml")
    again = read_model(write_repaired(model, model, tmp_path / "out"))
    assert same(again, model)
    assert len(list((tmp_path / "out").iterdir())) == 3


@pytest.mark.parametrize(
    "change", [lambda s: s, lambda s: s.with_vertices(s.vertices + 1.0)], ids=["kept", "changed"]
)
def test_names_made_to_break_a_path(change: Callable[[Surface], Surface], tmp_path: Path) -> None:
    names = [n for n in EVIL if n.isprintable()] + ["../../up", "/etc/x", "CON", ".", "model"]
    faults = tuple(Fault(shifted(name, 2000.0 * k)) for k, name in enumerate(names))
    given = read_model(write_model(Model("<script>", (), faults), tmp_path / "in"))
    made = replace(given, faults=tuple(Fault(change(f.surface)) for f in given.faults))
    again = read_model(write_repaired(given, made, tmp_path / "out"))
    assert [f.name for f in again.faults] == names
    assert same(again, made)
    assert all(p.parent == tmp_path / "out" for p in (tmp_path / "out").rglob("*"))
    assert {p.name for p in tmp_path.iterdir()} == {"in", "out"}


def test_the_truth_is_copied_but_not_into_itself(tmp_path: Path) -> None:
    model = stored(tmp_path / "in")
    truth = tmp_path / "truth"
    truth.mkdir()
    (truth / "known.csv").write_text("1\n")
    known = replace(model, truth=truth)
    again = read_model(write_repaired(known, known, tmp_path / "out"))
    assert again.truth is not None
    assert (again.truth / "known.csv").read_text() == "1\n"
    with pytest.raises(OutputError, match="truth"):
        write_repaired(known, known, truth / "deep" / "out")


def test_a_model_made_in_python_is_written_whole(tmp_path: Path) -> None:
    model = Model("made", (), (Fault(shifted("F1", 0.0), 90.0),))
    again = read_model(write_repaired(model, model, tmp_path / "out"))
    assert same(again, model)
    assert again.faults[0].gamma == 90.0


def test_what_is_read_back_gets_the_same_verdict(tmp_path: Path) -> None:
    model = stored(tmp_path / "in")
    bent = model.faults[2].surface.with_vertices(model.faults[2].surface.vertices + 0.5)
    changed = with_fault(model, "F3", bent)
    path = write_repaired(model, changed, tmp_path / "out")
    verdicts = [
        [(f.check, f.status, f.objects, f.count) for f in check(m).findings]
        for m in (changed, read_model(path))
    ]
    assert verdicts[0] == verdicts[1]
    assert load_model_file(path).model.crs == "EPSG:23031"
