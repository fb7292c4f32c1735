"""The zoo of min-dip: faults with parts flatter than the limit, and ones that are just steep enough."""

from __future__ import annotations

import numpy as np

from graben.settings import Parameters
from tests.zoo.cases import Case
from tests.zoo.shapes import STEP, dipping, faults, scene, sheet


def _bent(*dips: float, columns: int = 6):
    """A fault whose rows dip so many degrees, one after the other."""
    turn = np.radians(dips)
    y = np.concatenate([[0], np.cumsum(STEP * np.cos(turn))])
    z = np.concatenate([[0], np.cumsum(-STEP * np.sin(turn))])
    return sheet(
        columns, len(dips), lambda i, j: (STEP * i, y[j.astype(int)] + 0 * i, z[j.astype(int)] + 0 * i)
    )


def _row(fault, row: int):
    """The middles of the triangles of one row of cells."""
    columns = len(np.unique(fault.vertices[:, 0])) - 1
    count = len(fault.vertices) // (columns + 1)
    a = np.arange(columns) * count + row
    low = fault.vertices[np.stack([a, a + count, a + count + 1])].mean(axis=0)
    high = fault.vertices[np.stack([a, a + count + 1, a + 1])].mean(axis=0)
    return np.concatenate([low, high]).tolist()


_FLAT = _bent(60, 60, 10, 60)
_LISTRIC = _bent(60, 50, 40, 31, 28)


def _case(name, model, place) -> Case:
    return Case(name, "min-dip", model, place, extended="warn", paper="warn")


FAILING: tuple[Case, ...] = (
    _case("20 degrees", faults(dipping(20)), None),
    _case("ramp and flat", faults(_FLAT), _row(_FLAT, 2)),
    _case("listric below", faults(_LISTRIC), _row(_LISTRIC, 4)),
    _case("just too flat", faults(dipping(29.99)), None),
    _case("a higher limit", scene(dipping(60), checks={"min-dip": 61.0}), None),
    _case("a limit of the parameters", faults(dipping(40), parameters=Parameters(min_dip=45.0)), None),
)


def _passes(name, model, follows=()) -> Case:
    return Case(name, "min-dip", model, objects=(), follows=follows)


PASSING: tuple[Case, ...] = (
    _passes("30 degrees", faults(dipping(30))),
    _passes("listric", faults(_bent(60, 50, 40, 31, 30.01))),
    _passes("flat, with a lower limit", faults(_FLAT, checks={"min-dip": 5.0})),
    _passes("upright", faults(dipping(90)), follows=("functional",)),
)
