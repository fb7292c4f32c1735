"""A finding on its fault face-on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import PathPatch
from matplotlib.ticker import MaxNLocator

from graben.reports.check_plan import View, draw_contours, edge_words, plain
from graben.reports.labels import write_labels
from graben.reports.map_parts import Window, strokes
from graben.reports.scenery import HORIZON_INK
from graben.reports.shapes import Shape, compass
from graben.reports.style import FAULT, plain_numbers
from graben.surface import Surface, triangle_dips

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize

#: More triangles than these in a panel have no lines between them.
_MOST_LINES = 1_500
_EDGE_INK = "#9AA3AA"


def face_panel(
    axes: Axes, view: View, shape: Shape, window: Window, scale: tuple[Colormap, Normalize]
) -> None:
    """Draw a fault face-on, coloured by dip, with structure contours, traces and the marks of a finding."""
    axes.set(xlim=window[:2], ylim=window[2:])
    face, surface = shape.face, _within(shape, window)
    corners = surface.vertices[surface.triangles]
    order = np.argsort(face.depth(corners.mean(axis=1)), kind="stable")  # the nearest last, over the others
    colours = scale[0](scale[1](triangle_dips(surface.vertices, surface.triangles)[order]))
    triangles = PolyCollection(list(face(corners)[order]), facecolors=colours, zorder=1)
    triangles.set(edgecolors=_EDGE_INK if len(corners) <= _MOST_LINES else colours, linewidths=0.25)
    axes.add_collection(triangles, autolim=False)
    rim = LineCollection([face(p) for p in shape.rim], colors=FAULT, linewidths=0.9, zorder=2)
    axes.add_collection(rim, autolim=False)
    draw_contours(axes, surface, face, view, window)
    for horizon in view.scenery.graphs:
        trace = strokes(face(view.scenery.trace(horizon, shape.surface.name)))
        width = 2.0 if horizon in view.finding.objects else 1.0
        axes.add_artist(PathPatch(trace, fill=False, ec=HORIZON_INK, lw=width, zorder=3))
    view.marks.draw(axes, face, view.inch(window))
    view.marks.draw_worst(axes, face)
    edge_words(axes, (compass(-face.along), compass(face.along)))
    axes.set_xlabel(view.frame.label("along strike"))
    axes.set_ylabel(view.frame.label("up dip"))
    numbered(axes)
    ring = None if view.marks.worst is None else face(view.marks.worst)
    write_labels(axes, view.marks.labels(face), view.extent, corners=True, ring=ring)


def _within(shape: Shape, window: Window) -> Surface:
    """Return the part of a fault in a window of its face: all its triangles there, or a thinned whole."""
    near = shape.within(shape.face, window)
    if len(near) > len(shape.drawn.triangles):
        return shape.drawn
    return Surface(shape.surface.name, shape.surface.vertices, near)


def numbered(axes: Axes) -> None:
    """Number both axes of a panel in model units."""
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
        axis.set_major_formatter(plain_numbers())
    plain(axes)
