"""Closed fault blocks out: a surface for each and a table of their volumes."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Literal, Protocol

import numpy as np

from graben.formats.names import file_names
from graben.formats.tsurf import Sign
from graben.formats.tsurf_writer import write_tsurf
from graben.formats.vtp import write_vtp
from graben.surface import Surface

#: The table's name, without suffix.
TABLE = "blocks"
COLUMNS = ("block", "file", "volume", "share", "faults", "neighbours")
#: What stands between the names in one field.
BETWEEN = "; "


class ClosedBlock(Protocol):
    """A closed block."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def surface(self) -> Surface:
        """Its closed boundary, elevations."""

    @property
    def volume(self) -> float:
        """Cubic model units."""

    @property
    def faults(self) -> tuple[str, ...]:
        """The faults that bound it."""

    @property
    def neighbours(self) -> tuple[str, ...]:
        """The blocks beyond these faults."""


def block_files(blocks: Sequence[ClosedBlock], kind: Literal["ts", "vtp"] = "ts") -> list[str]:
    """Return the name of the file of each block, as :func:`write_blocks` gives them."""
    return [f"{stem}.{kind}" for stem in file_names(b.name for b in blocks)]


def write_blocks(
    blocks: Sequence[ClosedBlock],
    folder: Path,
    *,
    kind: Literal["ts", "vtp"] = "ts",
    z: Sign = "elevation",
    unit: str = "m",
    crs: str | None = None,
) -> Path:
    """Write blocks: a file for the closed surface of each, and blocks.csv.

    The columns of the table are ``block,file,volume,share,faults,neighbours``: the volume in cubic model
    units, its share of all blocks together, names parted by "; ". The triangles are turned outward: in a
    TSurf once z is counted as ZPOSITIVE says, in a VTK file, which says nothing of it, as its z stands.

    Parameters
    ----------
    blocks : sequence of Block
        See :func:`graben.cleaning.blocks.fault_blocks`.
    folder : Path
        Made where it is missing; files of the same names are replaced.
    kind : "ts" or "vtp"
        GOCAD TSurf, or VTK polygons.
    z : "elevation" or "depth"
        How the files count z.
    unit, crs : str
        Unit of the axes and name of the coordinate system, for TSurf headers.

    Returns
    -------
    Path
        The table.
    """
    folder.mkdir(parents=True, exist_ok=True)
    whole = sum(block.volume for block in blocks)
    table = folder / f"{TABLE}.csv"
    with table.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        for block, file in zip(blocks, block_files(blocks, kind), strict=True):
            path = folder / file
            if kind == "ts":
                write_tsurf(path, [block.surface], z=z, unit=unit, crs=crs)
            else:
                write_vtp(path, _outward(block.surface, z), z=z, unit=unit)
            names = (BETWEEN.join(block.faults), BETWEEN.join(block.neighbours))
            writer.writerow((block.name, path.name, block.volume, block.volume / whole, *names))
    return table


def _outward(surface: Surface, z: Sign) -> Surface:
    """Return the surface with its triangles turned round where depth mirrors them."""
    if z == "elevation":
        return surface
    return Surface(surface.name, surface.vertices, np.ascontiguousarray(surface.triangles[:, ::-1]))
