"""Regular grids of every format."""

from __future__ import annotations

from pathlib import Path

from graben.arrays import FloatArray
from graben.formats.irap import read_irap
from graben.formats.kinds import Kind, kind_of
from graben.formats.zmap import read_zmap
from graben.model import GridGeometry


def read_grid(path: Path, kind: Kind | None = None) -> tuple[GridGeometry, FloatArray]:
    """Read an Irap or ZMAP+ grid; ``kind`` saves looking for it.

    Returns
    -------
    geometry : GridGeometry
        With positive steps.
    values : (columns, rows) array
        As the file counts z, NaN where undefined.

    Raises
    ------
    InputError
        As of :func:`graben.formats.irap.read_irap` and :func:`graben.formats.zmap.read_zmap`.
    """
    return read_zmap(path) if (kind or kind_of(path)) is Kind.ZMAP else read_irap(path)
