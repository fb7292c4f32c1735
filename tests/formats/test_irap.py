from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import surfio

from graben.arrays import floats
from graben.errors import InputError
from graben.formats.irap import grid_surface, read_irap, write_irap_ascii, write_irap_binary
from graben.model import GridGeometry
from graben.surface import triangle_normals

GRID = GridGeometry(4, 3, 10.0, 20.0, (465_123.123456, 5_932_000.98765), 30.0)


def values(grid: GridGeometry = GRID) -> np.ndarray:
    u = np.random.default_rng(3).normal(size=(grid.columns, grid.rows)) * 100 + 1700
    u[1, 2] = np.nan
    return u


def test_ascii_reads_back_to_the_bit(tmp_path: Path) -> None:
    u = values()
    write_irap_ascii(tmp_path / "g", GRID, floats(u))
    geometry, back = read_irap(tmp_path / "g")
    assert geometry == GRID
    assert np.array_equal(back, u, equal_nan=True)


def test_binary_is_float32(tmp_path: Path) -> None:
    u = values()
    write_irap_binary(tmp_path / "g", GRID, floats(u))
    geometry, back = read_irap(tmp_path / "g")
    assert np.array_equal(back, u.astype(np.float32), equal_nan=True)
    assert geometry.origin == tuple(float(np.float32(v)) for v in GRID.origin)
    assert (geometry.columns, geometry.rows, geometry.rotation) == (4, 3, 30.0)


def test_binary_values_are_those_surfio_reads(tmp_path: Path) -> None:
    u = values()
    write_irap_binary(tmp_path / "g", GRID, floats(u))
    theirs = surfio.IrapSurface.from_binary_file(tmp_path / "g")
    geometry, back = read_irap(tmp_path / "g")
    assert np.array_equal(back, theirs.values, equal_nan=True)
    head = theirs.header
    assert (geometry.dx, geometry.dy, *geometry.origin) == (head.xinc, head.yinc, head.xori, head.yori)


@pytest.mark.parametrize("extra", [1, 13, 1000])
def test_a_binary_record_that_is_too_long_is_named(tmp_path: Path, extra: int) -> None:
    write_irap_binary(tmp_path / "g", GRID, floats(values()))
    head = (tmp_path / "g").read_bytes()[:100]
    length = (4 * (12 + extra)).to_bytes(4, "big")
    (tmp_path / "g").write_bytes(head + length + bytes(4 * (12 + extra)) + length)
    with pytest.raises(InputError, match=f"{12 + extra} values"):
        read_irap(tmp_path / "g")


def test_surfio_reads_what_we_write_and_we_what_surfio_writes(tmp_path: Path) -> None:
    u = values()
    write_irap_ascii(tmp_path / "ours", GRID, floats(u))
    theirs = surfio.IrapSurface.from_ascii_file(tmp_path / "ours")
    assert np.array_equal(theirs.values, u.astype(np.float32), equal_nan=True)
    head = theirs.header
    assert (head.xori, head.yori) == GRID.origin and (head.ncol, head.nrow, head.rot) == (4, 3, 30.0)
    theirs.to_ascii_file(tmp_path / "theirs")
    geometry, back = read_irap(tmp_path / "theirs")
    # surfio writes six decimals
    assert np.allclose(back, u.astype(np.float32), rtol=0, atol=1e-6, equal_nan=True)
    assert np.allclose(geometry.nodes(), GRID.nodes(), rtol=0, atol=1e-5)


def test_rotation_turns_counter_clockwise_and_x_runs_first(tmp_path: Path) -> None:
    text = "-996 2 10 20\n100 120 200 220\n3 90 100 200\n0 0 0 0 0 0 0\n1 2 3\n4 5 9999900.0\n"
    (tmp_path / "g").write_text(text)
    geometry, u = read_irap(tmp_path / "g")
    assert np.array_equal(u, [[1, 4], [2, 5], [3, np.nan]], equal_nan=True)
    nodes = geometry.nodes()
    assert np.allclose(nodes[1, 0], [100, 210]) and np.allclose(nodes[0, 1], [80, 200])


def places(grid: GridGeometry, z: np.ndarray) -> np.ndarray:
    """The defined nodes in space, in one order, by the formula of the format, however the grid counts."""
    a, (x, y) = np.radians(grid.rotation), grid.origin
    i, j = np.indices(z.shape)
    along, across = i * grid.dx, j * grid.dy
    rows = np.stack(
        [x + along * np.cos(a) - across * np.sin(a), y + along * np.sin(a) + across * np.cos(a), z], axis=-1
    )[np.isfinite(z)]
    return rows[np.lexsort(np.round(rows, 3).T)]


@pytest.mark.parametrize("rotation", [0.0, 30.0, 120.0, -75.0])
@pytest.mark.parametrize(("fx", "fy"), [(1, 1), (-1, 1), (1, -1), (-1, -1)])
def test_a_grid_of_either_hand_is_the_same_surface(tmp_path: Path, rotation: float, fx: int, fy: int) -> None:
    """A negative step in y is how xtgeo and RMS write a grid that they call flipped."""
    grid = GridGeometry(4, 3, fx * 10.0, fy * 20.0, (465_100.0, 5_932_000.0), rotation)
    u = values()
    write_irap_ascii(tmp_path / "ascii", grid, floats(u))
    write_irap_binary(tmp_path / "binary", grid, floats(u))
    for name, z in (("ascii", u), ("binary", u.astype(np.float32).astype(float))):
        geometry, back = read_irap(tmp_path / name)
        assert geometry.dx > 0 and geometry.dy > 0 and geometry.rotation == rotation
        assert np.allclose(places(geometry, back), places(grid, z), rtol=0, atol=1e-8)
        # once it counts forwards, it is written as it was read, to the byte
        write = write_irap_ascii if name == "ascii" else write_irap_binary
        write(tmp_path / "again", geometry, back)
        write(tmp_path / "twice", *read_irap(tmp_path / "again"))
        again = (tmp_path / "again").read_bytes()
        assert (tmp_path / "twice").read_bytes() == again
        assert ((tmp_path / name).read_bytes() == again) == (fx > 0 and fy > 0)


def test_a_grid_is_a_surface_of_its_defined_nodes() -> None:
    grid = GridGeometry(5, 4, 10.0, 20.0, (100.0, 200.0), 30.0)
    u = values(grid)
    surface = grid_surface("H", grid, floats(u))
    normals = triangle_normals(surface.vertices, surface.triangles)
    # 12 cells of two triangles; the undefined node takes one from each of its four cells
    assert len(surface.vertices) == 19 and len(surface.triangles) == 24 - 4
    assert np.allclose(normals[:, 2], 10 * 20)
    defined = np.isfinite(u)
    assert np.array_equal(surface.vertices[:, :2], grid.nodes()[defined])
    assert np.array_equal(surface.vertices[:, 2], u[defined])


def test_triangulation_mirrors_with_the_grid() -> None:
    grid = GridGeometry(5, 7, 1.0, 1.0, (0.0, 0.0))
    i, j = np.indices((5, 7)).astype(float)
    for mirrored in (grid_surface("H", grid, floats(4 - i)), grid_surface("H", grid, floats(6 - j))):
        plain = grid_surface("H", grid, floats(i * 0))
        axis, last = (0, 4) if mirrored.vertices[0, 2] == 4 else (1, 6)
        turned = plain.vertices[:, :2].copy()
        turned[:, axis] = last - turned[:, axis]
        ours = {frozenset(map(tuple, turned[t])) for t in plain.triangles}
        theirs = {frozenset(map(tuple, mirrored.vertices[t, :2])) for t in mirrored.triangles}
        assert ours == theirs


def test_a_plane_with_holes_stays_a_plane() -> None:
    grid = GridGeometry(30, 20, 1.0, 1.0, (0.0, 0.0))
    nodes = grid.nodes()
    u = 0.3 * nodes[..., 0] - 0.1 * nodes[..., 1] + 5
    u[np.random.default_rng(0).random(u.shape) < 0.2] = np.nan
    surface = grid_surface("H", grid, floats(u))
    normals = triangle_normals(surface.vertices, surface.triangles)
    assert (normals[:, 2] > 0).all()
    assert np.allclose(normals[:, :2] / normals[:, 2:], [-0.3, 0.1])


HEADER = "-996 3 10 20\n0 30 0 40\n4 0 0 0\n0 0 0 0 0 0 0\n"
ROWS = "1 2 3 4\n5 6 7 8\n9 10 11 12\n"
BROKEN = {
    "cut short": (HEADER + ROWS[:-4], "11 values"),
    "too long": (HEADER + ROWS + "13\n", "13 values"),
    "header cut short": (HEADER[:20], "header"),
    "letters": (HEADER + ROWS.replace("7", "seven"), "line 6"),
    "no columns": (HEADER.replace("\n4 0", "\n0 0") + ROWS, "columns"),
    "a fraction of rows": (HEADER.replace("-996 3", "-996 3.5") + ROWS, "rows"),
    "no step": (HEADER.replace("3 10", "3 0") + ROWS, "step"),
    "an infinite origin": (HEADER.replace("0 30 0 40", "inf 30 0 40") + ROWS, "not finite"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_what_cannot_be_read_is_named(tmp_path: Path, case: str) -> None:
    text, word = BROKEN[case]
    (tmp_path / "g").write_text(text)
    with pytest.raises(InputError, match=word):
        read_irap(tmp_path / "g")


@pytest.mark.parametrize("keep", [10, 60, 110, -3, -20])
def test_a_binary_grid_that_is_cut_short_is_named(tmp_path: Path, keep: int) -> None:
    write_irap_binary(tmp_path / "g", GRID, floats(values()))
    (tmp_path / "g").write_bytes((tmp_path / "g").read_bytes()[:keep])
    with pytest.raises(InputError, match="Irap binary"):
        read_irap(tmp_path / "g")
