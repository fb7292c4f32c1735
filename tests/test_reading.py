from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graben.arrays import floats
from graben.errors import InputError
from graben.formats.irap import write_irap_ascii, write_irap_binary
from graben.formats.tsurf_writer import write_tsurf
from graben.formats.writing import write_model
from graben.model import GridGeometry, Model
from graben.reading import covering_grid, points_step, read_model, triangulated_step
from graben.surface import Surface

DATA = Path(__file__).parents[2] / "shared" / "data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="shared data are not here")

GRID = GridGeometry(6, 5, 50.0, 32.0, (465_000.5, 5_932_000.25), 17.0)
FAULT = Surface("F1", [[0, 0, -100], [100, 0, -100], [0, 60, -200], [100, 60, -200]], [[0, 1, 2], [1, 3, 2]])
STICKS = "0 0 100\n0 50 200\n999 999 999\n80 0 100\n80 50 200\n999 999 999\n"


def heights() -> np.ndarray:
    nodes = GRID.nodes()
    u = -1500 + 0.1 * (nodes[..., 0] - 465_000) + np.sin(nodes[..., 1])
    u[2, 3] = np.nan
    return u


def folder_of(path: Path, keys: str, z: str = "elevation") -> Path:
    """Write one file of each kind and a model.toml with the given tables."""
    write_irap_ascii(path / "top.irap", GRID, floats(heights()))
    write_irap_binary(path / "top.gri", GRID, floats(heights()))
    write_tsurf(path / "f1.ts", [FAULT])
    write_tsurf(path / "two.ts", [FAULT, Surface("F 2", FAULT.vertices + 500, FAULT.triangles)], z="depth")
    (path / "unstated.ts").write_text(
        "GOCAD TSurf 1\nTFACE\nVRTX 1 0 0 1\nVRTX 2 1 0 2\nVRTX 3 0 1 3\nTRGL 1 2 3\nEND\n"
    )
    (path / "s.pol").write_text(STICKS)
    x, y = np.random.default_rng(0).random((2, 300)) * 1000
    rows = [f"{a!r};{b!r};{-1000 - 0.1 * a!r}" for a, b in zip(x.tolist(), y.tolist(), strict=True)]
    (path / "p.csv").write_text("\n".join(["x;y;z", *rows]))
    file = path / "model.toml"
    file.write_text(f'[model]\nname = "M"\nz = "{z}"\n\n{keys}')
    return file


def section(kind: str, **keys: object) -> str:
    return f"[[{kind}]]\n" + "".join(f"{k} = {v!r}\n".replace("'", '"') for k, v in keys.items())


def test_a_grid_gives_its_geometry_step_and_notes(tmp_path: Path) -> None:
    (horizon,) = read_model(folder_of(tmp_path, section("horizons", name="Top", file="top.irap"))).horizons
    u = heights()
    assert horizon.grid == GRID and horizon.step == 40.0
    assert np.array_equal(horizon.surface.vertices[:, 2], u[np.isfinite(u)])
    assert horizon.surface.name == "Top" and "1 of 30" in horizon.notes[0]


@pytest.mark.parametrize(("z", "sign"), [("elevation", 1.0), ("depth", -1.0)])
def test_z_is_elevation_inside(tmp_path: Path, z: str, sign: float) -> None:
    keys = section("horizons", name="G", file="top.irap") + section("horizons", name="B", file="top.gri")
    keys += section("faults", name="S", file="s.pol") + section("faults", file="two.ts")
    keys += section("faults", name="U", file="unstated.ts")
    model = read_model(folder_of(tmp_path, keys, z))
    u = heights()[np.isfinite(heights())]
    ascii_, binary = model.horizons
    assert np.array_equal(ascii_.surface.vertices[:, 2], sign * u)
    assert np.array_equal(binary.surface.vertices[:, 2], sign * u.astype(np.float32))
    sticks, first, second, unstated = (fault.surface for fault in model.faults)
    assert set(sticks.vertices[:, 2]) <= {sign * v for v in (100.0, 150.0, 200.0)}
    # ZPOSITIVE of the file wins over the model's z
    assert np.array_equal(first.vertices, FAULT.vertices)
    assert np.array_equal(second.vertices, FAULT.vertices + 500) and second.name == "F 2"
    assert unstated.vertices[:, 2].tolist() == [sign, 2 * sign, 3 * sign]
    assert model.z_factor == sign


def test_points_are_fitted(tmp_path: Path) -> None:
    model = read_model(folder_of(tmp_path, section("horizons", name="P", file="p.csv", noise=1.5)))
    (horizon,) = model.horizons
    assert len(horizon.picks) == 300 and horizon.noise == 1.5
    assert np.isclose(horizon.step, 2 * np.sqrt(1000**2 / 300), rtol=0.1)
    plane = -1000 - 0.1 * horizon.surface.vertices[:, 0]
    assert np.allclose(horizon.surface.vertices[:, 2], plane, rtol=0, atol=1e-3)
    grid = horizon.grid
    assert grid is not None and grid.dx == grid.dy == horizon.step and grid.rotation == 0
    nodes = grid.nodes()
    assert (nodes[0, 0] <= horizon.picks[:, :2].min(axis=0)).all()
    assert (nodes[-1, -1] >= horizon.picks[:, :2].max(axis=0)).all()


def test_a_pick_that_is_not_finite_stays_for_the_checks(tmp_path: Path) -> None:
    file = folder_of(tmp_path, section("horizons", name="P", file="p.csv"))
    lines = (tmp_path / "p.csv").read_text().splitlines()
    lines[7] = "1;nan;3"
    (tmp_path / "p.csv").write_text("\n".join(lines))
    (horizon,) = read_model(file).horizons
    assert np.isnan(horizon.surface.vertices).any() and len(horizon.surface.vertices) == 300
    assert len(horizon.surface.triangles) and "line 8" in horizon.notes[0]


def test_a_triangulated_horizon(tmp_path: Path) -> None:
    h = 20.0
    i, j = np.meshgrid(np.arange(6), np.arange(5), indexing="ij")
    vertices = np.stack([h * (i + 0.5 * (j % 2)), h * np.sqrt(0.75) * j, 0.0 * i], axis=-1).reshape(-1, 3)
    from scipy.spatial import Delaunay

    corners = Delaunay(vertices[:, :2]).simplices
    sides = [np.linalg.norm(vertices[corners[:, k]] - vertices[corners[:, k - 1]], axis=1) for k in range(3)]
    corners = corners[np.max(sides, axis=0) < 1.1 * h]
    keys = section("horizons", name="T", file="t.ts") + section("horizons", name="S", file="t.ts", step=7.5)
    file = folder_of(tmp_path, keys)
    write_tsurf(tmp_path / "t.ts", [Surface("other", vertices, corners)], feature="top")
    derived, stated = read_model(file).horizons
    assert np.isclose(derived.step, h) and stated.step == 7.5
    assert derived.surface.name == "T" and derived.grid is not None


def test_one_of_several_surfaces_is_taken_by_name(tmp_path: Path) -> None:
    model = read_model(folder_of(tmp_path, section("faults", name="F 2", file="two.ts", gamma=300.0)))
    (fault,) = model.faults
    assert np.array_equal(fault.surface.vertices, FAULT.vertices + 500) and fault.gamma == 300


def test_files_are_known_by_content_not_by_suffix(tmp_path: Path) -> None:
    file = folder_of(
        tmp_path, section("horizons", name="G", file="g.csv") + section("faults", name="F", file="f")
    )
    (tmp_path / "top.irap").rename(tmp_path / "g.csv")
    (tmp_path / "f1.ts").rename(tmp_path / "f")
    model = read_model(file)
    assert model.horizons[0].grid == GRID and len(model.faults[0].surface.triangles) == 2


def test_absolute_paths_may_lie_anywhere(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    folder_of(tmp_path / "a", "")
    keys = section("faults", name="F", file=str(tmp_path / "a" / "f1.ts"))
    assert len(read_model(str(folder_of(tmp_path / "b", keys))).faults) == 1


def test_ids_of_checks_and_repairs_are_looked_up(tmp_path: Path) -> None:
    keys = section("faults", file="f1.ts")
    assert read_model(folder_of(tmp_path, keys + "[checks]\nnear-miss = 3\n")).checks == {"near-miss": 3.0}
    with pytest.raises(InputError, match=r"'welt' in \[repair\].*weld"):
        read_model(folder_of(tmp_path, keys + '[repair]\nskip = ["welt"]\n'))
    with pytest.raises(InputError, match=r"'near-mis' in \[checks\].*near-miss"):
        read_model(folder_of(tmp_path, keys + "[checks]\nnear-mis = 3\n"))


def test_a_horizon_of_points_is_written_as_its_points(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    xy = rng.uniform(0, 900, (400, 2)) + np.array([430_000.0, 6_780_000.0])
    picks = np.column_stack([xy, 1800 + 0.1 * (xy[:, 0] - 430_000) + rng.normal(size=400)])
    (tmp_path / "a.csv").write_text("X,Y,Z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in picks.tolist()))
    keys = '[model]\nname = "M"\nz = "depth"\n' + section("horizons", name="A", file="a.csv", noise=1.5)
    (tmp_path / "model.toml").write_text(keys)
    model = read_model(tmp_path / "model.toml")
    again = read_model(write_model(model, tmp_path / "again"))
    assert (again.horizons[0].picks == model.horizons[0].picks).all()
    assert (again.horizons[0].surface.vertices == model.horizons[0].surface.vertices).all()
    assert again.horizons[0].step == model.horizons[0].step


def test_steps() -> None:
    assert np.isclose(
        triangulated_step(Surface("A", [[0, 0, 0], [2, 0, 9], [1, np.sqrt(3), 5]], [[0, 1, 2]])), 2
    )
    flat = Surface("A", [[0, 0, 0], [2, 0, 0], [4, 0, 0]], [[0, 1, 2], [0, 1, 7], [0, 1, -1]])
    assert triangulated_step(flat) == 4.0
    assert points_step(floats([[0, 0, 0], [1, 1, 0], [2, 2, 0]])) == 0.0
    assert points_step(floats([[0, 0, 0], [8, 0, 0], [8, 2, 0], [0, 2, 0]])) == 4.0
    assert covering_grid(floats([[0, 0], [1e6, 1e6]]), 1e-9) is None


def same(a: Model, b: Model) -> None:
    assert [s.name for s in a.surfaces] == [s.name for s in b.surfaces]
    for one, other in zip(a.surfaces, b.surfaces, strict=True):
        assert np.array_equal(one.vertices, other.vertices, equal_nan=True)
        assert np.array_equal(one.triangles, other.triangles)
    assert [(h.step, h.noise) for h in a.horizons] == [(h.step, h.noise) for h in b.horizons]
    assert [f.gamma for f in a.faults] == [f.gamma for f in b.faults]
    assert (a.name, a.z, a.unit, a.crs, a.parameters, a.repair, a.contacts, a.checks) == (
        b.name, b.z, b.unit, b.crs, b.parameters, b.repair, b.contacts, b.checks,
    )  # fmt: skip


@pytest.mark.parametrize("z", ["elevation", "depth"])
def test_a_written_model_reads_back_to_the_bit(tmp_path: Path, z: str) -> None:
    keys = 'unit = "ft"\ncrs = "EPSG:23031"\ntruth = "truth"\n'
    keys += section("horizons", name='G "1"', file="top.irap").replace('"1"', '\\"1\\"')
    keys += section("horizons", name="B", file="top.gri") + section("horizons", name="T", file="unstated.ts")
    keys += section("horizons", name="P", file="p.csv", noise=2.0)
    keys += section("faults", file="two.ts", gamma=123.5) + section("faults", name="ü/S", file="s.pol")
    keys += "[parameters]\ntheta = 0.3\nmax_iterations = 7\n[checks]\nnear-miss = 80.0\n"
    keys += '[repair]\nskip = ["weld"]\n'
    keys += '[[contacts]]\nfaults = ["F1", "F 2"]\nrule = "accept"\n'
    file = folder_of(tmp_path, keys, z)
    (tmp_path / "truth").mkdir()
    (tmp_path / "truth" / "a.csv").write_text("1")
    model = read_model(file)
    written = write_model(model, tmp_path / "out")
    again = read_model(written)
    same(model, again)
    assert [h.grid for h in again.horizons[:2]] == [h.grid for h in model.horizons[:2]]
    assert {p.suffix for p in (tmp_path / "out").iterdir()} == {".toml", ".irap", ".ts", ".csv", ""}
    assert again.truth is not None and (again.truth / "a.csv").read_text() == "1"
    first = {p.name: p.read_bytes() for p in (tmp_path / "out").iterdir() if p.is_file()}
    write_model(again, tmp_path / "twice")
    assert all((tmp_path / "twice" / name).read_bytes() == content for name, content in first.items())


@needs_data
@pytest.mark.parametrize(
    ("name", "horizons", "faults"), [("claudius", 4, 1), ("hecho", 9, 3), ("drogon", 4, 6)]
)
def test_real_models(tmp_path: Path, name: str, horizons: int, faults: int) -> None:
    model = read_model(DATA / name / "model.toml")
    assert (len(model.horizons), len(model.faults)) == (horizons, faults)
    assert all(np.isfinite(s.vertices).all() for s in model.surfaces)
    low, high = model.bounds
    if name == "drogon":
        assert low[2] > -2000 and high[2] < -1500
    same(model, read_model(write_model(model, tmp_path / "out")))
