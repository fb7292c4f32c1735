"""Polygons as RMS and Irap take them: x y z a line, and a line of 999s after each polygon."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray
from graben.formats.sticks import END
from graben.formats.tsurf import Sign
from graben.formats.tsurf_writer import in_convention


def write_pol(path: Path, rings: Iterable[FloatArray], *, z: Sign = "elevation") -> None:
    """Write lines or rings as RMS/Irap polygon text; a file without any is empty.

    The format has no names: the order of the file is all that tells one polygon from the next.

    Parameters
    ----------
    path : Path
        The file.
    rings : iterable of (k, 3) arrays
        Elevations; a ring ends with its first point again.
    z : "elevation" or "depth"
        How the file counts z.
    """
    end = np.full((1, 3), END)
    rows = [row for ring in rings for row in np.concatenate([in_convention(ring, z), end]).tolist()]
    text = "".join(f"{x!r} {y!r} {height!r}\n" for x, y, height in rows)
    path.write_text(text, encoding="ascii", newline="\n")
