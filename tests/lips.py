"""How far a rebuilt horizon lies from the points it was made of, each lip compared with its own side."""

from __future__ import annotations

import igl
import numpy as np

from graben.arrays import FloatArray
from graben.model import Model
from graben.modeling.results import HorizonResult
from graben.surface import triangle_normals


def side_of(points: FloatArray, vertices: FloatArray, triangles: np.ndarray) -> np.ndarray:
    """1 above the fault, which is its hanging wall, -1 below it."""
    _, face, near = igl.point_mesh_squared_distance(points.copy(), vertices.copy(), triangles.copy())
    normal = triangle_normals(vertices, triangles)[face]
    normal = normal * np.where(normal[:, 2:] < 0, -1.0, 1.0)
    return np.where(((points - near) * normal).sum(axis=1) > 0, 1, -1)


def misfits(model: Model, result: HorizonResult) -> FloatArray:
    """|pick - horizon| of the picks within gamma of one fault alone, on the lip they belong to."""
    picks = result.horizon.picks
    surface, found = result.surface, []
    for k, name in enumerate(result.graph_faults):
        fault = next(f for f in model.faults if f.name == name)
        gamma = model.gamma(fault, result.horizon)
        lines = result.graph.nodes[result.graph.edges[result.graph.faults == model.faults.index(fault)]]
        nodes = np.unique(lines.reshape(-1, 3), axis=0)[:, :2]
        near = np.min(np.hypot(*(picks[:, None, :2] - nodes[None]).transpose(2, 0, 1)), axis=1) < gamma
        mine = picks[near]
        sides = side_of(mine, fault.surface.vertices, fault.surface.triangles)
        for side in (1, -1):
            block = result.block[surface.triangles]
            own = (block[:, :, k] == side).all(axis=1)
            flat = np.pad(surface.vertices[:, :2], ((0, 0), (0, 1)))
            at = np.pad(mine[sides == side][:, :2], ((0, 0), (0, 1)))
            triangles = surface.triangles[own]
            squared, face, _ = igl.point_mesh_squared_distance(at, flat, triangles.copy())
            inside = squared < 1e-12
            corners = [surface.vertices[triangles[face[inside], c]] for c in range(3)]
            a, b, c = corners
            p = at[inside][:, :2]
            m = np.stack([(b - a)[:, :2], (c - a)[:, :2]], axis=-1)
            st = np.linalg.solve(m, (p - a[:, :2])[..., None])[..., 0]
            z = a[:, 2] + st[:, 0] * (b - a)[:, 2] + st[:, 1] * (c - a)[:, 2]
            found.append(np.abs(z - mine[sides == side][inside][:, 2]))
    return np.concatenate(found)
