from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import pyvista
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, Polygon

from graben.arrays import FloatArray, floats
from graben.formats.geojson import write_geojson
from graben.formats.names import file_names
from graben.formats.tables import write_cutoffs
from graben.formats.vtp import write_vtp
from graben.formats.vtu import write_vtu
from graben.formats.writing import written_horizon
from graben.model import Horizon, Model
from graben.surface import Surface


@dataclass(frozen=True)
class Line:
    fault: str
    s: FloatArray
    hanging: FloatArray
    foot: FloatArray
    throw: FloatArray
    heave: FloatArray


@pytest.mark.parametrize(("z", "sign"), [("elevation", 1.0), ("depth", -1.0)])
def test_cutoffs_stand_in_pairs(tmp_path: Path, z: str, sign: float) -> None:
    hanging = floats([[1 / 3, 2, -1000.1], [4, 5, -1001]])
    foot = floats([[1, 2, -990], [4, 5, -1001]])
    line = Line("F, 1", floats([0, 1.5]), hanging, foot, floats(foot[:, 2] - hanging[:, 2]), floats([0.7, 0]))
    write_cutoffs(tmp_path / "c.csv", [line, line], z="depth" if z == "depth" else "elevation")
    with (tmp_path / "c.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0]) == ["fault", "side", "s", "x", "y", "z", "throw", "heave"]
    assert [row["side"] for row in rows] == ["hanging", "foot"] * 4
    assert {row["fault"] for row in rows} == {"F, 1"}
    for upper, lower in zip(rows[::2], rows[1::2], strict=True):
        assert all(upper[key] == lower[key] for key in ("s", "throw", "heave"))
        # throw is that of elevations in either convention
        assert float(upper["throw"]) == sign * (float(lower["z"]) - float(upper["z"]))
    assert [float(rows[0][k]) for k in "xyz"] == [1 / 3, 2, sign * -1000.1]


def test_vtp_carries_arrays_and_is_the_same_each_time(tmp_path: Path) -> None:
    surface = Surface("A", np.eye(3) / 3, [[0, 1, 2]])
    for name in ("a.vtp", "b.vtp"):
        write_vtp(tmp_path / name, surface, z="depth", arrays={"side": [0, 1, -1], "u": [0.1, 0.2, 0.3]})
    mesh = pyvista.read(tmp_path / "a.vtp")
    assert np.array_equal(mesh.points, surface.vertices * [1, 1, -1])
    assert mesh.regular_faces.tolist() == [[0, 1, 2]]
    assert mesh.point_data["side"].tolist() == [0, 1, -1] and mesh.point_data["u"].tolist() == [0.1, 0.2, 0.3]
    assert (tmp_path / "a.vtp").read_bytes() == (tmp_path / "b.vtp").read_bytes()


def test_vtk_files_say_what_they_hold(tmp_path: Path) -> None:
    surface = Surface("Störung 1", np.eye(3) / 3, [[0, 1, 2]])
    write_vtp(tmp_path / "a.vtp", surface, z="depth", unit="ft", notes={"side": "1 hanging, -1 foot"})
    write_vtu(tmp_path / "a.vtu", [surface], unit="m", crs="EPSG:23031")
    write_vtp(tmp_path / "b.vtp", surface, unit="none")
    first, second, third = (pyvista.read(tmp_path / name).field_data for name in ("a.vtp", "a.vtu", "b.vtp"))
    assert {key: first[key].tolist() for key in first} == {
        "names": ["Störung 1"],
        "z": ["depth, positive down"],
        "unit": ["ft"],
        "side": ["1 hanging, -1 foot"],
    }
    assert second["crs"].tolist() == ["EPSG:23031"] and second["z"].tolist() == ["elevation, positive up"]
    assert "unit" not in third


def test_names_that_look_like_formulas_stay_as_they_are(tmp_path: Path) -> None:
    names = ["=1+1", "+F", "-F", "@F", '"=F"', "'F"]
    zero, lips = floats([0.0]), floats([[0.0, 0.0, 0.0]])
    lines = [Line(name, zero, lips, lips, zero, zero) for name in names]
    write_cutoffs(tmp_path / "c.csv", lines)
    with (tmp_path / "c.csv").open(encoding="utf-8", newline="") as stream:
        assert [row["fault"] for row in csv.DictReader(stream)] == [n for n in names for _ in range(2)]


def test_points_are_the_shortest_numbers_that_read_back(tmp_path: Path) -> None:
    picks = np.array([[464772.1, 5933566.244, -1651.6], [1 / 3, 2.0, -1e-7]])
    surface = Surface("H", picks, np.zeros((0, 3), dtype=int))
    horizon = Horizon("H", surface, 50.0, picks=picks)
    written_horizon(Model("M", (horizon,)), horizon, tmp_path, "h")
    lines = (tmp_path / "h.csv").read_text().splitlines()
    assert lines[:2] == ["X,Y,Z", "464772.1,5933566.244,-1651.6"]
    read = [[float(word) for word in line.split(",")] for line in lines[1:]]
    assert np.array_equal(read, picks)


def test_geojson(tmp_path: Path) -> None:
    shapes = [
        (Polygon([(0, 0), (1, 0), (1 / 3, 1)]), {"fault": "Ä", "area": 0.5}),
        (LineString([(0, 0, -5), (1, 1, -7.5)]), {}),
    ]
    write_geojson(tmp_path / "a.json", shapes, z="depth", crs="EPSG:23031")
    content = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert content["type"] == "FeatureCollection"
    assert content["crs"]["properties"]["name"] == "urn:ogc:def:crs:EPSG::23031"
    first, second = content["features"]
    assert first["properties"] == {"fault": "Ä", "area": 0.5}
    assert first["geometry"]["coordinates"] == [[[0, 0], [1, 0], [1 / 3, 1], [0, 0]]]
    assert second["geometry"] == {"type": "LineString", "coordinates": [[0, 0, 5], [1, 1, 7.5]]}
    write_geojson(tmp_path / "b.json", shapes[:1])
    assert "crs" not in json.loads((tmp_path / "b.json").read_text(encoding="utf-8"))


def test_file_names() -> None:
    assert file_names(["Top A", "Top/A", "Top?A", "ü.1-b"]) == ["Top_A", "Top_A-2", "Top_A-3", "_.1-b"]
    assert file_names(["a", "a-2", "A", "a"]) == ["a", "a-2", "A-3", "a-4"]
    long = file_names(["x" * 200, "x" * 90])
    assert long == ["x" * 80, "x" * 78 + "-2"]
    # no file is hidden, none lies elsewhere
    assert file_names(["../../etc/A/B\\C", ".", "..", ".F"]) == ["___.._etc_A_B_C", "_", "__", "_F"]


@given(st.lists(st.text(min_size=1, max_size=100), max_size=12))
def test_file_names_differ_and_are_plain(names: list[str]) -> None:
    result = file_names(names)
    assert len({name.lower() for name in result}) == len(names)
    assert all(
        len(name) <= 80 and name[0] != "." and all(c.isascii() and (c.isalnum() or c in "._-") for c in name)
        for name in result
    )


@pytest.mark.parametrize(("z", "sign"), [("elevation", 1), ("depth", -1)])
def test_vtu_holds_several_surfaces_apart_and_is_the_same_each_time(
    tmp_path: Path, z: str, sign: int
) -> None:
    one = Surface("F 1", np.eye(3) / 3 + 5e5, [[0, 1, 2]])
    other = Surface("ü", np.arange(12).reshape(4, 3) / 7, [[0, 1, 2], [1, 3, 2]])
    for name in ("a.vtu", "b.vtu"):
        write_vtu(tmp_path / name, [one, other], z="depth" if z == "depth" else "elevation")
    mesh = pyvista.read(tmp_path / "a.vtu")
    assert mesh.points.dtype == np.float64
    for k, surface in enumerate((one, other)):
        part = mesh.extract_cells(mesh.cell_data["surface"] == k)
        assert mesh.field_data["names"][k] == surface.name
        assert np.array_equal(part.points * [1, 1, sign], surface.vertices)
        assert part.cells.reshape(-1, 4)[:, 1:].tolist() == surface.triangles.tolist()
    assert (tmp_path / "a.vtu").read_bytes() == (tmp_path / "b.vtu").read_bytes()
