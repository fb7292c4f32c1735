"""The folder of a run: all files there, readable by others, the same bytes twice."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pandas
import pytest
import pyvista
import shapely
import surfio

from graben.formats.sticks import read_sticks
from graben.formats.tables import COLUMNS
from graben.formats.tsurf import read_tsurf
from graben.modeling.products import regular_grid
from graben.reading import read_model
from graben.reports.check_files import REPORTS
from graben.reports.writing import write_horizon, write_run
from graben.tables import ALONG
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
    "polygons/Top_A.pol",
    "polygons/Top_B.geojson",
    "polygons/Top_B.pol",
    "report.html",
    "report.json",
    "tables/doubts.csv",
    "tables/findings.csv",
    "tables/input.csv",
    "tables/iterations.csv",
    "tables/misfit.csv",
    "tables/throws.csv",
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


def test_vtp_says_what_its_numbers_mean(written):
    result, folder = written
    fields = pyvista.read(folder / "horizons/Top_A.vtp").field_data
    assert fields["names"].tolist() == ["Top A"]
    assert fields["z"].tolist() == [
        "depth, positive down" if result.model.z == "depth" else "elevation, positive up"
    ]
    assert fields["unit"].tolist() == ["m"]
    assert "1 hanging wall" in fields["side"][0]
    assert pyvista.read(folder / "model/faults.vtu").field_data["z"].tolist() == fields["z"].tolist()


def test_every_step_of_the_writing_is_told(tmp_path):
    told = []
    write_run(sample.run_result(), tmp_path, lambda stage, what: told.append((stage, what)))
    assert {stage for stage, _ in told} == {"write"}
    assert [what for _, what in told] == [
        "tables",
        "files of Top A",
        "files of Top B",
        "3D view",
        "model",
        "pictures of the report",
    ]


def test_polygons_of_a_fault_that_changes_its_sense_have_the_throws_of_their_part(tmp_path):
    result = sample.run_result()
    first = result.horizons[0]
    # normal on one half, reverse on the other: the lips change places there
    cutoff = first.cutoffs[0]
    turned = np.arange(len(cutoff.s)) > len(cutoff.s) // 2
    hanging = np.where(turned[:, None], cutoff.foot, cutoff.hanging)
    foot = np.where(turned[:, None], cutoff.hanging, cutoff.foot)
    sign = np.where(turned, -1.0, 1.0)
    both = replace(cutoff, hanging=hanging, foot=foot, throw=sign * cutoff.throw, heave=sign * cutoff.heave)
    model = replace(result.repaired, crs="EPSG:23031")
    (tmp_path / "run").mkdir()
    write_horizon(replace(first, cutoffs=(both,)), model, tmp_path / "run", "top", None)
    content = json.loads((tmp_path / "run" / "polygons" / "top.geojson").read_text())
    told = {f["properties"]["kind"]: f["properties"] for f in content["features"]}
    assert set(told) == {"gap", "overlap"}
    assert told["gap"]["throw"] == both.throw.max() > 0 and told["gap"]["heave"] == both.heave.max() > 0
    assert told["overlap"]["throw"] == both.throw.min() < 0
    assert told["overlap"]["heave"] == both.heave.min() < 0
    assert {p["crs"] for p in told.values()} == {"EPSG:23031"}


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
    assert list(rows[0]) == [*COLUMNS, *ALONG]
    for upper, lower in zip(rows[::2], rows[1::2], strict=True):
        assert (upper["type"], upper["node"], upper["piece"]) == (lower["type"], lower["node"], "1")
        assert (upper["s"], upper["throw"], upper["heave"]) == (lower["s"], lower["throw"], lower["heave"])
        step = float(lower["z"]) - float(upper["z"])
        assert float(upper["throw"]) == pytest.approx(result.model.z_factor * step, abs=1e-9)


def test_polygons_are_valid(written):
    result, folder = written
    content = json.loads((folder / "polygons/Top_A.geojson").read_text())
    shapes = [shapely.geometry.shape(f["geometry"]) for f in content["features"]]
    assert shapes
    assert all(shape.is_valid and shape.area > 0 for shape in shapes)
    assert all(shape.exterior.is_ccw for shape in shapes)
    told = [f["properties"] for f in content["features"]]
    (cutoff,) = result.horizons[0].cutoffs
    largest = {"throw": cutoff.throw.max(), "heave": cutoff.heave.max()}
    assert told == [{"fault": "F1", "horizon": "Top A", "piece": 1, "kind": "gap", **largest}]
    assert json.loads((folder / "polygons/Top_B.geojson").read_text())["features"] == []


def test_polygon_text_has_the_polygons_of_the_geojson_in_their_order(written):
    _, folder = written
    content = json.loads((folder / "polygons/Top_A.geojson").read_text())
    rings = read_sticks(folder / "polygons/Top_A.pol")
    assert len(rings) == len(content["features"])
    for ring, feature in zip(rings, content["features"], strict=True):
        np.testing.assert_array_equal(ring, feature["geometry"]["coordinates"][0])
    assert (folder / "polygons/Top_B.pol").read_bytes() == b""


def test_polygons_lie_on_the_lips_in_the_models_convention(written):
    _, folder = written
    table = pandas.read_csv(folder / "cutoffs/Top_A.csv")
    lips = {tuple(p) for p in table[["x", "y", "z"]].to_numpy().round(6).tolist()}
    (ring,) = read_sticks(folder / "polygons/Top_A.pol")
    assert {tuple(p) for p in ring.round(6).tolist()} == lips


def test_tables_count_z_as_the_model_does(written):
    result, folder = written
    (row,) = pandas.read_csv(folder / "tables/throws.csv").to_dict("records")
    assert np.sign(row["z"]) == -result.model.z_factor
    findings = pandas.read_csv(folder / "tables/findings.csv")
    assert findings["z"].dropna().tolist() == [-2100.0 * result.model.z_factor]
    assert len(pandas.read_csv(folder / "tables/doubts.csv")) == 0


def test_a_divided_horizon_has_a_surface_for_each_part(tmp_path):
    result = sample.run_result()
    (cut, _) = result.horizons
    # As if the nodes east of the fault were a subdomain of their own.
    west = cut.surface.triangles[cut.block[cut.surface.triangles].max(axis=(1, 2)) <= 0]
    label = np.ones(len(cut.first))
    label[west.ravel()] = 0
    divided = replace(cut, subdomain=label)
    files = write_horizon(divided, result.model, tmp_path, "Top_A", None)
    assert [key for key in files if key.startswith("part")] == ["part 0", "part 1"]
    told = [read_tsurf(tmp_path / files[f"part {k}"])[0].surface for k in (0, 1)]
    assert [surface.name for surface in told] == ["Top A part 0", "Top A part 1"]
    assert sum(len(surface.triangles) for surface in told) == len(cut.surface.triangles)
    assert "part 0" not in write_horizon(cut, result.model, tmp_path / "whole", "Top_A", None)


@pytest.mark.parametrize("name", [sample.EVIL, "=1+1", 'a,"b";c', "x" * 300, "\N{FIRE}"], ids=range(5))
def test_any_name_comes_back_from_polygons_and_cutoffs(tmp_path, name):
    result = sample.cut_result(name, name)
    files = write_horizon(result, sample.model(name, names=(name, "B")), tmp_path, "a", None)
    content = json.loads((tmp_path / files["polygons"]).read_text(encoding="utf-8"))
    assert {f["properties"]["fault"] for f in content["features"]} == {name}
    assert {f["properties"]["horizon"] for f in content["features"]} == {name}
    with (tmp_path / files["cutoffs"]).open(encoding="utf-8", newline="") as stream:
        assert {row["fault"] for row in csv.DictReader(stream)} == {name}


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
    # of the page only the seconds, and the minute in which it was made
    pages = [
        re.sub(r"Made [^.]*UTC|<td class=\"n\">[0-9.]+</td>", "", (tmp_path / n / "report.html").read_text())
        for n in ("a", "b")
    ]
    assert pages[0] == pages[1]


def test_the_report_says_which_graben_made_it_and_when(written):
    _, folder = written
    number = version("graben")
    page = (folder / "report.html").read_text()
    assert f'<meta name="generator" content="graben {number}">' in page
    assert f'<th scope="row">graben</th><td>{number}</td>' in page
    assert re.search(r"Made \d{4}-\d\d-\d\d \d\d:\d\d UTC\. Peak memory", page)
    assert REPORTS["html"].ours(page.encode())
    assert json.loads((folder / "report.json").read_text())["version"] == number


def test_odd_names_become_safe_files(tmp_path):
    result = sample.run_result()
    horizons = (sample.uncut_result("a/b"), sample.uncut_result("a b"))
    odd = type(result)(**{**vars(result), "horizons": horizons})
    write_run(odd, tmp_path)
    report = json.loads((tmp_path / "report.json").read_text())
    assert [h["files"]["surface"] for h in report["horizons"]] == ["horizons/a_b.ts", "horizons/a_b-2.ts"]
