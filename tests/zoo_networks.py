"""Pairs of faults and cut graphs: with one known defect each, and without."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from graben.cutgraph import DroppedTrace
from graben.surface import Surface
from tests.zoo_shapes import (
    STEP,
    Case,
    Fakes,
    J,
    L,
    N,
    T,
    X,
    anchoring,
    dipping,
    faults,
    graph,
    level,
    sheet,
    welded,
)


def _across(x0: int = -2, x1: int = 2, rows: int = 4, name: str = "F") -> Surface:
    """A vertical sheet in the plane y = 0."""
    return sheet(x1 - x0, rows, lambda i, j: (STEP * (i + x0), 0 * i, -STEP * j), name)


def _along(y0: int = -2, y1: int = 2, rows: int = 4, name: str = "G") -> Surface:
    """A vertical sheet in the plane x = 0."""
    return sheet(y1 - y0, rows, lambda i, j: (0 * i, STEP * (i + y0), -STEP * j), name)


def pair(
    first: Surface, second: Surface, name: str, check: str = "pairwise-connected", place=None, **keys
) -> Case:
    # the surfaces stand apart in the model itself: only the complex says how they meet
    return Case(
        name, check, faults(first, second), place, ("F", "G"), providers=Fakes(welded(first, second)), **keys
    )


def _touched(surface: Surface, keep) -> Surface:
    """The surface without the triangles that touch the line x = y = 0 anywhere but at the depths kept."""
    on_line = (surface.vertices[:, :2] == 0).all(axis=1)
    other = on_line & ~np.isin(surface.vertices[:, 2], [-STEP * k for k in keep])
    return replace(surface, triangles=surface.triangles[~other[surface.triangles].any(axis=1)])


def _pairs() -> list[Case]:
    f = _across()
    gap = _touched(_along(rows=6), (0, 1, 4, 5, 6))
    triangle = Surface("G", [[0, 0, -2 * STEP], [0, STEP, -STEP], [0, STEP, -3 * STEP]], [[0, 1, 2]])
    two = Surface(
        "G",
        [[0, 0, 0], [0, STEP, 0], [0, STEP, -STEP], [0, 0, -3 * STEP], [0, STEP, -4 * STEP]],
        [[0, 1, 2], [1, 2, 3], [2, 3, 4]],
    )
    ring = Surface(
        "G",
        [[0, 0, 0], [STEP, 0, -STEP], [0, 0, -STEP], [20, 40, -20]],
        [[0, 1, 3], [1, 2, 3], [2, 0, 3]],
    )
    flat = sheet(1, 1, lambda i, j: (STEP * (1 - i), 0 * i, -STEP * (1 - j)), "F")
    return [
        pair(f, triangle, "touch in a point", place=(0, 0, -2 * STEP)),
        pair(f, two, "two points", place=None),
        pair(_across(rows=6), gap, "second piece", place=(0, 0, -STEP / 2)),
        pair(f, _across(0, 1, 1, "G"), "common area", place=(STEP / 2, 0, -STEP / 2), blocks=True),
        pair(flat, ring, "closed line", place=(0, 0, 0)),
    ]


def _pairs_that_pass() -> list[Case]:
    return [
        pair(_across(), _along(), "proper crossing"),
        pair(_across(), _along(0, 2), "T"),
        pair(_across(), _along(1, 3), "a step apart"),
        pair(_across(rows=6), _touched(_along(rows=6), (2, 3, 4)), "one piece inside"),
        pair(
            _across(), sheet(2, 1, lambda i, j: (STEP * (i - 1), STEP * j, 0 * i), "G"), "along the upper rim"
        ),
    ]


def traced(name: str, check: str, *net, dropped=(), anchors=None, **keys) -> Case:
    """A level horizon with a cut graph by hand, in steps; the faults are those the owners ask for.

    ``net``: nodes, kinds, edges, owners and, where something is wrong, its place.
    """
    nodes, kinds, edges, owner, *spots = net
    place = spots[0] if spots else None
    count = max([*owner, *[d.fault for d in dropped], 0]) + 1
    model = faults(*(dipping(60, name="FGK"[k]) for k in range(count)), horizons=[level()])
    held = {} if anchors is None else {"H": anchors}
    provider = Fakes(graphs={"H": graph(nodes, kinds, edges, owner, dropped)}, anchors=held)
    spot = None if place is None else (STEP * place[0], STEP * place[1], 0.1 * STEP * place[0])
    return Case(name, check, model, spot, providers=provider, **keys)


LINE = [(1, 4), (2, 4), (3, 4), (4, 4), (5, 4)]
CHAIN = [(0, 1), (1, 2), (2, 3), (3, 4)]
SQUARE = [(2, 2), (5, 2), (5, 5), (2, 5)]
ROUND = [(0, 1), (1, 2), (2, 3), (3, 0)]


def _traces() -> list[Case]:
    key = {"objects": ("H", "F")}
    short = DroppedTrace(0, 0.8 * STEP, np.array([7 * STEP, 4 * STEP, 35.0]), "shorter than 2 steps")
    return [
        traced("loose end", "trace", LINE, [T, N, N, N, L], CHAIN, [0] * 4, (5, 4), blocks=True, **key),
        traced("two loose ends", "trace", LINE, [L, N, N, N, L], CHAIN, [0] * 4, (1, 4), blocks=True, **key),
        traced(
            "two pieces",
            "trace",
            LINE,
            [T, N, T, T, T],
            [(0, 1), (1, 2), (3, 4)],
            [0] * 3,
            (4.5, 4),
            extended="warn",
            **key,
        ),
        traced(
            "dropped",
            "trace",
            LINE,
            [T, N, N, N, T],
            CHAIN,
            [0] * 4,
            (7, 4),
            dropped=[short],
            extended="warn",
            paper="warn",
            **key,
        ),
    ]


def _traces_that_pass() -> list[Case]:
    cross = [(1, 4), (3, 4), (5, 4), (3, 2), (3, 6)]
    return [
        traced("one line", "trace", LINE, [T, N, N, N, T], CHAIN, [0] * 4),
        traced("leaves the domain", "trace", LINE, [X, N, N, N, T], CHAIN, [0] * 4),
        traced(
            "ends at another", "trace", cross, [T, J, T, T, T], [(0, 1), (1, 2), (3, 1), (1, 4)], [0, 0, 1, 1]
        ),
    ]


def _junctions() -> list[Case]:
    key = {"objects": ("H", "F", "G"), "blocks": True}
    both = [(0, 1), (1, 2), (2, 3), (3, 4), (2, 1)]
    return [
        traced("one common edge", "junction", LINE, [T, J, J, N, T], both, [0, 0, 0, 0, 1], (2.5, 4), **key),
        traced(
            "two common edges",
            "junction",
            LINE,
            [T, J, N, J, T],
            [*CHAIN, (1, 2), (2, 3)],
            [0] * 4 + [1] * 2,
            (2.5, 4),
            **key,
        ),
        traced(
            "the same line",
            "junction",
            LINE,
            [T, N, N, N, T],
            [*CHAIN, *CHAIN],
            [0] * 4 + [1] * 4,
            (1.5, 4),
            **key,
        ),
    ]


def _cycles() -> list[Case]:
    h = {"objects": ("H",)}
    loose = (anchoring(100), anchoring(0, subdomain=1))
    held = (anchoring(100), anchoring(7, subdomain=1))
    tail = [*SQUARE, (7, 2)]
    three = [0, 1, 2, 2]
    return [
        traced("ring unheld", "acyclic", SQUARE, [J] * 4, ROUND, three, (2, 2), anchors=loose, **h),
        traced(
            "ring held", "acyclic", SQUARE, [J] * 4, ROUND, three, (2, 2), anchors=held, extended="warn", **h
        ),
        traced(
            "ring with a tail",
            "acyclic",
            tail,
            [J] * 4 + [T],
            [*ROUND, (1, 4)],
            [*three, 0],
            (2, 2),
            anchors=held,
            extended="warn",
            **h,
        ),
        traced(
            "ring on itself",
            "acyclic",
            SQUARE,
            [N] * 4,
            ROUND,
            [0] * 4,
            (2, 2),
            anchors=loose,
            **h,
        ),
    ]


def _anchors() -> list[Case]:
    h = {"objects": ("H",)}
    line = (LINE, [T, N, N, N, T], CHAIN, [0] * 4, (3, 2))
    spot = (3 * STEP, 2 * STEP, 0.3 * STEP)
    return [
        traced("none fixed", "anchored", *line, anchors=(anchoring(90), anchoring(0, False, spot, 1)), **h),
        traced("two fixed", "anchored", *line, anchors=(anchoring(90), anchoring(2, False, spot, 1)), **h),
        traced("many in one line", "anchored", *line, anchors=(anchoring(9, False, spot),), **h),
    ]


def _passing_graphs() -> list[Case]:
    def same(check: str, cases: Sequence[Case]) -> list[Case]:
        return [replace(c, check=check) for c in cases]

    parallel = [(1, 3), (4, 3), (1, 5), (4, 5), (1, 4), (6, 4)]
    star = [(3, 3), (1, 3), (5, 3), (3, 5), (3, 1)]
    rays = [(0, 1), (0, 2), (0, 3), (0, 4)]
    held = (anchoring(3), anchoring(90, subdomain=1))
    return [
        *_traces_that_pass(),
        *same("junction", _traces_that_pass()),
        *same("acyclic", _traces_that_pass()),
        traced("open square", "acyclic", SQUARE, [T, J, J, T], ROUND[:3], [0, 1, 2]),
        traced("star", "acyclic", star, [J, T, T, T, T], rays, [0, 0, 1, 1]),
        traced("parallel", "acyclic", parallel, [X] * 6, [(0, 1), (2, 3), (4, 5)], [0, 1, 2]),
        traced(
            "common edge is no cycle", "acyclic", LINE, [T, J, J, N, T], [*CHAIN, (2, 1)], [0, 0, 0, 0, 1]
        ),
        *same("anchored", _traces_that_pass()),
        traced("three fixed", "anchored", LINE, [T, N, N, N, T], CHAIN, [0] * 4, anchors=held),
    ]


def networks_that_fail() -> list[Case]:
    """Every pair and every cut graph with a defect."""
    return [case for make in (_pairs, _traces, _junctions, _cycles, _anchors) for case in make()]


def networks_that_pass() -> list[Case]:
    """Every pair and every cut graph without."""
    return [*_pairs_that_pass(), *_passing_graphs()]
