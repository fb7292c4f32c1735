from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graben.errors import InputError
from graben.formats.tsurf import read_tsurf
from graben.formats.tsurf_writer import write_tsurf
from graben.surface import Surface
from tests.formats.dialects import BROKEN, HEAD, MESH, SAME, frame, model3d

DATA = Path(__file__).parents[3] / "shared" / "data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="shared data are not here")


def written(folder: Path, text: str, name: str = "file.ts") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8", newline="")
    return path


@pytest.mark.parametrize("dialect", SAME)
def test_every_dialect_gives_the_same_surface(tmp_path: Path, dialect: str) -> None:
    text = SAME[dialect]
    (item,) = read_tsurf(written(tmp_path, text))
    surface = item.surface
    assert surface.name == "A" and item.named
    assert surface.vertices[surface.triangles].tolist() == [
        [[0, 0, 1], [1, 0, 2], [0, 1, 3]],
        [[1, 0, 2], [1, 1, 4], [0, 1, 3]],
    ]
    assert len(surface.vertices) == 4
    lines = text.splitlines()
    assert (item.role == "fault") == ("Model3d" in dialect or "feature" in dialect)
    assert all(lines[n - 1].startswith("TRGL") for n in surface.lines)


@pytest.mark.parametrize("case", BROKEN)
def test_what_cannot_be_read_is_named(tmp_path: Path, case: str) -> None:
    text, words = BROKEN[case]
    path = written(tmp_path, text)
    with pytest.raises(InputError) as caught:
        read_tsurf(path)
    message = str(caught.value)
    assert str(path) in message and "\n" not in message
    assert all(word in message for word in words), message


def test_several_objects_stay_apart_with_their_own_sign(tmp_path: Path) -> None:
    text = HEAD + frame("Depth") + MESH + "\n" + HEAD.replace(":A", ": B two") + MESH
    first, second = read_tsurf(written(tmp_path, text))
    assert (first.surface.name, second.surface.name) == ("A", "B two")
    assert (first.z, second.z) == ("depth", None)
    assert first.surface.vertices[:, 2].tolist() == [-1, -2, -3, -4]
    assert second.upward("elevation").vertices[:, 2].tolist() == [1, 2, 3, 4]
    assert second.upward("depth").vertices[:, 2].tolist() == [-1, -2, -3, -4]
    assert first.upward("depth").vertices[:, 2].tolist() == [-1, -2, -3, -4]


def test_surfaces_of_a_model3d_count_z_as_it_does_unless_they_say_so(tmp_path: Path) -> None:
    objects = HEAD + MESH + HEAD.replace(":A", ":B") + frame("Elevation") + MESH
    first, second = read_tsurf(written(tmp_path, model3d(objects, "Depth")))
    assert (first.z, second.z) == ("depth", "elevation")
    assert (first.role, second.role) == ("fault", "")
    assert np.array_equal(first.surface.vertices[:, 2], -second.surface.vertices[:, 2])


def test_other_objects_of_a_file_are_passed_over(tmp_path: Path) -> None:
    line = "GOCAD PLine 1\nHEADER {\nname:L\n}\nILINE\nVRTX 1 x y z\nEND\n"
    assert [item.surface.name for item in read_tsurf(written(tmp_path, line + HEAD + MESH))] == ["A"]


def test_a_surface_without_name_has_that_of_its_file(tmp_path: Path) -> None:
    (item,) = read_tsurf(written(tmp_path, "GOCAD TSurf 1\n" + MESH, "nameless.ts"))
    assert item.surface.name == "nameless" and not item.named


def test_unfit_data_are_kept(tmp_path: Path) -> None:
    text = HEAD + MESH.replace("0 0 1\n", "nan 0 -inf\n").replace("TRGL 2 4 3", "TRGL 2 99 3")
    text = text.replace("VRTX 4 1 1 4", "VRTX 4 1 0 2")
    (item,) = read_tsurf(written(tmp_path, text))
    assert np.isnan(item.surface.vertices[0, 0]) and item.surface.vertices[0, 2] == -np.inf
    assert item.surface.triangles.tolist() == [[0, 1, 2], [1, -1, 2]]
    assert item.surface.vertices[3].tolist() == item.surface.vertices[1].tolist()


def test_an_atom_of_nothing_is_an_unfit_index(tmp_path: Path) -> None:
    text = HEAD + MESH.replace("TRGL 1 2 3\n", "ATOM 5 77\nATOM 6 5\nTRGL 1 2 6\n")
    assert read_tsurf(written(tmp_path, text))[0].surface.triangles[0].tolist() == [0, 1, -1]


def test_an_atom_of_an_atom_is_its_vertex(tmp_path: Path) -> None:
    text = HEAD + MESH.replace("TRGL 1 2 3\n", "ATOM 6 5\nATOM 5 3\nTRGL 1 2 6\n")
    assert read_tsurf(written(tmp_path, text))[0].surface.triangles[0].tolist() == [0, 1, 2]


def test_a_name_in_latin_1_is_read(tmp_path: Path) -> None:
    path = tmp_path / "file.ts"
    path.write_bytes(HEAD.replace(":A", ":Störung").encode("latin-1") + MESH.encode())
    assert read_tsurf(path)[0].surface.name == "Störung"


@pytest.mark.parametrize("z", ["elevation", "depth"])
def test_what_is_written_reads_back_to_the_bit(tmp_path: Path, z: str) -> None:
    rng = np.random.default_rng(7)
    vertices = rng.normal(size=(30, 3)) * [1e6, 1e7, 1e-3] + [5e5, 6e6, 0]
    surfaces = [Surface(n, vertices * f, rng.integers(0, 30, (40, 3))) for n, f in (("A b", 1), ("ü", 1 / 3))]
    path = tmp_path / "out.ts"
    write_tsurf(path, surfaces, z="depth" if z == "depth" else "elevation", feature="top", unit="ft", crs="X")
    back = read_tsurf(path)
    assert [item.z for item in back] == [z, z]
    for surface, item in zip(surfaces, back, strict=True):
        assert item.surface.name == surface.name
        assert np.array_equal(item.surface.vertices, surface.vertices)
        assert np.array_equal(item.surface.triangles, surface.triangles)
    text = path.read_text(encoding="utf-8")
    assert f"ZPOSITIVE {z.capitalize()}" in text and "GEOLOGICAL_TYPE top" in text and '"ft"' in text


def test_a_large_file_with_properties_reads_back_to_the_bit(tmp_path: Path) -> None:
    n = 225
    x, y = np.meshgrid(np.arange(n) * 50.123, np.arange(n) * 49.321, indexing="ij")
    vertices = np.stack([x, y, np.sin(x + y)], axis=-1).reshape(-1, 3)
    k = np.arange(n * n).reshape(n, n)
    a, b, c, d = (part.ravel() for part in (k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]))
    surface = Surface("A", vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))
    path = tmp_path / "large.ts"
    write_tsurf(path, [surface], properties={"fixed": np.ones(n * n, dtype=int), "u": vertices[:, 2]})
    (item,) = read_tsurf(path)
    assert len(item.surface.triangles) > 100_000
    assert np.array_equal(item.surface.vertices, vertices)


@needs_data
def test_real_files() -> None:
    hecho = read_tsurf(DATA / "hecho" / "AllFaultSurfaces.ts")
    assert [(i.surface.name, len(i.surface.triangles)) for i in hecho] == [
        ("F1Surf", 80),
        ("F2Surf", 168),
        ("F3Surf", 120),
    ]
    files = sorted((DATA / "cfm").glob("*.ts"))
    read = [read_tsurf(file) for file in files]
    assert [item.surface.name for (item,) in read] == [file.stem for file in files]
    assert sum(len(item.surface.triangles) for (item,) in read) == 55_208
    assert all(item.z == "elevation" and item.surface.triangles.min() >= 0 for (item,) in read)
