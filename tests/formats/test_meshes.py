"""OBJ, PLY, STL and VTP: every dialect gives the same surface, every damage one sentence."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
import pyvista
import trimesh

from graben.errors import InputError
from graben.formats.kinds import Kind, kind_of
from graben.formats.meshes import read_meshes
from graben.formats.tsurf_writer import write_tsurf
from graben.pipeline import check
from graben.reading import read_model
from graben.surface import Surface, boundary_edges
from tests.commands import graben
from tests.zoo.shapes import F60

#: Far from the origin, with more digits than 32 bits hold, and a last vertex that no face uses.
FAR = np.array(
    [
        [500_000.123456789, 4_500_000.987654321, -1000.1],
        [500_100.1, 4_500_000.2, -1000.3],
        [500_100.7, 4_500_100.2, -1100.3],
        [500_000.7, 4_500_100.2, -1100.9],
        [500_050.5, 4_500_050.5, -1234.5],
    ]
)
FACES = [[0, 1, 2], [0, 2, 3]]
QUAD = [[0, 1, 2, 3]]
HEAD = '[model]\nname = "M"\nz = "depth"\n'


def rows(points: np.ndarray, key: str = "") -> str:
    return "".join(f"{key}{x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())


def ply(
    body: bytes, *, form: str = "ascii", real: str = "double", vertices: int = 5, faces: int = 2
) -> bytes:
    axes = "".join(f"property {real} {axis}\n" for axis in "xyz")
    head = (
        f"ply\nformat {form} 1.0\ncomment Stoerung\nelement vertex {vertices}\n{axes}element face {faces}\n"
    )
    return f"{head}property list uchar int vertex_indices\nend_header\n".encode() + body


def ascii_faces(faces: list[list[int]]) -> str:
    return "".join(f"{len(f)} {' '.join(map(str, f))}\n" for f in faces)


def binary_faces(faces: list[list[int]], order: str = "<") -> bytes:
    return b"".join(struct.pack(f"{order}B{len(f)}i", len(f), *f) for f in faces)


def solid(name: str, points: np.ndarray, faces: list[list[int]]) -> str:
    facets = (
        f"facet normal 0 0 0\nouter loop\n{rows(points[f], 'vertex ')}endloop\nendfacet\n" for f in faces
    )
    return f"solid {name}\n{''.join(facets)}endsolid {name}\n"


def stored(folder: Path, content: bytes | str, name: str = "file") -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


V = rows(FAR, "v ")
TWO = "f 1 2 3\nf 1 3 4\n"
SAME: dict[str, bytes | str] = {
    "obj": V + TWO,
    "obj, quads": V + "f 1 2 3 4\n",
    "obj, negative indices": V + "f -5 -4 -3\nf -5 -3 -2\n",
    "obj, negative indices before the last vertices": rows(FAR[:4], "v ")
    + "f -4 -3 -2\nf -4 -2 -1\n"
    + rows(FAR[4:], "v "),
    "obj, faces first": TWO + V,
    "obj, textures and normals": V
    + "vt 0 0\nvt 1 1\nvn 0 0 1\nvn 1 0 0\nf 1/1/1 2/2/1 3/1/2\nf 1/2/2 3/2/1 4/1/1\n",
    "obj, normals": V + "vn 0 0 1\nvn 1 0 0\nf 1//1 2//1 3//2\nf 1//2 3//1 4//1\n",
    "obj, textures, one line without": V + "vt 0 0\nf 1/1 2/1 3/1\nf 1 3 4\n",
    "obj, blanks and tabs": V.replace("v ", "  v\t") + "\tf 1\t2 3 # a face\n\n f  1 3 4",
    "obj, Windows line ends": (V + TWO).replace("\n", "\r\n"),
    "obj, colours": V.replace("\n", " 1 0 0\n") + TWO,
    "obj, a line that goes on": V + "f 1 \\\n2 3\nf 1 3 4\n",
    "obj, materials": "mtllib none.mtl\n" + V + "usemtl a\nf 1 2 3\ns 1\nusemtl b\nf 1 3 4\n",
    "obj, comments first, marked as UTF-8": "\ufeff# Störung\n\n" + V + TWO,
    "ply": ply((rows(FAR) + ascii_faces(FACES)).encode()),
    "ply, quads": ply((rows(FAR) + ascii_faces(QUAD)).encode(), faces=1),
    "ply, ASCII that says float": ply((rows(FAR) + ascii_faces(FACES)).encode(), real="float"),
    "ply, textures": ply(
        (rows(FAR).replace("\n", " 0.5 0.5\n") + ascii_faces(FACES)).encode(),
    ).replace(b"element face", b"property float s\nproperty float t\nelement face"),
    "ply, empty lines": ply((rows(FAR) + "\n" + ascii_faces(FACES) + "\n").encode()),
    "ply, Windows line ends": ply((rows(FAR) + ascii_faces(FACES)).encode()).replace(b"\n", b"\r\n"),
    "ply, binary, little end first": ply(
        FAR.astype("<f8").tobytes() + binary_faces(FACES), form="binary_little_endian"
    ),
    "ply, binary, big end first": ply(
        FAR.astype(">f8").tobytes() + binary_faces(FACES, ">"), form="binary_big_endian"
    ),
    "ply, binary, quads": ply(
        FAR.astype("<f8").tobytes() + binary_faces(QUAD), form="binary_little_endian", faces=1
    ),
}


@pytest.mark.parametrize("dialect", SAME)
def test_every_dialect_gives_the_same_surface_to_the_bit(tmp_path: Path, dialect: str) -> None:
    (item,) = read_meshes(stored(tmp_path, SAME[dialect]))
    assert np.array_equal(item.surface.vertices, FAR)
    # trimesh cuts a quad of a PLY into its second triangle from another corner
    turned = [tuple(np.roll(t, -int(np.argmin(t)))) for t in item.surface.triangles]
    assert turned == [(0, 1, 2), (0, 2, 3)]
    assert (item.surface.name, item.named, item.z) == ("file", False, None)
    assert item.surface.file == tmp_path / "file"
    assert len(item.surface.lines) == (2 if dialect.startswith("obj") else 0)


@pytest.mark.parametrize("binary", [True, False])
def test_vtp_keeps_doubles_order_and_polygons(tmp_path: Path, binary: bool) -> None:
    pentagon = np.array([[0, 0, 0], [2, 0, 0], [3, 1, 1], [1, 2, 2], [-1, 1, 1], [9, 9, 9]]) + FAR[0]
    mesh = pyvista.PolyData(pentagon, [5, 0, 1, 2, 3, 4, 3, 0, 2, 1, 4, 4, 3, 2, 1])
    mesh.save(tmp_path / "m.vtp", binary=binary)
    (item,) = read_meshes((tmp_path / "m.vtp").rename(tmp_path / "renamed"))
    assert np.array_equal(item.surface.vertices, pentagon)
    expected = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 2, 1], [4, 3, 2], [4, 2, 1]]
    assert item.surface.triangles.tolist() == expected
    assert not item.named


def test_polygons_of_many_corners_are_fans(tmp_path: Path) -> None:
    faces = [[0, 1, 2, 3, 4], [0, 1, 2], [3, 2, 1, 0]]
    fans = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 1, 2), (1, 3, 2), (0, 3, 1)]
    as_obj = V + "".join(f"f {' '.join(str(k + 1) for k in f)}\n" for f in faces)
    for content in (as_obj, ply((rows(FAR) + ascii_faces(faces)).encode(), faces=3)):
        (item,) = read_meshes(stored(tmp_path, content))
        turned = sorted(tuple(np.roll(t, -int(np.argmin(t))).tolist()) for t in item.surface.triangles)
        assert turned == sorted(fans)
        assert np.array_equal(item.surface.vertices, FAR)


def test_every_bit_of_a_double_survives(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    points = rng.normal(size=(3000, 3)) * [1e3, 1e3, 1e-7] + [5e5, 4.5e6, 0]
    faces = rng.permutation(3000).reshape(-1, 3)
    obj = rows(points, "v ") + "".join(f"f {a} {b} {c}\n" for a, b, c in (faces + 1).tolist())
    text = ply((rows(points) + ascii_faces(faces.tolist())).encode(), vertices=3000, faces=1000)
    pyvista.PolyData.from_regular_faces(points, faces).save(tmp_path / "vtp.vtp")
    for path in (stored(tmp_path, obj, "obj"), stored(tmp_path, text, "ply"), tmp_path / "vtp.vtp"):
        (item,) = read_meshes(path)
        assert np.array_equal(item.surface.vertices, points)
        assert np.array_equal(item.surface.triangles, faces)


def test_an_stl_is_merged_where_equal_to_the_bit_and_only_there(tmp_path: Path) -> None:
    points = FAR[:4].astype(np.float32).astype(float)
    points[3] = np.nextafter(points[0].astype(np.float32), np.float32(np.inf)).astype(float)
    mesh = trimesh.Trimesh(points, [[2, 1, 0], [0, 3, 2]], process=False)
    exported = stored(tmp_path, mesh.export(file_type="stl"), "binary")
    as_text = stored(tmp_path, solid("", points, [[2, 1, 0], [0, 3, 2]]), "text")
    for path in (exported, as_text):
        (item,) = read_meshes(path)
        assert kind_of(path) is Kind.STL and not item.named
        # in the order of their first corners
        assert np.array_equal(item.surface.vertices, points[[2, 1, 0, 3]])
        assert item.surface.triangles.tolist() == [[0, 1, 2], [2, 3, 0]]


def test_zero_has_no_sign_in_an_stl(tmp_path: Path) -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, 0, 0], [1, 1, 1]])
    (item,) = read_meshes(stored(tmp_path, solid("A", points, [[0, 1, 2], [3, 1, 4]])))
    assert item.surface.triangles.tolist() == [[0, 1, 2], [0, 1, 3]]


def test_a_binary_stl_loses_what_float32_loses_and_an_ascii_one_nothing(tmp_path: Path) -> None:
    text = stored(tmp_path, solid("A", FAR, FACES), "text")
    assert np.array_equal(read_meshes(text)[0].surface.vertices, FAR[:4])
    binary = stored(
        tmp_path, trimesh.Trimesh(FAR[:4], FACES, process=False).export(file_type="stl"), "binary"
    )
    vertices = read_meshes(binary)[0].surface.vertices
    assert np.array_equal(vertices, FAR[:4].astype(np.float32))
    assert np.abs(vertices - FAR[:4]).max() <= 0.25


def test_values_that_are_not_finite_are_kept_for_the_checks(tmp_path: Path) -> None:
    points = FAR[:4].copy()
    points[1, 2], points[3, 0] = np.nan, -np.inf
    mesh = pyvista.PolyData.from_regular_faces(points, FACES)
    mesh.save(tmp_path / "m.vtp")
    contents = [
        rows(points, "v ") + TWO,
        ply((rows(points) + ascii_faces(FACES)).encode(), vertices=4),
        ply(points.tobytes() + binary_faces(FACES), form="binary_little_endian", vertices=4),
        solid("A", points, FACES),
        (tmp_path / "m.vtp").read_bytes(),
    ]
    for content in contents:
        (item,) = read_meshes(stored(tmp_path, content))
        assert np.array_equal(item.surface.vertices, points, equal_nan=True)


def test_objects_are_surfaces_with_the_vertices_that_they_use(tmp_path: Path) -> None:
    text = "o Main fault #1\n" + rows(FAR[:3], "v ") + "g ignored\nusemtl a\nf 1 2 3\nusemtl b\nf 3 2 1\n"
    text += "o Camera\no Störung\n" + rows(FAR[3:], "v ") + "f -1 -2 1\n"
    first, second = read_meshes(stored(tmp_path, text))
    assert [s.surface.name for s in (first, second)] == ["Main fault #1", "Störung"]
    assert first.named and second.named
    assert np.array_equal(first.surface.vertices, FAR[:3])
    assert first.surface.triangles.tolist() == [[0, 1, 2], [2, 1, 0]]
    assert np.array_equal(second.surface.vertices, FAR[[0, 3, 4]])
    assert second.surface.triangles.tolist() == [[2, 1, 0]]


def test_groups_are_surfaces_where_there_is_no_object(tmp_path: Path) -> None:
    text = V + "g B\nf 1 2 3\ng A 2\nf 1 3 4\ng B\nf 1 4 5\n"
    items = read_meshes(stored(tmp_path, text))
    assert [(i.surface.name, len(i.surface.triangles)) for i in items] == [("B", 2), ("A 2", 1)]
    assert np.array_equal(items[0].surface.vertices, FAR)


def test_solids_are_surfaces_whatever_they_are_called(tmp_path: Path) -> None:
    names = ["normal fault vertex 1", "endsolid facet", "solid"]
    text = "".join(solid(name, FAR + k, FACES) for k, name in enumerate(names))
    items = read_meshes(stored(tmp_path, text))
    assert [i.surface.name for i in items] == names
    assert all(np.array_equal(i.surface.vertices, FAR[:4] + k) for k, i in enumerate(items))


def test_unnamed_faces_beside_objects_are_an_unnamed_surface(tmp_path: Path) -> None:
    first, second = read_meshes(stored(tmp_path, V + "f 1 2 3\no A\nf 1 3 4\n"))
    assert (first.named, first.surface.name) == (False, "file")
    assert (second.named, second.surface.name) == (True, "A")


def vtp(folder: Path, *changes: tuple[str, str]) -> bytes:
    """An ASCII VTP of the two triangles in which texts are replaced, each where it comes last."""
    pyvista.PolyData.from_regular_faces(FAR, FACES).save(folder / "sound.vtp", binary=False)
    text = (folder / "sound.vtp").read_text()
    for old, new in changes:
        assert old in text
        text = new.join(text.rsplit(old, 1))
    return text.encode()


def binary_stl(count: int, there: int) -> bytes:
    return bytes(80) + struct.pack("<I", count) + bytes(50 * there)


LITTLE = "binary_little_endian"
SOUND_PLY = ply((rows(FAR) + ascii_faces(FACES)).encode())
BINARY_PLY = ply(FAR.tobytes() + binary_faces(FACES), form=LITTLE)
#: Name, content and words of the complaint.
BROKEN: dict[str, tuple[str, bytes | str, str]] = {
    "empty": ("f.obj", "", "is empty"),
    "blank": ("f.stl", " \n", "is empty"),
    "obj without faces": ("f.obj", V, "no face"),
    "obj of comments": ("f.obj", "# nothing\n", "no face"),
    "obj, index beyond": ("f.obj", V + "f 1 2 3\nf 1 2 6\n", "line 7: a face names vertex 6 of 5"),
    "obj, index 0": ("f.obj", V + "f 0 1 2\n", "line 6: a face has a vertex before the first"),
    "obj, negative index beyond": ("f.obj", V + "f -6 1 2\n", "line 6: a face has a vertex before the first"),
    "obj, two corners": ("f.obj", V + "f 1 2\n", "line 6: a face has fewer than three"),
    "obj, a word for an index": ("f.obj", V + "f 1 2 x\n", "line 6"),
    "obj, a word for a number": ("f.obj", V + "v 1 2 x\n" + TWO, "line 6: a vertex holds '1 2 x'"),
    "obj, a number missing": ("f.obj", "v 1 2\n" + V + TWO, "line 1: a vertex has 2 numbers"),
    "obj, commas": ("f.obj", V.replace(".", ",") + TWO, "line 1: a vertex holds"),
    "ply without faces": ("f.ply", ply(rows(FAR).encode(), faces=0), "no face"),
    "ply without anything": ("f.ply", ply(b"", vertices=0, faces=0), "no face"),
    "ply cut in the header": ("f.ply", SOUND_PLY[:100], "end_header"),
    "ply cut between rows": ("f.ply", SOUND_PLY[:-8], "cut short"),
    "ply cut in a row": ("f.ply", SOUND_PLY[:-3], "cut short"),
    "ply cut in the vertices": ("f.ply", SOUND_PLY[:300], "cut short"),
    "ply, a quad that lacks a corner": (
        "f.ply",
        ply((rows(FAR) + "3 0 1 2\n4 0 1 2\n").encode()),
        "cut short",
    ),
    "ply, index beyond": ("f.ply", ply((rows(FAR) + "3 0 1 2\n3 0 1 5\n").encode()), "the vertex 5"),
    "ply, negative index": ("f.ply", ply((rows(FAR) + "3 0 1 2\n3 0 1 -1\n").encode()), "the vertex -1"),
    "ply, two corners": ("f.ply", ply((rows(FAR) + "2 0 1\n3 0 1 2\n").encode()), "fewer than three"),
    "ply, a word": ("f.ply", SOUND_PLY.replace(b"3 0 1", b"3 x 1"), "damaged"),
    "ply, binary, cut": ("f.ply", BINARY_PLY[:-1], "cut short or damaged, or its"),
    "ply, binary, index beyond": (
        "f.ply",
        ply(FAR.tobytes() + binary_faces([[0, 1, 9], [0, 1, 2]]), form=LITTLE),
        "the vertex 9",
    ),
    "ply, binary, mixed": (
        "f.ply",
        ply(FAR.tobytes() + binary_faces([[0, 1, 2], [0, 1, 2, 3]]), form=LITTLE),
        "number of corners",
    ),
    "ply, binary, mixed, of the right length": (
        "f.ply",
        ply(FAR.tobytes() + binary_faces([[0, 1, 2, 3], [0, 1, 2, 3, 4], [0, 2, 3]]), form=LITTLE, faces=3),
        "number of corners",
    ),
    "ply of a huge count": ("f.ply", ply(b"", form=LITTLE, vertices=2**40), "cut short or damaged"),
    "stl cut short": ("f.stl", binary_stl(5, 2), "states 5 triangles but has room for 2"),
    "stl without triangles": ("f.stl", binary_stl(0, 0), "no face"),
    "stl, shorter than its head": ("f.stl", bytes(30), "STL is damaged"),
    "stl as text, cut": ("f.stl", solid("A", FAR, FACES)[:-12], "endsolid"),
    "stl as text, second cut": ("f.stl", solid("A", FAR, FACES) + solid("B", FAR, FACES)[:90], "endsolid"),
    "stl as text, a number missing": (
        "f.stl",
        solid("A", FAR, FACES).replace(" -1000.1", ""),
        "three vertices|damaged",
    ),
    "stl as text, a vertex missing": (
        "f.stl",
        solid("A", FAR, [*FACES, [0, 1]]),
        "three vertices|damaged",
    ),
    "stl as text, facets of four": ("f.stl", solid("A", FAR, QUAD * 3), "three vertices|damaged"),
    "stl as text without facets": ("f.stl", "solid A\nendsolid A\n", "no face"),
    "noise called obj": ("f.obj", np.random.default_rng(0).bytes(5000), "not a text file"),
    "noise called ply": ("f.ply", np.random.default_rng(1).bytes(5000), "end_header"),
    "noise called stl": ("f.stl", np.random.default_rng(2).bytes(5000), "STL is damaged"),
    "noise called vtp": ("f.vtp", np.random.default_rng(3).bytes(5000), "damaged"),
    "a picture of the grid kind": (
        "f.vtp",
        '<?xml version="1.0"?><VTKFile type="ImageData" version="0.1"><ImageData/></VTKFile>',
        "damaged",
    ),
}


@pytest.mark.parametrize("case", BROKEN)
def test_what_cannot_be_read_is_one_sentence(tmp_path: Path, case: str) -> None:
    name, content, words = BROKEN[case]
    assert_refused(stored(tmp_path, content, name), words)


VTP_CHANGES: dict[str, tuple[tuple[tuple[str, str], ...], str]] = {
    "index beyond": ((("0 1 2 0 2 3", "0 1 2 0 2 9"),), "the vertex 9"),
    "index before": ((("0 1 2 0 2 3", "0 1 2 0 2 -1"),), "the vertex -1"),
    "offsets that fall": ((("3 6", "6 3"),), "damaged"),
    "two corners": ((("3 6", "2 6"),), "fewer than three"),
    "no polygon": ((('NumberOfPolys="2"', 'NumberOfPolys="0"'),), "no face"),
    "a huge count": ((('NumberOfPoints="5"', 'NumberOfPoints="99999999999"'),), "99999999999 elements"),
    "a word": ((("4500050.5", "x"),), "damaged"),
}


@pytest.mark.parametrize("case", VTP_CHANGES)
def test_what_vtk_cannot_read_is_one_sentence(
    tmp_path: Path, case: str, capfd: pytest.CaptureFixture[str]
) -> None:
    changes, words = VTP_CHANGES[case]
    assert_refused(stored(tmp_path, vtp(tmp_path, *changes), "f.vtp"), words)
    # VTK keeps to itself what it would say on the terminal
    assert capfd.readouterr() == ("", "")


def test_an_stl_that_has_words_for_normals_is_read_without_a_word(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    read_meshes(stored(tmp_path, solid("A", FAR, FACES).replace("normal 0 0 0", "normal up"), "f.stl"))
    assert capfd.readouterr() == ("", "")


def test_strips_are_refused_by_name(tmp_path: Path) -> None:
    strips = pyvista.PolyData(FAR)
    strips.strips = [4, 0, 1, 3, 2]
    strips.save(tmp_path / "f.vtp")
    assert_refused(tmp_path / "f.vtp", "triangle strips")


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9, 0.99])
def test_a_vtp_that_is_cut_is_one_sentence(tmp_path: Path, share: float) -> None:
    text = vtp(tmp_path)
    assert_refused(stored(tmp_path, text[: int(share * len(text))], "f.vtp"), "damaged")


def assert_refused(path: Path, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        read_meshes(path)
    message = str(caught.value)
    assert message.startswith(str(path)) and message.endswith(".") and "\n" not in message
    assert "Error" not in message


def test_what_is_no_mesh_stays_what_it_is(tmp_path: Path) -> None:
    write_tsurf(tmp_path / "tsurf.obj", [F60])
    stored(tmp_path, "1 2 3\n4 5 6\n999 999 999\n", "sticks.stl")
    stored(tmp_path, "# a comment\nX,Y,Z\n1,2,3\n", "points.csv")
    stored(tmp_path, "-996 5 50 50\n0 200 0 200\n", "grid.ply")
    kinds = {"tsurf.obj": Kind.TSURF, "sticks.stl": Kind.STICKS, "points.csv": Kind.TABLE}
    assert {p.name: kind_of(p) for p in tmp_path.iterdir()} == {**kinds, "grid.ply": Kind.IRAP_ASCII}
    with pytest.raises(InputError, match="no OBJ, PLY, STL or VTP"):
        read_meshes(tmp_path / "points.csv")


def model_of(folder: Path, content: bytes | str, keys: str = "", head: str = HEAD) -> Path:
    stored(folder, content, "mesh")
    return stored(folder, f'{head}[[faults]]\nfile = "mesh"\n{keys}', "model.toml")


def faults(folder: Path, content: bytes | str, keys: str, head: str = HEAD) -> dict[str, np.ndarray]:
    return {f.name: f.surface.vertices for f in read_model(model_of(folder, content, keys, head)).faults}


OBJECTS = V + "o A\nf 1 2 3\no B\nf 1 3 4\n"


def test_a_file_with_objects_gives_them_all_or_the_one_named(tmp_path: Path) -> None:
    up = FAR * [1, 1, -1]
    both = faults(tmp_path, OBJECTS, "")
    assert list(both) == ["A", "B"]
    assert np.array_equal(both["A"], up[:3]) and np.array_equal(both["B"], up[[0, 2, 3]])
    (one,) = faults(tmp_path, OBJECTS, 'name = "B"\n').items()
    assert one[0] == "B" and np.array_equal(one[1], up[[0, 2, 3]])
    (one,) = faults(tmp_path, V + "o A\n" + TWO, 'name = "Z"\n', HEAD.replace("depth", "elevation")).items()
    assert one[0] == "Z" and np.array_equal(one[1], FAR)


@pytest.mark.parametrize(
    ("content", "keys", "words"),
    [
        (OBJECTS, 'name = "C"\n', "'A', 'B'"),
        (V + TWO, "", "without a name"),
        (solid("", FAR, FACES), "", "without a name"),
        (V + "f 1 2 3\no A\nf 1 3 4\n", "", "without a name"),
        (OBJECTS.replace("o B", "o A"), "", "'A' is there twice"),
    ],
)
def test_names_follow_the_rules_of_all_faults(tmp_path: Path, content: str, keys: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        faults(tmp_path, content, keys)


def test_a_mesh_makes_no_horizon(tmp_path: Path) -> None:
    for content in (V + TWO, BINARY_PLY, binary_stl(1, 1), vtp(tmp_path)):
        stored(tmp_path, content, "mesh")
        stored(tmp_path, HEAD + '[[horizons]]\nname = "H"\nfile = "mesh"\n', "model.toml")
        with pytest.raises(InputError, match="faults alone"):
            read_model(tmp_path / "model.toml")


def fault_files(folder: Path, surface: Surface) -> dict[str, Path]:
    """A fault as a file of each format, z as it stands."""
    mesh = trimesh.Trimesh(surface.vertices, surface.triangles, process=False)
    paths = {suffix: folder / f"fault.{suffix}" for suffix in ("obj", "ply", "stl", "vtp")}
    for suffix in ("obj", "ply", "stl"):
        mesh.export(paths[suffix])
    surface.to_pyvista().save(paths["vtp"])
    return paths


def test_a_fault_gets_the_same_verdict_in_every_format(tmp_path: Path) -> None:
    whole = F60.with_vertices(np.round(F60.vertices))
    verdicts = []
    for suffix, path in fault_files(tmp_path, whole).items():
        stored(tmp_path, f'[model]\nname = "M"\n[[faults]]\nname = "F"\nfile = "{path.name}"\n', "model.toml")
        model = read_model(tmp_path / "model.toml")
        surface = model.faults[0].surface
        assert np.array_equal(surface.vertices[surface.triangles], whole.vertices[whole.triangles]), suffix
        verdicts.append([(f.check, f.status, f.count) for f in check(model).findings])
    assert verdicts[0] and all(v == verdicts[0] for v in verdicts)


def test_check_repair_and_run_take_such_files(tmp_path: Path) -> None:
    """One format stands for all: what they read is the same, and nothing after that asks for the format."""
    suffix = "obj"
    inner = ~np.isin(F60.triangles, boundary_edges(F60.triangles)).any(axis=1)
    holed = Surface("F", np.round(F60.vertices), np.delete(F60.triangles, np.flatnonzero(inner)[0], axis=0))
    path = fault_files(tmp_path, holed)[suffix]
    keys = f'[[faults]]\nname = "F"\nfile = "{path.name}"\n[repair]\nmax_move = 50.0\n'
    model = stored(tmp_path, f'[model]\nname = "M"\n{keys}', "model.toml")
    for command in ("check", "repair", "run"):
        out = [] if command == "check" else ["-o", tmp_path / command]
        done = graben(command, model, *out)
        assert (done.returncode, done.stderr) == (0, ""), command
    (repaired,) = read_model(tmp_path / "repair" / "model.toml").faults
    assert repaired.surface.file == tmp_path / "repair" / "F.ts"
    assert len(repaired.surface.triangles) == len(F60.triangles)
    (kept,) = read_model(tmp_path / "run" / "model" / "model.toml").faults
    assert np.array_equal(kept.surface.vertices, repaired.surface.vertices)


@pytest.mark.parametrize(
    ("suffix", "command"), [("obj", "check"), ("ply", "repair"), ("stl", "run"), ("vtp", "check")]
)
def test_a_damaged_file_ends_with_2_and_one_sentence(
    tmp_path: Path, suffix: str, command: str, capfd: pytest.CaptureFixture[str]
) -> None:
    from graben.cli import main

    path = fault_files(tmp_path, F60)[suffix]
    # an OBJ loses a vertex, the others their end
    content = path.read_bytes()
    path.write_bytes(content.replace(b"v ", b"# ", 1) if suffix == "obj" else content[:-10])
    model = stored(tmp_path, f'{HEAD}[[faults]]\nname = "F"\nfile = "{path.name}"\n', "model.toml")
    with pytest.raises(SystemExit) as caught:
        main([command, str(model), *([] if command == "check" else ["-o", str(tmp_path / "out")])])
    assert caught.value.code == 2
    out, err = capfd.readouterr()
    assert out == "" and err.startswith(f"graben: {path}") and err.count("\n") == 1
    assert not (tmp_path / "out").exists()
