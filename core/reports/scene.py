"""What every 3D view is made of: meshes, lines and points as plain values for plotly.js.

Coordinates are local, so that the single precision of WebGL is enough; the axes name the offset. Names are
escaped, since plotly.js reads a little HTML in them.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from graben.arrays import FloatArray, IntArray
from graben.reports.style import Frame, plain_numbers
from graben.surface import Surface

#: Above so many triangles in all, surfaces are thinned for the view; smaller ones than the second stay.
MOST_TRIANGLES = 60_000
_SMALL = 1_500
_EXAGGERATIONS = (1, 2, 3, 5, 10, 20)
#: Height of the model over its longer side in plan that the first exaggeration aims at.
_HEIGHT = 0.35
FAULT_COLOURS = ("#8C8C8C", "#B08D57", "#6C8EAD", "#9B7FA8", "#7F9B72", "#A3A3A3")
_LIGHT = {"ambient": 0.72, "diffuse": 0.5, "specular": 0.05, "roughness": 0.9}


@dataclass(frozen=True)
class Group:
    """Traces that are shown and hidden together: what kind they are, their name and their indices.

    ``colour`` is what stands beside the name, if anything; ``shown`` whether the view opens with them.
    """

    kind: str
    label: str
    traces: tuple[int, ...]
    colour: str = ""
    shown: bool = True


@dataclass(frozen=True)
class Scene:
    """What the page needs to draw: traces and layout for plotly.js, colourings, and a note.

    ``colourings`` maps a name to {"values": an array or None for each of ``meshes``, "axis": coloraxis}; a
    surface without values keeps its own colour. ``veiled`` are the traces that the reader may make
    see-through, ``veil`` is how opaque they are to begin with, percent. ``exaggerations`` are the choices,
    ``exaggeration`` the one set; ``spot`` is the trace that marks a place asked for, if there is one.
    """

    data: list[dict[str, Any]]
    layout: dict[str, Any]
    groups: list[Group]
    exaggeration: int
    colourings: dict[str, dict[str, Any]] = field(default_factory=dict)
    meshes: list[int] = field(default_factory=list)
    veiled: list[int] = field(default_factory=list)
    veil: int = 100
    exaggerations: tuple[int, ...] = _EXAGGERATIONS
    spot: int | None = None
    note: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Return what the script of the page reads."""
        return {
            "data": self.data,
            "layout": self.layout,
            "colourings": self.colourings,
            "meshes": self.meshes,
            "veiled": self.veiled,
            "exaggeration": self.exaggeration,
            "spot": self.spot,
        }

    @property
    def kinds(self) -> list[tuple[str, list[Group]]]:
        """The groups by their kind, in order."""
        names = dict.fromkeys(g.kind for g in self.groups)
        return [(name, [g for g in self.groups if g.kind == name]) for name in names]


@dataclass(frozen=True, eq=False)
class Space:
    """The local coordinates of a view: z in the model's own convention.

    Parameters
    ----------
    low, high : (3,) array
        Bounds, model units, z elevation.
    frame : Frame
        Unit and sign of z.
    """

    low: FloatArray
    high: FloatArray
    frame: Frame

    @classmethod
    def around(cls, points: Sequence[FloatArray], frame: Frame) -> Space:
        """Return the space of several arrays (n, 3), not all empty."""
        full = [p for p in points if len(p)]
        low, high = (
            np.min([p.min(axis=0) for p in full], axis=0),
            np.max([p.max(axis=0) for p in full], axis=0),
        )
        return cls(low, high, frame)

    @property
    def offset(self) -> FloatArray:
        """What the view's x and y leave out, shape (3,), model units."""
        return np.append(np.floor((self.low + self.high)[:2] / 2), 0.0)

    def local(self, points: FloatArray) -> FloatArray:
        """Return points (n, 3) in the coordinates of the view."""
        return np.asarray((points - self.offset) * [1.0, 1.0, self.frame.z_factor])

    def _ratio(self) -> FloatArray:
        size = self.high - self.low
        return np.asarray(size / max(float(size[:2].max()), np.finfo(np.float64).tiny))

    @property
    def exaggeration(self) -> int:
        """The vertical exaggeration to begin with."""
        height = float(self._ratio()[2])
        return max((e for e in _EXAGGERATIONS if e * height <= _HEIGHT), default=1)

    def layout(self) -> dict[str, Any]:
        """Return the layout of the view: axes, proportions and camera."""
        written = plain_numbers()
        low, high = self.low - self.offset, self.high - self.offset
        axes: dict[str, Any] = {}
        for k, key in enumerate("xy"):
            away = float(self.offset[k])
            shift = f" {'−' if away > 0 else '+'} {written(abs(away))}" if away else ""
            axes[f"{key}axis"] = {
                "title": {"text": self.frame.label(f"{key}{shift}")},
                "range": [float(low[k]), float(high[k])],
            }
        heights = (
            [float(low[2]), float(high[2])] if self.frame.z_factor > 0 else [float(-low[2]), float(-high[2])]
        )
        axes["zaxis"] = {"title": {"text": self.frame.label(self.frame.z_name)}, "range": heights}
        for axis in axes.values():
            axis.update(
                {"exponentformat": "none", "separatethousands": False, "tickformat": "~f", "nticks": 6}
            )
        ratio = self._ratio()
        aspect = {"x": float(ratio[0]), "y": float(ratio[1]), "z": float(ratio[2]) * self.exaggeration}
        camera = {"eye": {"x": -0.78, "y": -1.17, "z": 0.78}, "center": {"x": 0, "y": 0, "z": -0.1}}
        return {
            "scene": {**axes, "aspectmode": "manual", "aspectratio": aspect, "camera": camera},
            "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
            "showlegend": False,
            "uirevision": "kept",
            "paper_bgcolor": "rgba(0,0,0,0)",
        }

    def mesh(self, name: str, points: FloatArray, triangles: IntArray, **style: object) -> dict[str, Any]:
        """Return a trace of triangles (m, 3) between points (n, 3)."""
        kind = "u2" if len(points) < 2**16 else "u4"
        return {
            "type": "mesh3d",
            **self._coordinates(points),
            **{key: encoded(triangles[:, k], kind) for k, key in enumerate("ijk")},
            "name": escape(name),
            "lighting": _LIGHT,
            "hovertemplate": f"%{{x}}, %{{y}}, {self.frame.z_name} %{{z}}",
            **style,
        }

    def lines(self, name: str, pieces: Sequence[FloatArray], **style: object) -> dict[str, Any]:
        """Return a trace of polylines, each (k, 3)."""
        gap = np.full((1, 3), np.nan)  # undefined between pieces
        points = np.concatenate([part for piece in pieces for part in (piece, gap)])
        return {
            "type": "scatter3d",
            "mode": "lines",
            **self._coordinates(points),
            "name": escape(name),
            "hoverinfo": "name",
            **style,
        }

    def points(self, name: str, points: FloatArray, **style: object) -> dict[str, Any]:
        """Return a trace of markers at points (n, 3)."""
        return {
            "type": "scatter3d",
            "mode": "markers",
            **self._coordinates(points),
            "name": escape(name),
            **style,
        }

    def _coordinates(self, points: FloatArray) -> dict[str, dict[str, str]]:
        local = self.local(points)
        return {key: encoded(local[:, k], "f4") for k, key in enumerate("xyz")}


def thinned_surface(surface: Surface, share: float) -> tuple[IntArray, IntArray]:
    """Return a surface with about ``share`` of its triangles; its boundary, lips included, stays whole.

    Returns
    -------
    kept : (k,) array
        The vertices that remain, none of them moved.
    triangles : (m, 3) array
        Indices into ``kept``.
    """
    if share >= 1.0 or len(surface.triangles) <= _SMALL:
        return np.arange(len(surface.vertices)), surface.triangles
    # VTK computes in single precision: large coordinates first lose their offset.
    mesh = surface.moved(-surface.vertices.mean(axis=0)).to_pyvista()
    mesh.point_data["index"] = np.arange(len(surface.vertices))
    mesh = mesh.decimate_pro(1.0 - share, preserve_topology=True, boundary_vertex_deletion=False)
    return np.asarray(mesh.point_data["index"], dtype=np.int64), mesh.regular_faces.astype(np.int64)


def encoded(values: ArrayLike, kind: str) -> dict[str, str]:
    """Return an array as plotly.js takes it in few bytes: its type, such as "f4", and base64."""
    content = np.ascontiguousarray(values).astype(f"<{kind}")
    return {"dtype": kind, "bdata": base64.b64encode(content.tobytes()).decode("ascii")}
