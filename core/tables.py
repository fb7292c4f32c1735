"""What a run found, as pandas tables: cutoffs, throws, misfit, iterations. z is elevation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from graben.cutgraph import NodeKind
from graben.modeling.throws import Along, along, fault_throws

if TYPE_CHECKING:
    import pandas

    from graben.model import Model
    from graben.modeling.results import HorizonResult

#: Columns of a table of cutoffs that follow those of all cutoff files.
ALONG = ("dip", "azimuth", "type", "node", "piece")


class Run(Protocol):
    """A finished run."""

    @property
    def repaired(self) -> Model:
        """What was modeled."""

    @property
    def horizons(self) -> tuple[HorizonResult, ...]:
        """The rebuilt horizons."""


def along_columns(lines: Iterable[Along], tolerance: float) -> dict[str, list[list[tuple[Any, Any]]]]:
    """Return the columns ``ALONG`` of cutoffs: for each line a pair (hanging, foot) for each pair of rows.

    Parameters
    ----------
    lines : iterable of Along
        Of :func:`graben.modeling.throws.along`.
    tolerance : float
        Throws up to this are of no type, model units.
    """
    found: dict[str, list[list[tuple[Any, Any]]]] = {name: [] for name in ALONG}
    for line in lines:
        nodes = [NodeKind(kind).name.lower() for kind in line.kinds.tolist()]
        senses: list[Any] = [str(sense) for sense in line.senses(tolerance)]
        both: tuple[list[Any], ...] = (senses, nodes, [line.piece] * len(nodes))
        found["dip"].append([(h, f) for h, f in line.dip.tolist()])
        found["azimuth"].append([(h, f) for h, f in line.azimuth.tolist()])
        for name, values in zip(ALONG[2:], both, strict=True):
            found[name].append([(value, value) for value in values])
    return found


def cutoffs_table(run: Run) -> pandas.DataFrame:
    """Return all cutoffs of a run: the rows of the files in cutoffs/, after the name of their horizon.

    Rows come in pairs (hanging, foot) with the same s, throw and heave; lengths in model units, angles in
    degrees. ``type`` is normal, reverse or none, ``node`` what the pair is on the cut graph.
    """
    columns = ["horizon", "fault", "side", "s", "x", "y", "z", "throw", "heave", *ALONG]
    rows: list[tuple[Any, ...]] = []
    for result in run.horizons:
        lines = along(result, [f.surface for f in run.repaired.faults])
        more = along_columns(lines, run.repaired.tolerance)
        for k, line in enumerate(lines):
            c = line.cutoff
            pairs = list(zip(*(more[name][k] for name in ALONG), strict=True))
            numbers = list(zip(c.s.tolist(), c.throw.tolist(), c.heave.tolist(), strict=True))
            for i, (s, throw, heave) in enumerate(numbers):
                for side, (name, lip) in enumerate((("hanging", c.hanging), ("foot", c.foot))):
                    further = (pair[side] for pair in pairs[i])
                    rows.append((result.name, c.fault, name, s, *lip[i].tolist(), throw, heave, *further))
    return _table(rows, columns)


def throws_table(run: Run) -> pandas.DataFrame:
    """Return one row for each fault on each horizon: length, throw, heave, dip, type, and throw over length.

    ``x``, ``y``, ``z`` is where the throw is largest, ``ends`` what the ends of its pieces are; lengths in
    model units, ``dip`` in degrees.
    """
    columns = ["horizon", "fault", "pieces", "ends", "length", "throw", "mean_throw", "heave", "ratio"]
    columns += ["dip", "type", "changes", "x", "y", "z"]
    faults = [f.surface for f in run.repaired.faults]
    rows = []
    for result in run.horizons:
        for t in fault_throws(result, faults, run.repaired.tolerance):
            first = (t.horizon, t.fault, t.pieces, "; ".join(t.ends), t.length, t.throw, t.mean, t.heave)
            rows.append((*first, t.ratio, t.dip, str(t.sense), len(t.changes), *t.place.tolist()))
    return _table(rows, columns)


def doubts_table(run: Run) -> pandas.DataFrame:
    """Return where throws are doubtful, one row for each place: see :mod:`graben.modeling.quality`."""
    columns = ["horizon", "fault", "doubt", "value", "largest", "x", "y", "z", "message"]
    found = [d for result in run.horizons for d in result.doubts]
    rows = [
        (d.horizon, d.fault, str(d.kind), d.value, d.largest, *d.place.tolist(), d.message) for d in found
    ]
    return _table(rows, columns)


def misfit_table(run: Run) -> pandas.DataFrame:
    """Return input less rebuilt horizon by distance from each fault: see :mod:`graben.modeling.misfit`.

    Within gamma the input is smeared, and large differences next to a fault are what the rebuilding is for.
    """
    columns = ["horizon", "fault", "near", "far", "count", "gap", "mean", "rms", "largest"]
    found = [b for result in run.horizons if result.misfit for b in result.misfit.bins]
    return _table([tuple(getattr(b, name) for name in columns) for b in found], columns)


def masked_table(run: Run) -> pandas.DataFrame:
    """Return how many input points lie within gamma of each fault, and how many of them were left out."""
    columns = ["horizon", "fault", "what", "within", "left_out"]
    found = [m for result in run.horizons if result.misfit for m in result.misfit.masked]
    return _table([tuple(getattr(m, name) for name in columns) for m in found], columns)


def iterations_table(run: Run) -> pandas.DataFrame:
    """Return one row for each iteration of each subdomain; ``change`` is eps_k of the paper, model units.

    ``type`` is the termination type of the subdomain, the same in all its rows. A subdomain that was not
    iterated has none.
    """
    columns = ["horizon", "subdomain", "faults", "iteration", "change", "type"]
    rows = [
        (result.name, s.id, "; ".join(s.faults), k, change, int(s.termination.type))
        for result in run.horizons
        for s in result.subdomains
        for k, change in enumerate(s.history, start=1)
    ]
    return _table(rows, columns)


def _table(rows: Sequence[tuple[Any, ...]], columns: list[str]) -> pandas.DataFrame:
    import pandas

    return pandas.DataFrame(list(rows), columns=columns)
