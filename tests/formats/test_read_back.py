"""What a run writes of a horizon and its faults, read by the programs that will read it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas
import pytest
import pyvista
import shapely
import surfio

from graben.formats.irap import read_irap
from graben.formats.meshes import read_surfaces
from graben.formats.tsurf_writer import write_tsurf
from graben.guessing import guesses
from graben.model import Model
from graben.modeling.products import polygons_of, regular_grid
from graben.modeling.results import HorizonResult
from graben.reports.model_files import write_model_files
from graben.reports.writing import write_horizon
from tests.formats import test_tsurf_referee as referee
from tests.reports import sample

#: Metres. What is written in text or 64 bits loses nothing; this is far below what anything here means.
NEAR = 1e-6
NAME, FAULT = 'Top <A> & "B"/1 🎉', 'F1 <script>"x"</script>'


@pytest.fixture(scope="module", params=["elevation", "depth"])
def written(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[HorizonResult, Model, Path, dict[str, Path]]:
    """A cut horizon of a model in feet with a code, and the files of its run."""
    folder = tmp_path_factory.mktemp("run")
    result = sample.run_result(FAULT, depth=request.param == "depth")
    horizon = sample.cut_result(NAME, FAULT)
    model = replace(result.model, unit="ft", crs="EPSG:32066", horizons=(horizon.horizon,))
    files = write_horizon(horizon, model, folder, "Top", regular_grid(horizon))
    (folder / "model").mkdir()
    run = replace(result, model=model, repaired=model, horizons=(horizon,))
    whole = write_model_files(run, folder, {})
    paths = {what: folder / path for what, path in {**files, **whole.files}.items()}
    return horizon, model, folder, paths


def counted(points: np.ndarray, model: Model) -> np.ndarray:
    """Places with z as the model counts it."""
    return np.asarray(points) * [1.0, 1.0, model.z_factor]


def close(found: object, wanted: object) -> None:
    np.testing.assert_allclose(np.asarray(found), np.asarray(wanted), rtol=0, atol=NEAR)


def test_tsurf_of_a_horizon_says_what_it_is(written) -> None:
    horizon, model, _, files = written
    lines = files["surface"].read_text(encoding="utf-8").split("TFACE")[0].splitlines()
    assert f"GEOLOGICAL_FEATURE {NAME}" in lines and "GEOLOGICAL_TYPE top" in lines
    assert f"name:{NAME}" in lines and "NAME EPSG:32066" in lines
    assert 'AXIS_UNIT "ft" "ft" "ft"' in lines and f"ZPOSITIVE {model.z.capitalize()}" in lines
    assert not any("fault" in line.lower() for line in lines)
    (item,) = read_surfaces(files["surface"])
    assert (item.role, item.z, item.surface.name) == ("top", model.z, NAME)
    close(item.surface.vertices, horizon.surface.vertices)
    assert np.array_equal(item.surface.triangles, horizon.surface.triangles)


def test_a_first_model_tells_the_horizon_from_the_fault(written, tmp_path: Path) -> None:
    _, model, _, files = written
    fault = tmp_path / "f.ts"
    write_tsurf(fault, [model.faults[0].surface], z=model.z, unit=model.unit, crs=model.crs)
    assert "GEOLOGICAL_TYPE fault" in fault.read_text(encoding="utf-8").splitlines()
    found = guesses([files["surface"], fault])
    assert [g.name for g in found.of("horizon")] == [NAME] and [g.name for g in found.of("fault")] == [FAULT]


def test_tsurf_is_read_by_opengeode(written, tmp_path: Path) -> None:
    pytest.importorskip("opengeode_geosciencesio")
    horizon, _, _, files = written
    # It turns depths into elevations.
    (corners,) = referee.refereed([files["surface"]], tmp_path)
    close(corners, horizon.surface.vertices[horizon.surface.triangles])


def test_vtp_is_read_by_pyvista(written) -> None:
    horizon, model, _, files = written
    mesh = pyvista.read(files["vtp"])
    assert mesh.points.dtype == np.float64
    close(mesh.points, counted(horizon.surface.vertices, model))
    assert np.array_equal(mesh.regular_faces, horizon.surface.triangles)
    for name in ("subdomain", "fixed", "side"):
        assert np.array_equal(mesh.point_data[name], getattr(horizon, name))


def test_irap_is_read_by_surfio_and_by_graben(written) -> None:
    horizon, model, _, files = written
    wanted = regular_grid(horizon) * model.z_factor
    geometry, values = read_irap(files["grid"])
    close(geometry.nodes(), horizon.horizon.grid.nodes())
    close(values, wanted)
    other = surfio.IrapSurface.from_ascii_file(files["grid"])
    head = other.header
    close([head.xori, head.yori, head.xinc, head.yinc], [*geometry.origin, geometry.dx, geometry.dy])
    # It keeps 32 bits.
    assert np.array_equal(other.values, values.astype(np.float32), equal_nan=True)


def test_geojson_is_read_by_shapely(written) -> None:
    horizon, model, _, files = written
    text = files["polygons"].read_text(encoding="utf-8")
    content = json.loads(text)
    assert content["crs"]["properties"]["name"] == "urn:ogc:def:crs:EPSG::32066"
    shapes = shapely.get_parts(shapely.from_geojson(text))
    wanted = polygons_of(horizon)
    assert len(shapes) == len(wanted) > 0
    for shape, polygon, feature in zip(shapes, wanted, content["features"], strict=True):
        assert feature["properties"]["fault"] == FAULT and feature["properties"]["horizon"] == NAME
        assert shape.is_valid and shape.has_z == polygon.shape.has_z
        found, given = (shapely.get_coordinates(s, include_z=True) for s in (shape, polygon.shape))
        close(found, counted(given, model))


def test_cutoffs_are_read_by_pandas(written) -> None:
    horizon, model, _, files = written
    rows = pandas.read_csv(files["cutoffs"])
    (cutoff,) = horizon.cutoffs
    assert set(rows["fault"]) == {FAULT}
    for side, lip in (("hanging", cutoff.hanging), ("foot", cutoff.foot)):
        mine = rows[rows["side"] == side]
        close(mine[["x", "y", "z"]], counted(lip, model))
        close(mine[["s", "throw", "heave"]], np.stack([cutoff.s, cutoff.throw, cutoff.heave], axis=1))


def test_vtu_of_the_faults_is_read_by_pyvista(written) -> None:
    _, model, _, files = written
    mesh = pyvista.read(files["faults"])
    (fault,) = model.faults
    assert list(mesh.field_data["names"]) == [FAULT]
    close(mesh.points, counted(fault.surface.vertices, model))
    assert np.array_equal(mesh.cells.reshape(-1, 4)[:, 1:], fault.surface.triangles)


def test_package_is_read_by_resqpy(written) -> None:
    resqpy_model = pytest.importorskip("resqpy.model")
    _, model, _, files = written
    package = resqpy_model.Model(str(files["resqml"]))
    titles = package.titles(obj_type="TriangulatedSetRepresentation")
    assert sorted(titles) == sorted([NAME, FAULT])
    crs = package.root(obj_type="LocalDepth3dCrs")
    assert crs.findtext("{*}VerticalUom") == "ft"
    assert crs.findtext("{*}ZIncreasingDownward") == str(model.z == "depth").lower()
