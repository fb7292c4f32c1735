"""A model as the figures of its examination draw it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from graben.arrays import FloatArray, floats
from graben.finding import Finding
from graben.reports.marks import Marks
from graben.reports.shapes import Shape, drawable, trace_of
from graben.reports.style import Frame

if TYPE_CHECKING:
    from graben.cutgraph import CutGraph
    from graben.model import Model
    from graben.pipeline import Examination

#: The objects of a finding, in their order: line and fill.
OBJECT_INKS = (("#0B4F8A", "#9CC3E6"), ("#0B6B4B", "#9AD3BC"), ("#6B3FA0", "#CDB8E6"))
#: Whatever else there is.
OTHER_INK = ("#8A8A8A", "#E4E4E4")
HORIZON_INK = "#4A5A3C"


@dataclass(frozen=True, eq=False)
class Scenery:
    """The surfaces and traces of a model, prepared once for all figures.

    Parameters
    ----------
    model : Model
        The model.
    graphs : mapping of str to CutGraph
        The traces on each horizon.
    shapes : mapping of str to Shape
        Its surfaces with something to draw, by name, in the model's order.
    """

    model: Model
    graphs: Mapping[str, CutGraph]
    shapes: Mapping[str, Shape]

    @classmethod
    def of(cls, examination: Examination) -> Scenery:
        """Return the scenery of an examination."""
        shapes = {s.name: Shape.of(s) for s in examination.model.surfaces}
        drawn = {name: shape for name, shape in shapes.items() if len(shape.surface.triangles)}
        return cls(examination.model, examination.graphs, MappingProxyType(drawn))

    @cached_property
    def frame(self) -> Frame:
        """Unit and sign of z."""
        return Frame.of(self.model)

    @cached_property
    def step(self) -> float:
        """What tells how many digits of a coordinate matter, model units."""
        return self.model.size / 100.0 or 1.0

    @cached_property
    def faults(self) -> Mapping[str, Shape]:
        """The faults that can be drawn."""
        names = {f.name for f in self.model.faults}
        return MappingProxyType({n: s for n, s in self.shapes.items() if n in names})

    @cached_property
    def horizons(self) -> Mapping[str, Shape]:
        """The horizons that can be drawn."""
        return MappingProxyType({n: s for n, s in self.shapes.items() if n not in self.faults})

    def marks(self, finding: Finding) -> Marks:
        """Return what a finding marks, worked out once."""
        if finding in self._known:
            return self._known[finding]
        first = next(iter(finding.objects), None)
        surface = next((s for s in self.model.surfaces if s.name == first), None)
        self._known[finding] = Marks.of(finding, surface)
        return self._known[finding]

    @cached_property
    def _known(self) -> dict[Finding, Marks]:
        return {}

    def trace(self, horizon: str, fault: str) -> FloatArray:
        """Return the trace of a fault on a horizon: ends of its edges, shape (k, 2, 3)."""
        index = next((k for k, f in enumerate(self.model.faults) if f.name == fault), -1)
        if horizon not in self.graphs:
            return floats([], 0, 2, 3)
        found = trace_of(self.graphs[horizon], index)
        return floats(found[drawable(found).all(axis=1)], -1, 2, 3)

    def inks(self, finding: Finding) -> dict[str, tuple[str, str]]:
        """Return line and fill of the faults that a finding is about."""
        named = [name for name in finding.objects if name in self.faults]
        return dict(zip(named, OBJECT_INKS, strict=False))

    @cached_property
    def places(self) -> FloatArray:
        """Every vertex that is drawn, shape (n, 3)."""
        return np.concatenate([s.surface.vertices for s in self.shapes.values()])
