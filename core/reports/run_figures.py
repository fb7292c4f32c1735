"""The pictures of a run's report: maps, sections and profiles of each horizon, and those of each fault."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from graben.arrays import FloatArray
from graben.beside import shared
from graben.modeling.results import HorizonResult
from graben.modeling.throws import FaultThrow
from graben.reports.check_parts import told
from graben.reports.convergence import run_convergence_figure
from graben.reports.figures import throw_figure
from graben.reports.images import Printed, Prints
from graben.reports.juxtaposition import juxtaposition_figure
from graben.reports.map_labels import lettering
from graben.reports.map_parts import bounds
from graben.reports.page import Picture, Room
from graben.reports.plan_map import detail_window, map_figure
from graben.reports.section import section_figure, section_place
from graben.reports.stereonet import stereonet_figure
from graben.reports.style import Frame
from graben.reports.thinning import MOST_DRAWN, drawn
from graben.reports.throw_profiles import throw_profile_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from graben.pipeline import RunResult
    from graben.surface import Surface

#: True throws at the rows of the cutoffs of each horizon, where a truth is known.
Truth = Mapping[str, Sequence[FloatArray]]

#: Meshes of more triangles are too large as drawings.
_DRAWN = 12_000
_MAP = 3  # shares of a map
#: A section reaches this many gammas to each side; a detail map shows so many around the faults.
_SECTION, _MARGIN = 2.0, 2.0
_MOST_SECTIONS = 4
#: Horizons with maps, horizons with sections, and faults with figures of their own.
_MOST_MAPS, _MOST_HORIZONS, _MOST_FAULTS = 24, 16, 24


@dataclass(frozen=True)
class Sketch:
    """A picture to come.

    ``draw`` returns its figure, or None where there is nothing to draw; ``alt`` and ``caption`` as of
    :class:`Picture`, ``drawing`` and ``weight`` as of :meth:`Room.picture`.
    """

    draw: Callable[[], Figure | None]
    alt: str
    caption: str
    drawing: bool = True
    weight: int = 1


class RunFigures:
    """Draws the pictures of a run into a limited room.

    Parameters
    ----------
    result : RunResult
        A finished run.
    frame : Frame
        Unit and sign of z.
    truth : mapping of str to sequence of (k,) arrays
        See :data:`Truth`.
    throws : sequence of FaultThrow
        Every fault on every horizon.
    room : int
        Bytes of all pictures.
    """

    def __init__(
        self, result: RunResult, frame: Frame, truth: Truth, throws: Sequence[FaultThrow], room: int
    ) -> None:
        self.result, self.frame, self.truth = result, frame, truth
        largest = {h.name: h.largest_throw for h in result.horizons}
        ranked = sorted(result.horizons, key=lambda h: -largest[h.name])
        self.mapped = [h.name for h in ranked[:_MOST_MAPS]]
        self.sectioned = [h.name for h in ranked[:_MOST_HORIZONS] if h.cutoffs]
        by_fault: dict[str, float] = {}
        for t in throws:
            by_fault[t.fault] = max(by_fault.get(t.fault, 0.0), abs(t.throw))
        self.faults = sorted(by_fault, key=lambda name: -by_fault[name])
        self.drawn = self.faults[:_MOST_FAULTS]
        count = 2 + 2 * _MAP * len(self.mapped)
        count += (_MOST_SECTIONS + 1) * len(self.sectioned) + 2 * len(self.drawn)
        self.room = Room(room, count)

    def all(self) -> dict[str, Any]:
        """Return every picture: those of horizons and faults by their names, and two of the whole run."""
        sketches = self._sketches()
        made = self._pictures([sketch for own in sketches.values() for sketch in own])
        ends = iter(made)
        pictures = {key: [p for _ in own if (p := next(ends)) is not None] for key, own in sketches.items()}
        found: dict[str, Any] = {
            key: next(iter(pictures[key, ""]), None) for key in ("stereonet", "convergence")
        }
        found["maps"] = {name: own for (kind, name), own in pictures.items() if kind == "map"}
        # The first section and the throw along each cutoff, then the other sections.
        found["horizons"] = {
            name: {"figures": [*own[:1], *pictures["throw", name]], "more": own[1:]}
            for (kind, name), own in pictures.items()
            if kind == "section"
        }
        found["faults"] = {name: own for (kind, name), own in pictures.items() if kind == "fault"}
        return found

    def _sketches(self) -> dict[tuple[str, str], list[Sketch]]:
        """Return what is to be drawn, by its kind and the name of a horizon or fault, in the room's order."""
        results = self.result.horizons
        found = {("map", h.name): self._maps(h) for h in results if h.name in self.mapped}
        found["stereonet", ""] = [self._stereonet()]
        found["convergence", ""] = [self._convergence()]
        for h in results:
            if h.name in self.sectioned:
                found["section", h.name] = self._sections(h)
                found["throw", h.name] = [self._throws(h)]
        surfaces = {f.name: f.surface for f in self.result.repaired.faults}
        for name in self.drawn:
            if name in surfaces:
                found["fault", name] = self._fault(surfaces[name])
        return found

    def _pictures(self, sketches: Sequence[Sketch]) -> list[Picture | None]:
        """Return the pictures, drawn by two processes on a horizon that is large.

        What each may take of the room is known only when those before it are drawn. There they are drawn as
        if all came first, and again where that is too large or too small.
        """
        known: list[Printed] | list[None] = [None] * len(sketches)
        if sum(len(h.first) for h in self.result.horizons) > MOST_DRAWN:
            known = shared([partial(_printed, sketch, self.room.share(sketch.weight)) for sketch in sketches])
        return [
            self.room.picture(
                Prints(sketch.draw, printed), sketch.alt, sketch.caption, sketch.drawing, sketch.weight
            )
            for sketch, printed in zip(sketches, known, strict=True)
        ]

    def _maps(self, result: HorizonResult) -> list[Sketch]:
        drawing = len(result.surface.triangles) <= _DRAWN
        faults = list(dict.fromkeys(c.fault for c in result.cutoffs))
        name = told(result.name)
        what = f"Structure map of {name} in plan"
        cut = f", cut by {told(', '.join(faults))}" if faults else ""
        caption = f"{name}: contours of {self.frame.z_name}."
        unit = f", {self.frame.unit}" if self.frame.unit else ""
        caption += f" Numbers along the faults: throw{unit}." if faults else " No fault cuts it."
        caption += lettering(result, bounds(result.surface.vertices[:, :2])).words()
        caption += self._thinned(result)
        draw = partial(map_figure, result, self.frame)
        sketches = [Sketch(draw, f"{what}{cut}.", caption, drawing, _MAP)]
        window = detail_window(result, _MARGIN * self._gamma(result))
        if window is not None:
            alt, caption = f"{what}, detail at the faults.", "The same, at the faults."
            caption += lettering(result, window).words()
            sketches.append(Sketch(partial(draw, window), alt, caption, drawing, _MAP))
        return sketches

    def _thinned(self, result: HorizonResult) -> str:
        """Return what a caption says of a map of a horizon with fewer triangles; empty where it has all."""
        spacing = drawn(result, result.surface.triangles)[1]
        if not spacing:
            return ""
        apart = self.frame.length(spacing)
        return (
            f" Thinned for this picture to nodes about {apart} apart, but along faults and the rim; the "
            "files hold every node."
        )

    def _stereonet(self) -> Sketch:
        draw = partial(stereonet_figure, [f.surface for f in self.result.repaired.faults])
        alt = "Equal-area net of the poles of the faults with mean planes, and a rose of their strikes."
        said = "Lower hemisphere, equal area: poles of fault triangles, mean planes; strikes by area."
        return Sketch(draw, alt, said, drawing=False)

    def _convergence(self) -> Sketch:
        tolerance = self.result.model.tolerance
        draw = partial(run_convergence_figure, self.result.horizons, tolerance, self.frame)
        alt = "Largest change of the cutoffs in each iteration, a line for each subdomain."
        said = "Largest change ε of a cut node in each iteration; a line for each subdomain."
        return Sketch(draw, alt, said)

    def _throws(self, result: HorizonResult) -> Sketch:
        """Return the throw along each cutoff."""
        truth = self.truth.get(result.name, ())
        known = " Dotted: the true throw." if len(truth) else ""
        draw = partial(throw_figure, result, self.frame, truth)
        alt = f"Throw of {told(result.name)} along its cutoffs."
        return Sketch(draw, alt, f"Throw and heave along each trace.{known}")

    def _sections(self, result: HorizonResult) -> list[Sketch]:
        """Return a section across each fault where its throw is largest, the fault of largest throw first."""
        names = dict.fromkeys(c.fault for c in result.cutoffs)
        places = [
            place
            for name in names
            if (place := section_place(result, name, self._gamma(result, name))) is not None
        ]
        places.sort(key=lambda place: -abs(float(place[0].throw[place[1]])))
        sketches = []
        for cutoff, row in places[:_MOST_SECTIONS]:
            half = _SECTION * self._gamma(result, cutoff.fault)
            draw = partial(section_figure, result, cutoff, row, self.result.repaired.faults, self.frame, half)
            throw, fault = self.frame.length(float(cutoff.throw[row])), told(cutoff.fault)
            alt = f"Vertical section of {told(result.name)} across {fault} near its largest throw, {throw}."
            caption = f"Section across {fault} near its largest throw, off other faults."
            sketches.append(Sketch(draw, alt, caption))
        return sketches

    def _fault(self, surface: Surface) -> list[Sketch]:
        """Return the throw profile of a fault that cuts several horizons, and what meets across it."""
        if len({h.name for h in self.result.horizons for c in h.cutoffs if c.fault == surface.name}) < 2:
            return []
        name, given = told(surface.name), (self.result.horizons, surface, self.frame)
        profile = "Throw along strike, a line for each horizon."
        return [
            Sketch(
                partial(throw_profile_figure, *given),
                f"Throw along the strike of {name}, a line for each horizon.",
                f"{profile} Rings: ends with throw, at exits and junctions.",
            ),
            Sketch(
                partial(juxtaposition_figure, *given),
                f"Allan diagram of {name}: cutoffs of both walls, and which layers meet across it.",
                "Allan diagram: layers of the footwall filled, of the hanging wall hatched.",
            ),
        ]

    def _gamma(self, result: HorizonResult, fault: str | None = None) -> float:
        """Return gamma of one fault or the largest on a horizon, model units."""
        faults = [f for f in self.result.repaired.faults if fault in (None, f.name)]
        gammas = (self.result.model.gamma(f, result.horizon) for f in faults)
        return max(gammas, default=4.0 * result.horizon.step)


def _printed(sketch: Sketch, most: int) -> Printed:
    """Return what drawing a picture of about ``most`` bytes comes to."""
    prints = Prints(sketch.draw)
    prints.address(most, sketch.drawing)
    return prints.known
