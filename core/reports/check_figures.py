"""The picture of a finding: which ways to look at it, how much of the model, and what the caption says."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from graben.arrays import FloatArray
from graben.finding import Element, Finding
from graben.reports.check_faces import face_panel
from graben.reports.check_layout import TALLEST, Panel, Row, composed, dip_scale, framed, paper
from graben.reports.check_plan import View, plan, plan_panel
from graben.reports.check_sections import Section
from graben.reports.check_words import seen
from graben.reports.map_parts import Window
from graben.reports.marks import Marks, fitted, reach_of, window_of
from graben.reports.page import Picture, picture
from graben.reports.scenery import Scenery
from graben.reports.shapes import Shape, compass
from graben.reports.style import styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: A second panel shows the spot where the marks take less than this share of the first.
_SMALL = 0.3
#: A spot is shown with at least so many median edges, or steps of the horizon, to each side.
_EDGES, _STEPS = 4.0, 8.0
#: Around everything that a panel must show, over its reach; and around marks alone.
_MARGIN, _AROUND = 0.08, 0.3
#: Pictures of models of more triangles are too large as drawings.
_DRAWN = 8_000
#: A figure and what its caption says.
_Drawn = tuple["Figure", str]


def finding_picture(scenery: Scenery, finding: Finding, budget: int) -> Picture | None:
    """Return the picture of a finding, or None where it has no place that can be drawn.

    A fault alone is shown face-on, two faults in plan and in a section across the worst place, a horizon with
    a fault in plan and the fault face-on with its trace, anything else in plan. Picks are also shown in a
    section.

    Parameters
    ----------
    scenery : Scenery
        The model.
    finding : Finding
        One that fails or warns.
    budget : int
        Bytes it may take.
    """
    marks = scenery.marks(finding)
    if not len(marks.everything):
        return None
    faults = [scenery.faults[n] for n in finding.objects if n in scenery.faults]
    horizons = [n for n in finding.objects if n in scenery.horizons]
    if len(faults) == 1 and not horizons:
        figure, caption = _fault(scenery, finding, marks, faults[0])
    elif len(faults) > 1 and not horizons:
        figure, caption = _pair(scenery, finding, marks, faults)
    elif len(faults) == 1:
        figure, caption = _traced(scenery, finding, marks, faults[0])
    else:
        figure, caption = _mapped(scenery, finding, marks)
    if marks.worst is not None:
        caption += f" Ring: {scenery.frame.place(marks.worst, scenery.step)}."
    caption = seen(caption)
    alt = f"{finding.check}, {seen(', '.join(finding.objects)) or 'the model'}: {caption}"
    triangles = sum(len(s.surface.triangles) for s in scenery.shapes.values())
    return picture(figure, alt, caption, budget, triangles <= _DRAWN)


@styled
def _fault(scenery: Scenery, finding: Finding, marks: Marks, shape: Shape) -> _Drawn:
    """Return a fault face-on; the spot where that is small; a section across it where there is room."""
    whole = _face_window(shape)
    spot = _spot(shape.face(marks.everything), marks, shape, whole)
    scale = dip_scale(shape)
    section = Section.of(marks, [shape], None if spot is None else _width(spot) / 2)

    def face(window: Window) -> Panel:
        return lambda axes, extent: face_panel(
            axes, View(scenery, finding, marks, extent), shape, paper(window, extent), scale
        )

    def cross(axes: Axes, extent: tuple[float, float]) -> None:
        section.draw(axes, View(scenery, finding, marks, extent))

    ratio = _ratio(whole)
    said = f"{shape.surface.name} face-on, seen towards {compass(-shape.face.towards[:2])}, coloured by dip, "
    said += "with structure contours" + (
        f" and the traces of {', '.join(scenery.graphs)}" if scenery.graphs else ""
    )
    if spot is None:
        rows: list[Row] = [([face(whole)], ratio)] if ratio < TALLEST else [([face(whole), cross], 1.0)]
        said += "." if ratio < TALLEST else "; right: section across it at the ring."
    elif ratio < TALLEST:
        rows = [([face(whole)], ratio), ([face(spot), cross], 1.0)]
        said += "; below: the spot in the frame, and a section across it at the ring."
    else:
        rows, said = [([face(whole), face(spot)], 1.0)], f"{said}; right: the spot in the frame."
    figure = composed(rows, scale)
    if spot is not None:
        framed(figure.axes[0], fitted(spot, 1.0))
    return figure, said


@styled
def _pair(scenery: Scenery, finding: Finding, marks: Marks, shapes: list[Shape]) -> _Drawn:
    """Return faults in plan and a vertical section across the worst place."""
    around = plan(marks.everything)
    reach = max(_AROUND * reach_of(around), _EDGES * min(s.median_edge for s in shapes))
    window, section = window_of(around, reach), Section.of(marks, shapes, reach)

    def in_plan(axes: Axes, extent: tuple[float, float]) -> None:
        plan_panel(axes, View(scenery, finding, marks, extent), paper(window, extent))
        section.draw_line(axes)

    def cross(axes: Axes, extent: tuple[float, float]) -> None:
        section.draw(axes, View(scenery, finding, marks, extent))

    names = " and ".join(s.surface.name for s in shapes)
    level = scenery.frame.place(marks.at, scenery.step).rsplit(", ", 1)[1]
    thin = "; thin and olive: horizons" if scenery.horizons else ""
    said = f"Left: {names} in plan; thick: where they stand at {level}. Right: section along the dots{thin}."
    return composed([([in_plan, cross], 1.0)]), said


@styled
def _traced(scenery: Scenery, finding: Finding, marks: Marks, shape: Shape) -> _Drawn:
    """Return a horizon with a fault in plan, and the fault face-on with the trace; for picks a section."""
    horizon, name = next(n for n in finding.objects if n in scenery.horizons), shape.surface.name
    around = plan(np.concatenate([marks.everything, scenery.trace(horizon, name).reshape(-1, 3)]))
    window = window_of(around, max(_MARGIN * reach_of(around), _least(scenery, finding)))
    whole, scale = _face_window(shape), dip_scale(shape)
    section = None
    if finding.element is Element.PICK:
        section = Section.of(marks, [shape, scenery.horizons[horizon]], _least(scenery, finding))

    def in_plan(axes: Axes, extent: tuple[float, float]) -> None:
        plan_panel(axes, View(scenery, finding, marks, extent), paper(window, extent))
        if section is not None:
            section.draw_line(axes)

    def beside(axes: Axes, extent: tuple[float, float]) -> None:
        view = View(scenery, finding, marks, extent)
        if section is not None:
            section.draw(axes, view)
        else:
            face_panel(axes, view, shape, paper(whole, extent), scale)

    said = f"Left: {horizon} and {name} in plan. "
    if section is not None:
        said += "Right: section along the dots with the points nearby."
    else:
        said += f"Right: {name} face-on towards {compass(-shape.face.towards[:2])}, with its trace."
    return composed([([in_plan, beside], 1.0)], None if section is not None else scale), said


@styled
def _mapped(scenery: Scenery, finding: Finding, marks: Marks) -> _Drawn:
    """Return a map of the objects, with the spot where that is small, else a section; picks have both."""
    names = [n for n in finding.objects if n in scenery.shapes]
    shapes = [scenery.shapes[n] for n in sorted(names, key=lambda n: n in scenery.horizons)]  # faults first
    vertices = [s.surface.vertices for s in shapes] or [scenery.places]
    places, around = plan(np.concatenate([marks.everything, *vertices])), plan(marks.everything)
    whole = window_of(places, _MARGIN * reach_of(places))
    spot = window_of(around, max(_AROUND * reach_of(around), _least(scenery, finding)))
    section = Section.of(marks, shapes, _width(spot) / 2) if shapes else None

    def map_of(window: Window, dotted: Section | None = None) -> Panel:
        def draw(axes: Axes, extent: tuple[float, float]) -> None:
            plan_panel(axes, View(scenery, finding, marks, extent), paper(window, extent))
            if dotted is not None:
                dotted.draw_line(axes)

        return draw

    def cross(axes: Axes, extent: tuple[float, float]) -> None:
        assert section is not None
        section.draw(axes, View(scenery, finding, marks, extent))

    ratio, small = _ratio(whole), _width(spot) < _SMALL * _width(whole)
    said = f"{', '.join(names) or 'The model'} in plan"
    picked = finding.element is Element.PICK and section is not None
    if picked and small:
        rows: list[Row] = [([map_of(whole)], ratio), ([map_of(spot, section), cross], 1.0)]
        said += "; below: the spot in the frame, and a section along the dots with the points nearby."
    elif small:
        rows, said = [([map_of(whole), map_of(spot)], 1.0)], f"{said}; right: the spot in the frame."
    elif section is not None and (picked or ratio >= TALLEST):
        rows, said = [([map_of(whole, section), cross], 1.0)], f"{said}; right: section along the dots"
        said += ", with the points nearby." if picked else "."
    else:
        rows, said = [([map_of(whole)], ratio)], f"{said}."
    figure = composed(rows)
    if small:
        framed(figure.axes[0], fitted(spot, 1.0))
    return figure, said


def _face_window(shape: Shape) -> Window:
    return window_of(shape.face(shape.surface.vertices), _MARGIN * shape.median_edge)


def _spot(seen_at: FloatArray, marks: Marks, shape: Shape, whole: Window) -> Window | None:
    """Return the spot to show larger: all marks where they are near together, else the worst place."""
    least = _EDGES * shape.median_edge
    spot = window_of(seen_at, max(_AROUND * reach_of(seen_at), least))
    if _width(spot) >= _SMALL * _width(whole):
        spot = window_of(shape.face(marks.at[None]), 2 * least)
        if len(marks.everything) > 1 and marks.triangles.size and _share(marks, shape) > _SMALL**2:
            return None  # the whole shows it
    return spot if _width(spot) < _SMALL * _width(whole) else None


def _share(marks: Marks, shape: Shape) -> float:
    """Return the share of the triangles of a surface that are marked."""
    return len(marks.triangles) / max(len(shape.surface.triangles), 1)


def _width(window: Window) -> float:
    return max(window[1] - window[0], window[3] - window[2])


def _least(scenery: Scenery, finding: Finding) -> float:
    """Return how far a map reaches around the marks at least, model units."""
    steps = [h.step for h in scenery.model.horizons if h.name in finding.objects]
    edges = [s.median_edge for name, s in scenery.shapes.items() if name in finding.objects]
    return _STEPS * max(steps) if steps else _EDGES * max(edges, default=scenery.step)


def _ratio(window: Window) -> float:
    return (window[3] - window[2]) / (window[1] - window[0])
