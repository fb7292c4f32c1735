"""The pictures of a run's report: maps, sections and profiles of each horizon, and those of each fault."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from graben.arrays import FloatArray
from graben.modeling.results import HorizonResult
from graben.modeling.throws import FaultThrow
from graben.reports.check_parts import told
from graben.reports.convergence import run_convergence_figure
from graben.reports.figures import throw_figure
from graben.reports.juxtaposition import juxtaposition_figure
from graben.reports.page import Picture, Room
from graben.reports.plan_map import detail_window, map_figure
from graben.reports.section import section_figure, section_place
from graben.reports.stereonet import stereonet_figure
from graben.reports.style import Frame
from graben.reports.throw_profiles import throw_profile_figure

if TYPE_CHECKING:
    from graben.pipeline import RunResult

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
        stereonet = stereonet_figure([f.surface for f in self.result.repaired.faults])
        found: dict[str, Any] = {"stereonet": None, "convergence": None}
        found["maps"] = {h.name: self._maps(h) for h in self.result.horizons if h.name in self.mapped}
        if stereonet is not None:
            alt = "Equal-area net of the poles of the faults with mean planes, and a rose of their strikes."
            said = "Lower hemisphere, equal area: poles of fault triangles, mean planes; strikes by area."
            found["stereonet"] = self.room.picture(stereonet, alt, said, drawing=False)
        course = run_convergence_figure(self.result.horizons, self.result.model.tolerance, self.frame)
        if course is not None:
            alt = "Largest change of the cutoffs in each iteration, a line for each subdomain."
            said = "Largest change ε of a cut node in each iteration; a line for each subdomain."
            found["convergence"] = self.room.picture(course, alt, said)
        found["horizons"] = {
            h.name: self._horizon(h) for h in self.result.horizons if h.name in self.sectioned
        }
        surfaces = {f.name: f.surface for f in self.result.repaired.faults}
        found["faults"] = {name: self._fault(surfaces[name]) for name in self.drawn if name in surfaces}
        return found

    def _maps(self, result: HorizonResult) -> list[Picture]:
        drawing = len(result.surface.triangles) <= _DRAWN
        faults = list(dict.fromkeys(c.fault for c in result.cutoffs))
        name = told(result.name)
        what = f"Structure map of {name} in plan"
        cut = f", cut by {told(', '.join(faults))}" if faults else ""
        caption = f"{name}: contours of {self.frame.z_name}."
        caption += " Numbers along the faults: throw." if faults else " No fault cuts it."
        figure = map_figure(result, self.frame)
        pictures = [self.room.picture(figure, f"{what}{cut}.", caption, drawing, _MAP)]
        window = detail_window(result, _MARGIN * self._gamma(result))
        if window is not None:
            detail, alt = map_figure(result, self.frame, window), f"{what}, detail at the faults."
            pictures.append(self.room.picture(detail, alt, "The same, at the faults.", drawing, _MAP))
        return [p for p in pictures if p is not None]

    def _horizon(self, result: HorizonResult) -> dict[str, list[Picture]]:
        """Return the first section and the throw along each cutoff, then the other sections."""
        sections = self._sections(result)
        alt = f"Throw of {told(result.name)} along its cutoffs."
        figure = throw_figure(result, self.frame, self.truth.get(result.name, ()))
        known = " Dotted: the true throw." if len(self.truth.get(result.name, ())) else ""
        throw = self.room.picture(figure, alt, f"Throw and heave along each trace.{known}")
        first = [*sections[:1], *([throw] if throw is not None else [])]
        return {"figures": first, "more": sections[1:]}

    def _sections(self, result: HorizonResult) -> list[Picture]:
        """Return a section across each fault where its throw is largest, the fault of largest throw first."""
        names = dict.fromkeys(c.fault for c in result.cutoffs)
        places = [
            place
            for name in names
            if (place := section_place(result, name, self._gamma(result, name))) is not None
        ]
        places.sort(key=lambda place: -abs(float(place[0].throw[place[1]])))
        pictures = []
        for cutoff, row in places[:_MOST_SECTIONS]:
            half = _SECTION * self._gamma(result, cutoff.fault)
            figure = section_figure(result, cutoff, row, self.result.repaired.faults, self.frame, half)
            throw, fault = self.frame.length(float(cutoff.throw[row])), told(cutoff.fault)
            alt = f"Vertical section of {told(result.name)} across {fault} near its largest throw, {throw}."
            caption = f"Section across {fault} near its largest throw, off other faults."
            pictures.append(self.room.picture(figure, alt, caption))
        return [p for p in pictures if p is not None]

    def _fault(self, surface: Any) -> list[Picture]:
        """Return the throw profile of a fault, and what meets across it where it cuts several horizons."""
        name = told(surface.name)
        pictures = []
        cutting = {h.name for h in self.result.horizons for c in h.cutoffs if c.fault == surface.name}
        profile = throw_profile_figure(self.result.horizons, surface, self.frame)
        if profile is not None and len(cutting) > 1:
            alt = f"Throw along the strike of {name}, a line for each horizon."
            said = (
                "Throw along strike, a line for each horizon. Rings: ends with throw, at exits and junctions."
            )
            pictures.append(self.room.picture(profile, alt, said))
        allan = juxtaposition_figure(self.result.horizons, surface, self.frame)
        if allan is not None:
            alt = f"Allan diagram of {name}: cutoffs of both walls, and which layers meet across it."
            said = "Allan diagram: layers of the footwall filled, of the hanging wall hatched."
            pictures.append(self.room.picture(allan, alt, said))
        return [p for p in pictures if p is not None]

    def _gamma(self, result: HorizonResult, fault: str | None = None) -> float:
        """Return gamma of one fault or the largest on a horizon, model units."""
        faults = [f for f in self.result.repaired.faults if fault in (None, f.name)]
        gammas = (self.result.model.gamma(f, result.horizon) for f in faults)
        return max(gammas, default=4.0 * result.horizon.step)
