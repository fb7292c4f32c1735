"""The 3D view of a run: horizons, faults, cutoffs, and the places that the page speaks of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.modeling.results import HorizonResult
from graben.reports.check_words import seen
from graben.reports.colouring import OPACITY, Painted, colourings, node_throws, throw_on
from graben.reports.scene import (
    FAULT_COLOURS,
    MOST_TRIANGLES,
    Group,
    Scene,
    Space,
    thinned_surface,
)
from graben.reports.style import FOOT, HANGING, Frame
from graben.reports.thinning import drawn
from graben.surface import Surface
from graben.words import plural

if TYPE_CHECKING:
    from graben.pipeline import RunResult

#: The view is full with so many times the triangles it is thinned to.
_OVERFULL = 2.0
#: Places that are drawn of each kind.
_MOST_PLACES = 500
#: What the switches of places are called together.
_PLACES = "Places"
#: Letters in a line of a hover text, and lines of it.
_LINE, _LINES = 60, 6
_SPOT = "#D500F9"


@dataclass(frozen=True, eq=False)
class Spot:
    """A place (3,) that the page speaks of: its switch in the view, number, words and colour."""

    kind: str
    number: int
    words: str
    place: FloatArray
    colour: str


def run_space(result: RunResult) -> Space | None:
    """Return the local coordinates of the view of a run, or None where there is nothing to see."""
    surfaces = _surfaces(result)
    return Space.around([s.vertices for s in surfaces], Frame.of(result.model)) if surfaces else None


def _surfaces(result: RunResult) -> list[Surface]:
    every = [h.surface for h in result.horizons] + [f.surface for f in result.repaired.faults]
    return [s for s in every if len(s.triangles) and np.isfinite(s.vertices).all()]


def scene(
    result: RunResult, moves: Mapping[str, FloatArray] | None = None, spots: Sequence[Spot] = ()
) -> Scene | None:
    """Return the 3D view of a run, or None where there is nothing to see.

    Parameters
    ----------
    result : RunResult
        A finished run.
    moves : mapping of str to (n,) array, optional
        By the name of a fault: how far repair moved each of its vertices, model units.
    spots : sequence of Spot, optional
        Places to mark.
    """
    space = run_space(result)
    if space is None:
        return None
    surfaces = _surfaces(result)
    whole = sum(len(s.triangles) for s in surfaces)
    view = _View(space, min(MOST_TRIANGLES / whole, 1.0))
    cut = any(h.cutoffs for h in result.horizons)
    for horizon in result.horizons:
        if any(s is horizon.surface for s in surfaces):
            view.horizon(horizon, shown=bool(horizon.cutoffs) or not cut)
    for number, fault in enumerate(f.surface for f in result.repaired.faults):
        if any(s is fault for s in surfaces):
            colour = FAULT_COLOURS[number % len(FAULT_COLOURS)]
            view.fault(fault, colour, throw_on(result.horizons, fault), (moves or {}).get(fault.name))
    for kind in dict.fromkeys(s.kind for s in spots):
        view.places(kind, [s for s in spots if s.kind == kind][:_MOST_PLACES])
    return view.scene(whole)


@dataclass
class _View:
    """What is drawn so far; ``share`` of the triangles of each surface is kept."""

    space: Space
    share: float
    data: list[dict[str, Any]] = field(default_factory=list)
    groups: list[Group] = field(default_factory=list)
    meshes: list[int] = field(default_factory=list)
    painted: list[Painted] = field(default_factory=list)
    veiled: list[int] = field(default_factory=list)
    shown: int = 0
    missing: int = 0

    def _add(self, triangles: IntArray) -> bool:
        """Count a surface of so many triangles, and return whether there is room for it."""
        if self.shown + len(triangles) > _OVERFULL * MOST_TRIANGLES:
            self.missing += 1
            return False
        self.shown += len(triangles)
        self.meshes.append(len(self.data))
        return True

    def horizon(self, result: HorizonResult, shown: bool) -> None:
        """Add a horizon with its cutoffs; one that is not ``shown`` is switched off to begin with."""
        kept, triangles = _thinned(result, self.share)
        if not self._add(triangles):
            return
        points = result.surface.vertices
        move = np.linalg.norm(points - result.first, axis=1)
        throw = node_throws(result) if result.cutoffs else np.zeros(len(points))
        self.painted.append(
            Painted(throw[kept], move[kept], points[kept, 2], result.subdomain[kept].astype(np.float64))
        )
        self.veiled.append(len(self.data))
        name = seen(result.name)
        style: dict[str, Any] = {"coloraxis": "coloraxis", **({} if shown else {"visible": False})}
        self.data.append(self.space.mesh(name, points[kept], triangles, **style))
        self.data += _lips(result, self.space)
        traces = tuple(range(self.meshes[-1], len(self.data)))
        self.groups.append(Group("Horizons", name, traces, shown=shown))

    def fault(self, fault: Surface, colour: str, throw: FloatArray | None, move: FloatArray | None) -> None:
        """Add a fault."""
        kept, triangles = thinned_surface(fault, self.share)
        if not self._add(triangles):
            return
        moved = move if move is not None and len(move) == len(fault.vertices) else None
        self.painted.append(
            Painted(
                None if throw is None else throw[kept], np.zeros(len(kept)) if moved is None else moved[kept]
            )
        )
        style = {"color": colour, "opacity": OPACITY, "flatshading": True, "coloraxis": "coloraxis"}
        name = seen(fault.name)
        self.groups.append(Group("Faults", name, (len(self.data),), colour))
        self.data.append(self.space.mesh(name, fault.vertices[kept], triangles, **style))

    def places(self, kind: str, spots: Sequence[Spot]) -> None:
        """Add the places of one kind as numbered diamonds."""
        marker = {
            "size": 5,
            "symbol": "diamond",
            "color": [s.colour for s in spots],
            "line": {"color": "#FFFFFF", "width": 1},
        }
        where = f"%{{hovertext}}<br>%{{x}}, %{{y}}, {self.space.frame.z_name} %{{z}}<extra></extra>"
        self.groups.append(Group(_PLACES, kind, (len(self.data),), spots[0].colour))
        self.data.append(
            self.space.points(
                kind,
                np.stack([s.place for s in spots]),
                marker=marker,
                hovertext=[_hover(s) for s in spots],
                hovertemplate=where,
            )
        )

    def scene(self, whole: int) -> Scene:
        """Return the view; ``whole`` is how many triangles there are."""
        note = ""
        if self.shown < whole:
            left = f" {plural(self.missing, 'surface')} left out." if self.missing else ""
            note = (
                f"Thinned for this view to {self.shown:,} of {whole:,} triangles; "
                f"rims and cutoffs are whole, and the files hold every triangle.{left}"
            )
        if not all(g.shown for g in self.groups):
            note = f"Horizons that no fault cuts are switched off to begin with. {note}".rstrip()
        colours = colourings(self.painted, self.space.frame)
        layout = self.space.layout()
        if colours:
            first = next(iter(colours.values()))
            layout["coloraxis"] = first["axis"]
            for mesh, values, opacity in zip(self.meshes, first["values"], first["opacity"], strict=True):
                self.data[mesh] |= {} if values is None else {"intensity": values}
                self.data[mesh] |= {} if opacity is None else {"opacity": opacity}
        spot = {"size": 16, "symbol": "circle-open", "color": _SPOT, "line": {"width": 3}}
        self.data.append(
            self.space.points("the place", floats([], 0, 3), marker=spot, visible=False, hoverinfo="skip")
        )
        return Scene(
            self.data,
            layout,
            self.groups,
            self.space.exaggeration,
            colours,
            self.meshes,
            self.veiled,
            spot=len(self.data) - 1,
            note=note,
        )


def _hover(spot: Spot) -> str:
    """Return what stands at a place: text for plotly.js, which reads a little HTML."""
    words = seen(f"{spot.number}. {spot.words}")
    return "<br>".join(escape(line) for line in wrap(words, _LINE, max_lines=_LINES, placeholder=" …"))


def _thinned(result: HorizonResult, share: float) -> tuple[IntArray, IntArray]:
    """Return a horizon with about ``share`` of its triangles, see :func:`thinned_surface`."""
    surface = result.surface
    triangles, _ = drawn(result, surface.triangles)
    if len(triangles) == len(surface.triangles):
        return thinned_surface(surface, share)
    used, local = np.unique(triangles, return_inverse=True)
    part = Surface(surface.name, surface.vertices[used], ints(local, -1, 3))
    kept, thin = thinned_surface(part, share * len(surface.triangles) / len(triangles))
    return used[kept], thin


def _lips(result: HorizonResult, space: Space) -> list[dict[str, Any]]:
    """Return the cutoffs of a horizon as two traces of lines."""
    if not result.cutoffs:
        return []
    return [
        space.lines(
            seen(f"{result.name}, {side} cutoff"),
            [getattr(c, side) for c in result.cutoffs],
            line={"color": colour, "width": 5},
        )
        for side, colour in (("hanging", HANGING), ("foot", FOOT))
    ]
