"""The seven models of the paper's Table 2 as figures, and how the replica of each is laid out."""

from __future__ import annotations

from dataclasses import dataclass

from graben.words import plural

_KILOMETRE = 1000.0  # m


@dataclass(frozen=True)
class Replica:
    """A model of Table 2 and what its replica adds to the figures there.

    The domain is a sheet of equal cells. A dividing fault leaves it at both ends and takes a row of cells; it
    may be crossed by shorter ones. Every other cell holds one fault, two that cross, or one and its branch.

    Parameters
    ----------
    name : str
        As in Table 2.
    step : float
        Of the horizon's grid, m; from Table 2.
    faults, intersections : int
        From Table 2.
    least_dip, mean_dip : float
        Over the faults, degrees; from Table 2.
    across : int
        Cells in a row.
    cell : pair of float
        Width and height of a cell, m: whole steps.
    crossed : tuple of int
        For each dividing fault the number of faults that cross it.
    crossings, branchings : int
        Cells with two faults that cross, and with a fault and its branch.
    throws : pair of float
        Least and greatest vertical separation in the middle of a fault, m.
    meeting_throws : pair of float
        The same of faults that meet others: where two displace the horizon by more, smeared it is as steep
        as they are, and they have no clear traces.
    slope : float
        Of the undisplaced horizon.
    gamma : pair of float
        Least and greatest half-width of the zone of a fault, steps (paper Sect. 8).
    """

    name: str
    step: float
    faults: int
    intersections: int
    least_dip: float
    mean_dip: float
    across: int
    cell: tuple[float, float]
    crossed: tuple[int, ...]
    crossings: int = 0
    branchings: int = 0
    throws: tuple[float, float] = (60.0, 150.0)
    meeting_throws: tuple[float, float] = (60.0, 100.0)
    slope: float = 0.1
    gamma: tuple[float, float] = (3.0, 5.0)

    @property
    def about(self) -> str:
        """What it is, in one sentence."""
        wide, high = (extent / _KILOMETRE for extent in self.size)
        meet = f"{self.intersections or 'no'} intersection{'' if self.intersections == 1 else 's'}"
        return (
            f"replica of {self.name}: {plural(self.faults, 'fault')}, {meet}, dips from {self.least_dip:g}, "
            f"mean {self.mean_dip:g}, step {self.step:g} m, {wide:.1f} x {high:.1f} km"
        )

    @property
    def alone(self) -> int:
        """Cells with one fault."""
        return self.faults - len(self.crossed) - sum(self.crossed) - 2 * self.crossings - 2 * self.branchings

    @property
    def rows(self) -> int:
        """Rows of cells."""
        return len(self.crossed) + -(-(self.alone + self.crossings + self.branchings) // self.across)

    @property
    def size(self) -> tuple[float, float]:
        """Extent of the domain, m."""
        return self.across * self.cell[0], self.rows * self.cell[1]


#: Step (m), faults, intersections, least and mean dip (degrees).
TABLE_2 = {
    "Fang": (200.0, 4, 0, 33.0, 44.0),
    "Bohai": (150.0, 7, 2, 35.0, 41.0),
    "KrSloboda": (200.0, 15, 6, 22.0, 37.4),
    "Ashtart": (100.0, 27, 8, 27.1, 35.7),
    "Chicontepec": (150.0, 11, 4, 30.0, 42.0),
    "Chesapeake": (120.0, 45, 0, 25.0, 39.0),
    "OGX": (200.0, 5, 1, 38.0, 46.0),
}


def _replica(
    name: str,
    across: int,
    cell: tuple[float, float],
    crossed: tuple[int, ...],
    crossings: int = 0,
    branchings: int = 0,
    slope: float = 0.1,
) -> Replica:
    return Replica(name, *TABLE_2[name], across, cell, crossed, crossings, branchings, slope=slope)


#: By their names as demo models.
# The larger a field, the gentler its horizon, which would else rise by more than a kilometre or two.
REPLICAS = {
    r.name.lower(): r
    for r in (
        _replica("Fang", 3, (5800.0, 5000.0), (0,)),
        _replica("Bohai", 3, (5850.0, 5400.0), (1,), branchings=1),
        _replica("KrSloboda", 4, (6000.0, 5800.0), (2,), crossings=2, branchings=2),
        _replica("Ashtart", 5, (5800.0, 5400.0), (2, 1), crossings=3, branchings=2, slope=0.06),
        _replica("Chicontepec", 3, (5850.0, 5400.0), (2,), crossings=1, branchings=1),
        _replica("Chesapeake", 6, (5760.0, 4680.0), (0, 0, 0), slope=0.04),
        _replica("OGX", 3, (5800.0, 5400.0), (0,), crossings=1),
    )
}
