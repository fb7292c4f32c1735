"""Irap classic grids, ASCII and binary, and the surface on the nodes of a grid.

The ASCII form is read and written here in double precision: surfio holds values as float32 and writes six
decimals. The binary form is float32 by definition, its origin included: at a northing of 6,000,000 m that is
a place to 0.25 m. surfio writes it; damaged files make surfio's reader write beyond its memory, so it is read
here (``docs/decisions/0002-formats.md``).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.errors import InputError, OutputError
from graben.formats.numbers import rows_of_text
from graben.formats.text import decoded, load_bytes, shortened
from graben.model import GridGeometry
from graben.surface import Surface

#: What an undefined node holds in an ASCII file; greater values are undefined as well.
UNDEFINED = 9999900.0
_ID = "-996"
_BINARY_START = bytes.fromhex("00000020fffffc1c")
_BINARY_HEADER = [32, 16, 28]  # bytes of the records
_BINARY_UNDEFINED = np.float32(1e30)
_MARKER = 4  # bytes
_HEADER_WORDS = 19
_HEADER_WHOLE = {1: "number of rows", 8: "number of columns"}
_VALUES_PER_LINE = 6
_MOST_NODES = 200_000_000


def is_irap_ascii(content: bytes) -> bool:
    """Return whether the content begins as an Irap classic ASCII grid does."""
    return content[:64].split(None, 1)[:1] == [_ID.encode()]


def is_irap_binary(content: bytes) -> bool:
    """Return whether the content begins as an Irap classic binary grid does."""
    return content.startswith(_BINARY_START)


def read_irap(path: Path) -> tuple[GridGeometry, FloatArray]:
    """Read an Irap classic grid, ASCII or binary.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    geometry : GridGeometry
        With positive dx and dy: a grid counted backwards is turned round.
    values : (columns, rows) array
        As the file counts them, NaN where undefined.

    Raises
    ------
    InputError
        When the file is no such grid, is cut short, or holds a word that is no number.
    """
    content = load_bytes(path)
    if is_irap_binary(content):
        return _read_binary(content, path)
    return _read_ascii(decoded(content, path), path)


def _read_ascii(text: str, path: Path) -> tuple[GridGeometry, FloatArray]:
    words = text.split()
    if words[0] != _ID:
        raise InputError(f"{path}, line 1: an Irap grid begins with {_ID}, not {shortened(words[0])}.")
    if len(words) < _HEADER_WORDS:
        raise InputError(f"{path}: the header of the Irap grid is cut short; export the grid again.")
    for place, what in _HEADER_WHOLE.items():
        if not words[place].isdigit() or int(words[place]) == 0:
            raise InputError(f"{path}: the {what} of the Irap grid is {shortened(words[place])}; correct it.")
    try:
        numbers = np.array(list(map(float, words)))
    except ValueError:
        raise _no_number(text, path) from None
    columns, rows = int(words[8]), int(words[1])
    values = numbers[_HEADER_WORDS:]
    if len(values) != columns * rows:
        raise InputError(
            f"{path}: the header says {columns} x {rows} = {columns * rows} nodes but {len(values)} values "
            "follow; export the grid again."
        )
    values = np.where(values >= UNDEFINED, np.nan, values).reshape(rows, columns).T
    dx, dy, x, y, rotation = numbers[[2, 3, 4, 6, 9]].tolist()
    return _forward(GridGeometry(columns, rows, dx, dy, (x, y), rotation), values, path)


def _no_number(text: str, path: Path) -> InputError:
    for number, line in enumerate(text.splitlines(), start=1):
        for word in line.split():
            try:
                float(word)
            except ValueError:
                return InputError(f"{path}, line {number}: {shortened(word)} is no number; correct it.")
    raise AssertionError("a text that does not convert holds a word that does not")


def _read_binary(content: bytes, path: Path) -> tuple[GridGeometry, FloatArray]:
    """Read the Fortran records of a binary grid: three of the header, then the values, often row by row."""
    records = list(_records(content, path))
    if [len(record) for record in records[:3]] != _BINARY_HEADER:
        raise InputError(f"{path}: the header of the Irap binary grid is damaged; export the grid again.")
    _, rows, x, _, y, _, dx, dy = struct.unpack(">2i6f", records[0])
    columns, rotation = struct.unpack(">if8x", records[1])
    body = b"".join(records[3:])
    with np.errstate(invalid="ignore"):  # a damaged file may hold NaNs that signal
        values = np.frombuffer(body, dtype=">f4", count=len(body) // 4).astype(np.float64)
    if columns < 1 or rows < 1 or len(values) != columns * rows:
        raise InputError(
            f"{path}: the header of the Irap binary grid says {columns} x {rows} nodes but {len(values)} "
            "values follow; export the grid again."
        )
    values = np.where(values >= _BINARY_UNDEFINED, np.nan, values).reshape(rows, columns).T
    return _forward(GridGeometry(columns, rows, dx, dy, (x, y), rotation), values, path)


def _records(content: bytes, path: Path) -> Iterator[bytes]:
    """Yield the records of a big-endian Fortran file; before and after each stands its length."""
    place = 0
    while place < len(content):
        length = int.from_bytes(content[place : place + _MARKER], "big")
        stop = place + _MARKER + length
        if content[stop : stop + _MARKER] != content[place : place + _MARKER]:
            raise InputError(
                f"{path}: the Irap binary grid is damaged or cut short after byte {place}; export it again."
            )
        yield content[place + _MARKER : stop]
        place = stop + _MARKER


def _forward(grid: GridGeometry, values: FloatArray, path: Path) -> tuple[GridGeometry, FloatArray]:
    """Return a grid with positive steps: one that counts backwards begins at its other end."""
    if not np.isfinite([grid.dx, grid.dy, *grid.origin, grid.rotation]).all() or grid.dx * grid.dy == 0:
        raise InputError(
            f"{path}: a number in the header of the Irap grid is not finite, or a step is zero; correct it."
        )
    a = np.radians(grid.rotation)
    x, y = grid.origin
    if grid.dx < 0:
        back = (grid.columns - 1) * grid.dx
        x, y = x + back * np.cos(a), y + back * np.sin(a)
        values = values[::-1, :]
    if grid.dy < 0:
        back = (grid.rows - 1) * grid.dy
        x, y = x - back * np.sin(a), y + back * np.cos(a)
        values = values[:, ::-1]
    origin = (float(x), float(y))
    return replace(grid, dx=abs(grid.dx), dy=abs(grid.dy), origin=origin), floats(values)


def write_irap_ascii(path: Path, geometry: GridGeometry, values: FloatArray) -> None:
    """Write a grid as Irap classic ASCII, with as many digits as the numbers have.

    Parameters
    ----------
    path : Path
        The file.
    geometry : GridGeometry
        Where the nodes lie.
    values : (columns, rows) array
        In the convention the file is to have; NaN where undefined.
    """
    g = geometry
    # Plain numbers, whatever numpy type they came as: repr of those is no number to read.
    x, y, dx, dy, rotation = (float(number) for number in (*g.origin, g.dx, g.dy, g.rotation))
    far = (x + (g.columns - 1) * dx, y + (g.rows - 1) * dy)
    flat = np.where(np.isfinite(values), values, UNDEFINED).T.ravel()
    head = [
        f"{_ID} {g.rows} {dx!r} {dy!r}",
        f"{x!r} {far[0]!r} {y!r} {far[1]!r}",
        f"{g.columns} {rotation!r} {x!r} {y!r}",
        "0 0 0 0 0 0 0",
    ]
    full = len(flat) // _VALUES_PER_LINE * _VALUES_PER_LINE
    lines = rows_of_text(flat[:full].reshape(-1, _VALUES_PER_LINE)) + rows_of_text(flat[None, full:])
    path.write_bytes("\n".join(head).encode() + b"\n" + b"\n".join(line for line in lines if line) + b"\n")


def write_irap_binary(path: Path, geometry: GridGeometry, values: FloatArray) -> None:
    """Write a grid as Irap classic binary, which stores every number, the origin too, as float32.

    Parameters as for :func:`write_irap_ascii`.
    """
    import surfio

    g = geometry
    if g.columns * g.rows > _MOST_NODES:
        raise OutputError(f"{path}: a grid of {g.columns} x {g.rows} nodes is too large; take a larger step.")
    header = surfio.IrapHeader(
        ncol=g.columns,
        nrow=g.rows,
        xinc=g.dx,
        yinc=g.dy,
        xori=g.origin[0],
        yori=g.origin[1],
        xmax=g.origin[0] + (g.columns - 1) * g.dx,
        ymax=g.origin[1] + (g.rows - 1) * g.dy,
        rot=g.rotation,
        xrot=g.origin[0],
        yrot=g.origin[1],
    )
    grid = surfio.IrapSurface(header, np.asarray(values, dtype=np.float32))
    path.write_bytes(grid.to_binary_buffer())


def grid_surface(name: str, geometry: GridGeometry, values: FloatArray) -> Surface:
    """Return the triangulated surface on the defined nodes of a grid.

    A cell with four defined nodes gives two triangles, with three one. The diagonals alternate like a
    chessboard (from node (i, j) to (i + 1, j + 1) where i + j is even), so that no direction is preferred and
    a mirrored grid with an even number of cells gives the mirrored surface. All triangles face upwards.

    Parameters
    ----------
    name : str
        Name of the surface.
    geometry : GridGeometry
        Where the nodes lie.
    values : (columns, rows) array
        Elevations, NaN where undefined.

    >>> g = GridGeometry(2, 2, 10.0, 10.0, (0.0, 0.0))
    >>> grid_surface("H", g, floats([[0, 1], [2, np.nan]])).triangles.tolist()
    [[0, 2, 1]]
    """
    defined = np.isfinite(values)
    index = np.full(values.shape, -1, dtype=np.int64)
    index[defined] = np.arange(np.count_nonzero(defined))
    vertices = np.concatenate([geometry.nodes()[defined], values[defined][:, None]], axis=1)
    return Surface(name, floats(vertices, -1, 3), _cells(index, defined))


def _cells(index: IntArray, defined: BoolArray) -> IntArray:
    """Return the triangles of all cells, in the order of the cells."""
    if defined.all():
        return _whole_cells(index)
    corners = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1)
    there = np.stack([defined[:-1, :-1], defined[1:, :-1], defined[1:, 1:], defined[:-1, 1:]], axis=-1)
    count = there.sum(axis=-1)
    i, j = np.indices(count.shape)
    even = (i + j) % 2 == 0
    # The four triangles of a cell are named by the corner they leave out.
    without = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])
    first = np.where(even, 3, 2)
    second = np.where(even, 1, 0)
    missing = np.argmin(there, axis=-1)
    choice = np.stack([np.where(count == 3, missing, first), second], axis=-1)
    taken = np.stack([count >= 3, count == 4], axis=-1)
    cell = np.stack([corners, corners], axis=-2)
    return ints(np.take_along_axis(cell, without[choice], axis=-1)[taken], -1, 3)


def _whole_cells(index: IntArray) -> IntArray:
    """Return the triangles of all cells of a grid without undefined nodes, as :func:`_cells` does."""
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    i, j = np.ogrid[: a.shape[0], : a.shape[1]]
    even = (i + j) % 2 == 0
    made = np.empty((*a.shape, 2, 3), dtype=np.int64)
    # an even cell is cut from a to c, an odd one from b to d
    made[..., 0, 0], made[..., 0, 1], made[..., 0, 2] = a, b, np.where(even, c, d)
    made[..., 1, 0], made[..., 1, 1], made[..., 1, 2] = np.where(even, a, b), c, d
    return ints(made, -1, 3)
