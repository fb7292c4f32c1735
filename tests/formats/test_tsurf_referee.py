"""OpenGeode-GeosciencesIO as the referee, on the dialects it reads."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from graben.formats.tsurf import read_tsurf
from graben.formats.tsurf_writer import write_tsurf
from tests.formats.dialects import SAME

pytest.importorskip("opengeode_geosciencesio")
DATA = Path(__file__).parents[3] / "shared" / "data" / "cfm"

# It writes its log to the streams of the process, so it has one of its own.
REFEREE = """
import sys, numpy as np, opengeode, opengeode_geosciencesio as io
library = io.OpenGeodeGeosciencesIOMeshLibrary
library.initialize()
for path, out in zip(sys.argv[1::2], sys.argv[2::2]):
    mesh = opengeode.load_triangulated_surface3D(path)
    vertices = []
    for v in range(mesh.nb_vertices()):
        point = mesh.point(v)
        vertices.append([point.value(k) for k in range(3)])
    corner = opengeode.PolygonVertex
    triangles = [[mesh.polygon_vertex(corner(t, k)) for k in range(3)] for t in range(mesh.nb_polygons())]
    np.savez(out, vertices=np.array(vertices), triangles=np.array(triangles))
"""

#: What it does not read: headers in one line; ids that are not counted up one by one; the sign of z of the
#: Model3d that lists a surface.
UNREAD = {
    "one-line header",
    "one-line header, more keys",
    "ids with gaps, unordered",
    "Model3d of depths",
}


def refereed(files: list[Path], folder: Path) -> list[np.ndarray]:
    """Return the corners of all triangles of each file, shape (m, 3, 3), as the referee reads them."""
    outputs = [folder / f"{k}.npz" for k in range(len(files))]
    arguments = [str(part) for pair in zip(files, outputs, strict=True) for part in pair]
    subprocess.run([sys.executable, "-c", REFEREE, *arguments], check=True, capture_output=True)
    loaded = [np.load(out) for out in outputs]
    return [data["vertices"][data["triangles"]] for data in loaded]


def test_dialects(tmp_path: Path) -> None:
    names = sorted(set(SAME) - UNREAD)
    files = []
    for k, name in enumerate(names):
        files.append(tmp_path / f"{k}.ts")
        files[-1].write_text(SAME[name], encoding="utf-8", newline="")
    for name, file, corners in zip(names, files, refereed(files, tmp_path), strict=True):
        surface = read_tsurf(file)[0].surface
        assert np.array_equal(surface.vertices[surface.triangles], corners), name


@pytest.mark.skipif(not DATA.is_dir(), reason="shared data are not here")
def test_real_files_in_and_out(tmp_path: Path) -> None:
    files = sorted(DATA.glob("*.ts"))[::12]
    copies = []
    for file in files:
        surface = read_tsurf(file)[0].surface
        copies.append(tmp_path / file.name)
        write_tsurf(copies[-1], [surface], z="depth", properties={"x": surface.vertices[:, 0]})
    both = refereed(files + copies, tmp_path)
    for file, original, copy in zip(files, both[: len(files)], both[len(files) :], strict=True):
        surface = read_tsurf(file)[0].surface
        assert np.array_equal(surface.vertices[surface.triangles], original), file.name
        assert np.array_equal(surface.vertices[surface.triangles], copy), file.name
