"""RESQML packages, read back by resqpy and by fesapi, another implementation of the standard."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from uuid import UUID

import numpy as np
import pytest

from graben.arrays import FloatArray, floats
from graben.formats import resqml
from graben.formats.resqml import GriddedHorizon, obstacle, write_epc
from graben.model import Fault, GridGeometry
from graben.reports.json_report import run_report
from graben.reports.model_files import write_model_files
from graben.reports.writing import write_run
from graben.surface import Surface
from tests.reports import sample

resqpy_model = pytest.importorskip("resqpy.model")

CENTRE = np.array([465_123.0, 5_932_456.0, -2000.0])
GRID = GridGeometry(7, 5, 100.0, 37.5, (465_000.125, 5_932_000.25), 31.7)
LONG = "Ä" * 300
NAMES = [
    "<script>alert(\"F1\")</script> & 'x'",
    "Top/A\\B: *?|",
    "🎉 Эльбрус 層",
    "]]> &amp; <!-- x -->",
    "a  line\nand\ta tab\x01",
    "untitled",
    LONG,
]


@dataclass(frozen=True)
class Lips:
    fault: str
    hanging: FloatArray
    foot: FloatArray


def surface(name: str, seed: int = 0) -> Surface:
    """A wavy sheet of 6 x 5 nodes with full digits."""
    x, y = np.meshgrid(np.arange(6.0), np.arange(5.0), indexing="ij")
    z = np.sin(x + 2 * y + seed)
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3) * [100.1, 99.9, 30.3] + CENTRE + np.pi * seed
    return Surface(name, points, sample.grid_triangles(6, 5))


def horizon(name: str = "Top A", fault: str = "F1") -> GriddedHorizon:
    top = surface(name, 7)
    values = np.random.default_rng(1).normal(-2000.0, 10.0, (GRID.columns, GRID.rows))
    values[2, 3] = np.nan
    hanging, foot = floats(top.vertices[:4]), floats(top.vertices[:4] + np.array([1 / 3, 0, 2 / 3]))
    return GriddedHorizon(
        top, GRID, floats(values), [Lips(fault, hanging, foot), Lips(fault, foot[:2], foot[:2])]
    )


def write(path: Path, **options: Any) -> Path:
    write_epc(path, [horizon()], [surface("F1"), surface("F2", 1)], origin=CENTRE, **options)
    return path


class Back:
    """A package as resqpy reads it."""

    def __init__(self, path: Path) -> None:
        from resqpy.crs import Crs

        self.model = resqpy_model.Model(str(path))
        (code,) = self.model.uuids(obj_type="LocalDepth3dCrs")
        self.crs = Crs(self.model, uuid=code)

    def all(self, kind: str, made: Callable[..., Any]) -> list[Any]:
        return [made(self.model, uuid=uuid) for uuid in self.model.uuids(obj_type=kind)]

    def points(self, local: np.ndarray) -> np.ndarray:
        """Global places, z counted as the package does."""
        found = np.array(local, dtype=float).reshape(-1, 3)
        self.crs.local_to_global_array(found, global_z_inc_down=self.crs.z_inc_down)
        return found.reshape(np.shape(local))

    def surfaces(self) -> dict[str, Any]:
        from resqpy.surface import Surface as TriangulatedSet

        return {s.title: s for s in self.all("TriangulatedSetRepresentation", TriangulatedSet)}

    def grids(self) -> list[Any]:
        from resqpy.surface import Mesh

        return self.all("Grid2dRepresentation", Mesh)

    def lines(self) -> dict[str, Any]:
        from resqpy.lines import PolylineSet

        return {s.title: s for s in self.all("PolylineSetRepresentation", PolylineSet)}

    def interpretation(self, representation: Any) -> str:
        node = representation.root.find("{*}RepresentedInterpretation")
        part = self.model.part(uuid=node.findtext("{*}UUID"))
        return f"{self.model.type_of_part(part, strip_obj=True)} {self.model.citation_title_for_part(part)}"


@pytest.mark.parametrize(("z", "sign"), [("elevation", 1.0), ("depth", -1.0)])
def test_geometry_reads_back_in_the_convention_of_the_model(tmp_path: Path, z: str, sign: float) -> None:
    back = Back(write(tmp_path / "a.epc", z=z))
    assert back.crs.z_inc_down == (z == "depth")
    assert set(back.surfaces()) == {"F1", "F2", "Top A"}
    for wanted in (surface("F1"), surface("F2", 1), horizon().surface):
        found = back.surfaces()[wanted.name]
        triangles, local = found.triangles_and_points()
        assert np.abs(local[:, :2]).max() < 1000  # so that 32 bits would do
        np.testing.assert_allclose(back.points(local) * [1, 1, sign], wanted.vertices, rtol=0, atol=1e-9)
        assert np.array_equal(triangles, wanted.triangles)
    (grid,) = back.grids()
    nodes = back.points(np.swapaxes(grid.full_array_ref(), 0, 1))
    np.testing.assert_allclose(nodes[..., :2], GRID.nodes(), rtol=0, atol=1e-6)
    assert np.array_equal(nodes[..., 2] * sign, horizon().values, equal_nan=True)
    lines = back.lines()
    for title, wanted_lines in (
        ("hanging wall cutoff, F1, Top A", [c.hanging for c in horizon().cutoffs]),
        ("footwall cutoff, F1, Top A", [c.foot for c in horizon().cutoffs]),
    ):
        assert [len(p.coordinates) for p in lines[title].polys] == [4, 2]
        for polyline, points in zip(lines[title].polys, wanted_lines, strict=True):
            places = back.points(polyline.coordinates) * [1, 1, sign]
            np.testing.assert_allclose(places, points, rtol=0, atol=1e-9)


def test_what_is_what(tmp_path: Path) -> None:
    from resqpy.organize import (
        FaultInterpretation,
        GeneticBoundaryFeature,
        HorizonInterpretation,
        TectonicBoundaryFeature,
    )

    back = Back(write(tmp_path / "a.epc"))
    surfaces = back.surfaces()
    assert back.interpretation(surfaces["F1"]) == "FaultInterpretation F1"
    for of_horizon in (surfaces["Top A"], back.grids()[0], *back.lines().values()):
        assert back.interpretation(of_horizon) == "HorizonInterpretation Top A"
    features = back.all("TectonicBoundaryFeature", TectonicBoundaryFeature)
    assert [(f.feature_name, f.kind) for f in features] == [("F1", "fault"), ("F2", "fault")]
    (feature,) = back.all("GeneticBoundaryFeature", GeneticBoundaryFeature)
    assert (feature.feature_name, feature.kind) == ("Top A", "horizon")
    (top,) = back.all("HorizonInterpretation", HorizonInterpretation)
    assert top.domain == "depth" and str(top.genetic_boundary_feature.uuid) == str(feature.uuid)
    faults = back.all("FaultInterpretation", FaultInterpretation)
    assert [f.feature_uuid for f in faults] == [f.uuid for f in features]


@pytest.mark.parametrize(
    ("crs", "unit", "code", "title"),
    [
        ("EPSG:23031", "m", "23031", "EPSG:23031"),
        (" epsg::32066", "ft", "32066", "epsg::32066"),
        ('ED50 <UTM> & "31"', "ft", None, 'ED50 <UTM> & "31"'),
        (None, "m", None, "local frame"),
    ],
)
def test_coordinate_system(tmp_path: Path, crs: str | None, unit: str, code: str | None, title: str) -> None:
    found = Back(write(tmp_path / "a.epc", crs=crs, unit=unit)).crs
    assert (found.xy_units, found.z_units, found.epsg_code, found.title) == (unit, unit, code, title)
    assert (found.x_offset, found.y_offset, found.z_offset) == (*CENTRE[:2], 0.0)
    # A code of a plane system says nothing of heights.
    assert found.root.findtext("{*}VerticalCrs/{*}Unknown") == "Unknown"
    if crs and not code:
        assert found.root.findtext("{*}ProjectedCrs/{*}Unknown") == title


@pytest.mark.parametrize("name", NAMES)
def test_names_read_back(tmp_path: Path, name: str) -> None:
    write_epc(tmp_path / "a.epc", [horizon("H", name)], [surface(name)], origin=CENTRE)
    back = Back(tmp_path / "a.epc")
    printable = " ".join(name.replace("\x01", " ").split())
    titles = back.surfaces()
    assert set(titles) == {"H", printable[:256]}
    found = titles[printable[:256]]
    assert found.extra_metadata == ({} if printable[:256] == name else {"name": printable})
    assert back.interpretation(found) == f"FaultInterpretation {printable[:256]}"
    assert all(len(t) <= 256 for t in back.model.titles())
    for line, side in zip(back.lines().values(), ("hanging wall", "footwall"), strict=True):
        whole = f"{side} cutoff, {printable}, H"
        assert line.extra_metadata.get("name", line.title) == whole


def test_the_same_input_gives_the_same_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import resqpy.olio.time

    files = []
    for k, name in enumerate(("a", "other folder/b")):
        path = tmp_path / name / "model.epc"
        path.parent.mkdir(parents=True)
        monkeypatch.setattr(resqpy.olio.time, "now", lambda k=k: f"200{k}-01-01T00:00:00Z")
        monkeypatch.setenv("LOGNAME", f"user {k}")
        files.append(write(path))
    for suffix in (".epc", ".h5"):
        first, second = (file.with_suffix(suffix).read_bytes() for file in files)
        assert first == second
    with zipfile.ZipFile(files[0]) as package:
        assert {info.date_time for info in package.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        text = b"".join(package.read(name) for name in package.namelist())
    assert b"200" not in re.sub(rb'"http[^"]*"', b"", text) and b"user" not in text


def test_identifiers_follow_from_names_and_content(tmp_path: Path) -> None:
    def identifiers(**options: Any) -> set[UUID]:
        return set(resqpy_model.Model(str(write(tmp_path / "a.epc", **options))).uuids())

    first = identifiers()
    assert all(uuid.version == 5 for uuid in first)
    assert first == identifiers()
    # What is counted otherwise is another thing, and so are the arrays.
    for options in ({"z": "depth"}, {"unit": "ft"}, {"crs": "EPSG:23031"}):
        assert not first & identifiers(**options)
    write_epc(tmp_path / "b.epc", [], [surface("F1"), surface("F3", 1)], origin=CENTRE)
    shared = first & set(resqpy_model.Model(str(tmp_path / "b.epc")).uuids())
    assert len(shared) == 4  # the frame, and F1: feature, interpretation, triangles


def test_why_there_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    assert obstacle("m") is None and obstacle("ft") is None
    assert "without a unit" in str(obstacle("none"))
    hide(monkeypatch, ModuleNotFoundError("No module named 'resqpy'", name="resqpy"))
    assert obstacle("m") == "RESQML needs resqpy, which is not here: pip install 'graben[resqml]'."
    hide(monkeypatch, ImportError("Numba needs NumPy 1.0 or less"))
    assert "cannot be loaded (Numba needs NumPy 1.0 or less)" in str(obstacle("m"))


def hide(monkeypatch: pytest.MonkeyPatch, error: ImportError) -> None:
    def missing(name: str) -> None:
        raise error

    monkeypatch.setattr(resqml, "import_module", missing)


def test_a_run_without_resqpy_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hide(monkeypatch, ModuleNotFoundError("No module named 'resqpy'", name="resqpy"))
    result = sample.run_result()
    write_run(replace(result, horizons=()), tmp_path)
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert report["not_written"] == {"resqml": obstacle("m")}
    assert report["files"] == {"model": "model/model.toml", "faults": "model/faults.vtu"}
    assert "pip install &#39;graben[resqml]&#39;" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert not list(tmp_path.glob("*.epc")) and not list(tmp_path.glob("*.h5"))


def test_the_files_of_a_run(tmp_path: Path) -> None:
    result = sample.run_result(depth=True)
    values = floats(np.full((61, 61), -2000.0))
    (tmp_path / "model").mkdir()
    made = write_model_files(result, tmp_path, {"Top A": values})
    assert made.not_written == {}
    assert {what: (tmp_path / path).is_file() for what, path in made.files.items()} == {
        "model": False,  # written before
        "faults": True,
        "resqml": True,
        "resqml_arrays": True,
    }
    assert run_report(result, {}, made)["files"] == made.files
    back = Back(tmp_path / "model.epc")
    assert back.crs.z_inc_down and back.crs.xy_units == "m"
    assert set(back.surfaces()) == {"F1", "Top A", "Top B"}
    assert [g.title for g in back.grids()] == ["Top A"]
    assert set(back.lines()) == {"hanging wall cutoff, F1, Top A", "footwall cutoff, F1, Top A"}


def test_unfit_faults_do_not_stop_a_run(tmp_path: Path) -> None:
    (tmp_path / "model").mkdir()
    good = surface("good")
    bad = good.vertices.copy()
    bad[3] = np.nan
    faults = [
        good,
        Surface("wild", good.vertices, [[0, 1, 2], [0, 1, 99], [-1, 2, 3]]),
        Surface("undefined", bad, good.triangles),
        Surface("no triangle", good.vertices, np.zeros((0, 3))),
        Surface("nothing", np.zeros((0, 3)), np.zeros((0, 3))),
    ]
    result = sample.run_result()
    model = replace(result.repaired, faults=tuple(Fault(f) for f in faults), horizons=())
    write_model_files(replace(result, repaired=model, horizons=()), tmp_path, {})
    back = Back(tmp_path / "model.epc").surfaces()
    assert set(back) == {"good", "wild", "undefined"}
    assert back["wild"].triangles_and_points()[0].tolist() == [[0, 1, 2]]


# fesapi has its own copy of HDF5, so it has a process of its own.
REFEREE = """
import json, sys, fesapi
repository = fesapi.DataObjectRepository()
warnings = fesapi.EpcDocument(sys.argv[1]).deserializeInto(repository)
crs = repository.getLocal3dCrs(0)
found = {
    "warnings": warnings,
    "crs": [crs.getOriginOrdinal1(), crs.getOriginOrdinal2(), crs.isDepthOriented(),
            crs.getProjectedCrsUnitAsString(), crs.getVerticalCrsUnitAsString(),
            crs.getProjectedCrsEpsgCode()],
    "surfaces": {}, "lines": {},
}
def places(item):
    count = item.getXyzPointCountOfAllPatches()
    values = fesapi.DoubleArray(3 * count)
    item.getXyzPointsOfAllPatchesInGlobalCrs(values)
    return [values.getitem(k) for k in range(3 * count)]
for k in range(repository.getAllTriangulatedSetRepresentationCount()):
    item = repository.getAllTriangulatedSetRepresentation(k)
    count = item.getTriangleCountOfAllPatches()
    corners = fesapi.UInt32Array(3 * count)
    item.getTriangleNodeIndicesOfAllPatches(corners.cast())
    found["surfaces"][item.getTitle()] = [
        item.getInterpretation().getXmlTag(), places(item), [corners.getitem(k) for k in range(3 * count)]]
for k in range(repository.getHorizonPolylineSetRepresentationCount()):
    item = repository.getHorizonPolylineSetRepresentation(k)
    found["lines"][item.getTitle()] = [item.getPolylineCountOfAllPatches(), places(item)]
grid = repository.getHorizonGrid2dRepresentation(0)
count = grid.getXyzPointCountOfAllPatches()
z = fesapi.DoubleArray(count)
grid.getZValuesInGlobalCrs(z)
found["grid"] = [
    [grid.getNodeCountAlongIAxis(), grid.getNodeCountAlongJAxis()],
    [grid.getXOriginInGlobalCrs(), grid.getYOriginInGlobalCrs()],
    [grid.getXIOffset(), grid.getYIOffset()], [grid.getXJOffset(), grid.getYJOffset()],
    [z.getitem(k) for k in range(count)]]
print(json.dumps(found))
"""


def test_fesapi_reads_the_same(tmp_path: Path) -> None:
    pytest.importorskip("fesapi")
    path = write(tmp_path / "a.epc", z="depth", unit="ft", crs="EPSG:32066")
    command = [sys.executable, "-c", REFEREE, str(path)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    found = json.loads(done.stdout.splitlines()[-1])
    assert found["warnings"] == ""
    assert found["crs"] == [*CENTRE[:2], True, "ft", "ft", 32066]
    down = np.array([1.0, 1.0, -1.0])
    for wanted in (surface("F1"), surface("F2", 1), horizon().surface):
        kind, places, corners = found["surfaces"][wanted.name]
        assert kind == ("HorizonInterpretation" if wanted.name == "Top A" else "FaultInterpretation")
        np.testing.assert_allclose(np.reshape(places, (-1, 3)), wanted.vertices * down, rtol=0, atol=1e-9)
        assert np.array_equal(np.reshape(corners, (-1, 3)), wanted.triangles)
    counts, begin, along, across, heights = found["grid"]
    assert counts == [GRID.columns, GRID.rows]
    i, j = np.meshgrid(*map(np.arange, counts), indexing="ij")
    nodes = np.array(begin) + i[..., None] * along + j[..., None] * across
    np.testing.assert_allclose(nodes, GRID.nodes(), rtol=0, atol=1e-6)
    assert np.array_equal(-np.reshape(heights, counts[::-1]).T, horizon().values, equal_nan=True)
    count, places = found["lines"]["hanging wall cutoff, F1, Top A"]
    wanted_lines = np.concatenate([c.hanging for c in horizon().cutoffs])
    np.testing.assert_allclose(np.reshape(places, (-1, 3)), wanted_lines * down, rtol=0, atol=1e-9)
    assert count == 2
