"""The folder of a run: all files there, readable by others, the same bytes twice."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
import pyvista
import shapely
import surfio

from graben.formats.tsurf import read_tsurf
from graben.modeling.products import regular_grid
from graben.reading import read_model
from graben.reports.writing import write_run
from tests.reports import sample

NAMES = [
    "cutoffs/Top_A.csv",
    "cutoffs/Top_B.csv",
    "horizons/Top_A.irap",
    "horizons/Top_A.ts",
    "horizons/Top_A.vtp",
    "horizons/Top_B.irap",
    "horizons/Top_B.ts",
    "horizons/Top_B.vtp",
    "model/model.toml",
    "polygons/Top_A.geojson",
    "polygons/Top_B.geojson",
    "report.html",
    "report.json",
]


@pytest.fixture(scope="module", params=[False, True], ids=["elevation", "depth"])
def written(request, tmp_path_factory):
    result = sample.run_result(depth=request.param)
    folder = tmp_path_factory.mktemp("run") / "out"
    write_run(result, folder)
    return result, folder


def names_of(folder: Path) -> set[str]:
    return {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}


def test_folder_holds_what_is_promised(written):
    result, folder = written
    assert names_of(folder) >= set(NAMES)
    report = json.loads((folder / "report.json").read_text())
    for horizon in report["horizons"]:
        assert horizon["files"]
        assert all((folder / path).is_file() for path in horizon["files"].values())
    assert report["timings"]["write"] > 0
    assert report["timings"]["total"] > result.timings["total"]


def test_surfaces_read_back_in_the_models_convention(written):
    result, folder = written
    factor = result.model.z_factor
    horizon = result.horizons[0]
    mesh = pyvista.read(folder / "horizons/Top_A.vtp")
    np.testing.assert_allclose(mesh.points[:, 2], factor * horizon.surface.vertices[:, 2], atol=1e-3)
    np.testing.assert_array_equal(mesh.point_data["side"], horizon.side)
    np.testing.assert_array_equal(mesh.point_data["fixed"], horizon.fixed)
    assert "subdomain" in mesh.point_data
    (tsurf,) = read_tsurf(folder / "horizons/Top_A.ts")
    np.testing.assert_array_equal(tsurf.surface.vertices, horizon.surface.vertices)


def test_grid_is_read_by_surfio(written):
    result, folder = written
    grid = surfio.IrapSurface.from_ascii_file(folder / "horizons/Top_A.irap")
    expected = result.model.z_factor * regular_grid(result.horizons[0])
    np.testing.assert_allclose(grid.values, expected, atol=0.01, equal_nan=True)


def test_cutoffs_come_in_pairs(written):
    result, folder = written
    with (folder / "cutoffs/Top_A.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [r["side"] for r in rows] == ["hanging", "foot"] * (len(rows) // 2)
    for upper, lower in zip(rows[::2], rows[1::2], strict=True):
        assert (upper["s"], upper["throw"], upper["heave"]) == (lower["s"], lower["throw"], lower["heave"])
        step = float(lower["z"]) - float(upper["z"])
        assert float(upper["throw"]) == pytest.approx(result.model.z_factor * step, abs=1e-9)


def test_polygons_are_valid(written):
    _, folder = written
    content = json.loads((folder / "polygons/Top_A.geojson").read_text())
    shapes = [shapely.geometry.shape(f["geometry"]) for f in content["features"]]
    assert shapes
    assert all(shape.is_valid and shape.area > 0 for shape in shapes)
    assert {f["properties"]["fault"] for f in content["features"]} == {"F1"}
    assert json.loads((folder / "polygons/Top_B.geojson").read_text())["features"] == []


def test_model_is_a_valid_input_again(written):
    result, folder = written
    again = read_model(folder / "model" / "model.toml")
    assert [h.name for h in again.horizons] == [h.name for h in result.model.horizons]
    np.testing.assert_array_equal(again.faults[0].surface.vertices, result.model.faults[0].surface.vertices)


def test_two_writes_give_the_same_bytes_but_for_timings(tmp_path):
    result = sample.run_result()
    for name in ("a", "b"):
        write_run(result, tmp_path / name)
    assert names_of(tmp_path / "a") == names_of(tmp_path / "b")
    for name in names_of(tmp_path / "a") - {"report.html", "report.json"}:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
    first, second = (json.loads((tmp_path / n / "report.json").read_text()) for n in ("a", "b"))
    assert first.pop("timings").keys() == second.pop("timings").keys()
    assert first == second


def test_odd_names_become_safe_files(tmp_path):
    result = sample.run_result()
    horizons = (sample.uncut_result("a/b"), sample.uncut_result("a b"))
    odd = type(result)(**{**vars(result), "horizons": horizons})
    write_run(odd, tmp_path)
    report = json.loads((tmp_path / "report.json").read_text())
    assert [h["files"]["surface"] for h in report["horizons"]] == ["horizons/a_b.ts", "horizons/a_b-2.ts"]
