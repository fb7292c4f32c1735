"""OpenGeode-Inspector as a program of its own: reads surfaces from an .npz, writes what it finds as JSON.

`python -m tests.validators.inspector IN.npz OUT.json`. Its objects refer to one another without owning one
another: mesh, builder, inspector and result must all be kept, else the process ends with a segmentation
fault. Its collections of issues have no length and are true when they are empty: ask for their issues.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from graben.surface import Surface

#: What it finds, by its own names.
ISSUES = (
    "colocated_points_groups",
    "degenerated_polygons",
    "intersecting_elements",
    "non_manifold_edges",
    "non_manifold_vertices",
    "polygon_edges_with_wrong_adjacency",
)


def mesh_of(vertices: np.ndarray, triangles: np.ndarray) -> tuple[Any, Any]:
    """Its mesh of a surface, with the builder that must be kept beside it."""
    import opengeode

    mesh = opengeode.TriangulatedSurface3D.create()
    builder = opengeode.TriangulatedSurfaceBuilder3D.create(mesh)
    for point in vertices.tolist():
        builder.create_point(opengeode.Point3D(point))
    for triangle in triangles.tolist():
        builder.create_triangle(triangle)
    builder.compute_polygon_adjacencies()
    return mesh, builder


def seconds(mesh: Any) -> float:
    """How long all its checks of a mesh take."""
    import opengeode_inspector

    opengeode_inspector.OpenGeodeInspectorInspectionLibrary.initialize()
    start = time.perf_counter()
    inspector = opengeode_inspector.SurfaceMeshInspector3D(mesh)
    result = inspector.inspect_surface()
    taken = time.perf_counter() - start
    del result, inspector
    return taken


def inspected(surfaces: Mapping[str, Surface], folder: Path) -> dict[str, dict[str, list]]:
    """What it finds on each surface, in a process of its own."""
    arrays = {}
    for name, surface in surfaces.items():
        arrays[f"{name}|vertices"], arrays[f"{name}|triangles"] = surface.vertices, surface.triangles
    source, target = folder / "surfaces.npz", folder / "issues.json"
    np.savez(source, **arrays)
    command = [sys.executable, "-m", "tests.validators.inspector", str(source), str(target)]
    subprocess.run(command, check=True, capture_output=True, cwd=Path(__file__).parents[2])
    found: dict[str, dict[str, list]] = json.loads(target.read_text())
    return found


def _issues(kept: list[Any], vertices: np.ndarray, triangles: np.ndarray) -> dict[str, list]:
    import opengeode_inspector

    mesh = mesh_of(vertices, triangles)
    inspector = opengeode_inspector.SurfaceMeshInspector3D(mesh[0])
    result = inspector.inspect_surface()
    found = {name: getattr(result, name) for name in ISSUES}
    kept += [mesh, inspector, result, found]
    return {name: [_plain(issue) for issue in found[name].issues()] for name in ISSUES}


def _plain(issue: Any) -> Any:
    if isinstance(issue, int):
        return issue
    if hasattr(issue, "polygon_id"):
        return [issue.polygon_id, issue.edge_id]
    return list(issue)


def main(source: str, target: str) -> None:
    import opengeode_inspector

    opengeode_inspector.OpenGeodeInspectorInspectionLibrary.initialize()
    kept: list[Any] = []
    with np.load(source) as arrays:
        names = [key.removesuffix("|vertices") for key in arrays.files if key.endswith("|vertices")]
        found = {n: _issues(kept, arrays[f"{n}|vertices"], arrays[f"{n}|triangles"]) for n in names}
    Path(target).write_text(json.dumps(found), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
