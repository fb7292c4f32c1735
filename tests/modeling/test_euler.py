"""Euler's count of the cut: vertices, edges, triangles, parts and boundary loops obey it exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graben.cutgraph import CutGraph, NodeKind
from graben.demo import build as demo
from graben.demo import names
from graben.model import Fault, Model
from graben.modeling.cutting import CutMesh, opened
from graben.modeling.tracing import cut_graph
from graben.modeling.triangulation import PlanMesh, triangulated
from graben.refinement import component_labels, refined
from graben.surface import Surface, boundary_edges, edge_table
from tests.models import grid_horizon, grid_triangles, model_of, model_of_demo, plane_fault

FEW = settings(max_examples=40, deadline=None, derandomize=True, database=None)
COLUMNS, ROWS = 12, 5
DEPTH = 400.0


@dataclass(frozen=True)
class Count:
    """What Euler's formula is about: of a triangulation, or of its cut graph."""

    vertices: int
    edges: int
    triangles: int
    parts: int
    loops: int


def counted(triangles: np.ndarray) -> Count:
    """Count a triangulation whose boundary nodes have two boundary edges each."""
    used = np.unique(triangles)
    rim = boundary_edges(triangles)
    on_rim, ends = np.unique(rim, return_inverse=True)
    assert (np.bincount(ends.ravel()) == 2).all(), "the boundary touches itself in a node"
    edges, sides = edge_table(triangles)
    first, second, third = sides.T
    joins = np.concatenate([np.stack([first, second], axis=1), np.stack([second, third], axis=1)])
    return Count(
        len(used),
        len(edges),
        len(triangles),
        len(np.unique(component_labels(len(edges), joins))),
        len(np.unique(component_labels(len(on_rim), ends.reshape(-1, 2)))),
    )


def contracted(graph: CutGraph) -> tuple[int, int]:
    """Return how many nodes lie inside, and of how many pieces the graph is with the outline as one node."""
    count = len(graph.nodes)
    outer = graph.kinds == NodeKind.EXIT
    merged = np.where(outer, count, np.arange(count))
    nodes = np.append(np.unique(merged[~outer]), count)
    pieces = component_labels(len(nodes), np.searchsorted(nodes, merged[graph.edges]).reshape(-1, 2))
    return int((~outer).sum()), len(np.unique(pieces))


def opened_mesh(model: Model) -> tuple[CutGraph, PlanMesh, CutMesh]:
    horizon = model.horizons[0]
    graph = cut_graph(model, horizon, refined([f.surface for f in model.faults]))
    gammas = np.array([model.gamma(model.faults[f], horizon) for f in np.unique(graph.faults)])
    mesh = triangulated(horizon.surface, graph, horizon.step, gammas)
    return graph, mesh, opened(mesh)


def obeys_euler(model: Model) -> CutGraph:
    """Assert every count of the cut of a model, whose horizon is a disk; return its cut graph.

    With e edges of the graph, v of its nodes inside and c pieces of it (the outline contracted to a node
    of its own): e - v + c parts, c - 1 more boundary loops than parts, a copy for each cut edge around a
    node inside, and one more on the outline.
    """
    graph, mesh, cut = opened_mesh(model)
    whole, parted = counted(mesh.triangles), counted(cut.triangles)
    assert (whole.parts, whole.loops) == (1, 1)
    e = len(graph.edges)
    inside, pieces = contracted(graph)
    assert parted.triangles == whole.triangles
    assert parted.edges == whole.edges + e
    assert parted.vertices == whole.vertices + 2 * e - inside
    assert parted.parts == e - inside + pieces
    assert parted.parts == int(cut.labels.max()) + 1
    assert parted.loops == parted.parts + pieces - 1
    assert parted.vertices - parted.edges + parted.triangles == 2 * parted.parts - parted.loops
    return graph


@dataclass(frozen=True)
class Line:
    """A fault in plan: where its line at elevation 0 starts and ends, and its dip in degrees."""

    start: np.ndarray
    end: np.ndarray
    dip: float

    def at(self, z: np.ndarray) -> np.ndarray:
        """Return a point of the fault's level line at each elevation, (k, 2)."""
        along = self.end - self.start
        right = np.array([along[1], -along[0]]) / np.hypot(*along)
        return self.start - (z / np.tan(np.radians(self.dip)))[:, None] * right

    def fault(self, name: str, parent: Line | None = None) -> Fault:
        """Return the fault; it starts on its parent at every elevation, where there is one."""
        if parent is None:
            ends = tuple(self.start), tuple(self.end)
            return plane_fault(*ends, dip=self.dip, depth=DEPTH, name=name, parts=(COLUMNS, ROWS))
        z = np.linspace(-DEPTH, DEPTH, ROWS)
        own, other = self.at(z), parent.at(z)
        way, across = self.end - self.start, parent.end - parent.start
        normal = np.array([across[1], -across[0]])
        first = own + (((other - own) @ normal) / (way @ normal))[:, None] * way
        last = own + way
        share = np.linspace(0.0, 1.0, COLUMNS)[:, None, None]
        plan = (1.0 - share) * first + share * last
        height = np.broadcast_to(z[:, None], (COLUMNS, ROWS, 1))
        points = np.concatenate([plan, height], axis=-1).reshape(-1, 3)
        return Fault(Surface(name, points, grid_triangles(COLUMNS, ROWS)))


@dataclass(frozen=True)
class Twig:
    """How a line of a random tree is set: T from, or X through, an earlier one, or on its own.

    ``share`` is where on the parent, ``turn`` the angle to it in degrees, ``before`` and ``after`` how far it
    goes to either side, m.
    """

    parent: int
    kind: str
    share: float
    turn: float
    before: float
    after: float
    dip: float


def grown(twigs: list[Twig]) -> list[tuple[Line, Line | None]]:
    """Return the lines of a tree, each with the line it ends on."""
    lines: list[tuple[Line, Line | None]] = []
    for k, twig in enumerate(twigs):
        # No two directions are equal, so no two faults lie in one plane.
        if not lines:
            foot, angle, parent = np.array([137.0, -73.0]), np.radians(twig.turn), None
        else:
            parent = lines[twig.parent % len(lines)][0]
            foot = parent.start + twig.share * (parent.end - parent.start)
            way = parent.end - parent.start
            angle = np.arctan2(way[1], way[0]) + np.radians(twig.turn + 1.7 * k)
        way = np.array([np.cos(angle), np.sin(angle)])
        if twig.kind == "T" and parent is not None:
            lines.append((Line(foot, foot + twig.after * way, twig.dip), parent))
            continue
        if twig.kind == "alone":
            foot = foot + 700.0 * np.array([-way[1], way[0]])
        lines.append((Line(foot - twig.before * way, foot + twig.after * way, twig.dip), None))
    return lines


def faults_of(twigs: list[Twig]) -> list[Fault]:
    return [line.fault(f"F{k}", parent) for k, (line, parent) in enumerate(grown(twigs))]


TWIGS = st.builds(
    Twig,
    st.integers(0, 4),
    st.sampled_from(["T", "T", "X", "X", "alone"]),
    st.integers(3, 17).map(lambda k: 0.05 * k),
    st.sampled_from([-1.0, 1.0]).flatmap(lambda s: st.integers(35, 90).map(lambda d: s * d)),
    st.sampled_from([450.0, 900.0, 1400.0, 4000.0]),
    st.sampled_from([550.0, 1000.0, 1500.0, 4000.0]),
    st.sampled_from([50.0, 70.0, 88.0]),
)


@pytest.mark.parametrize("slope", [0.0, 0.05])
@pytest.mark.parametrize(
    ("kinds", "ends"),
    [("", (2, 0, 0)), ("T", (3, 0, 1)), ("X", (4, 0, 1)), ("TX", (5, 0, 2)), ("exit", (1, 1, 0))],
)
def test_count_of_tips_exits_and_junctions(kinds: str, ends: tuple[int, int, int], slope: float) -> None:
    """Each kind of node that the random trees are made of is really there."""
    reach = 4000.0 if kinds == "exit" else 1400.0
    stem = Twig(0, "X", 0.5, 83.0, 1400.0, reach, 70.0)
    rest = [
        Twig(0, kind, share, 71.0, 700.0, 800.0, 75.0)
        for kind, share in zip(kinds, (0.25, 0.75), strict=False)
        if kind in "TX"
    ]
    model = model_of(grid_horizon(lambda x, y: slope * x), *faults_of([stem, *rest]))
    found = np.bincount(obeys_euler(model).kinds, minlength=5)
    assert (found[NodeKind.TIP], found[NodeKind.EXIT], found[NodeKind.JUNCTION]) == ends
    assert found[NodeKind.LOOSE] == 0


@FEW
@given(st.lists(TWIGS, min_size=1, max_size=4), st.sampled_from([0.0, 0.05, 0.1]))
def test_count_of_random_trees(twigs: list[Twig], slope: float) -> None:
    faults = faults_of(twigs)
    obeys_euler(model_of(grid_horizon(lambda x, y: slope * x - 0.5 * slope * y), *faults))


@FEW
@given(
    st.lists(
        st.tuples(st.integers(-22, 22), st.integers(-22, 22), st.integers(0, 7), st.integers(9, 35)),
        min_size=1,
        max_size=4,
    )
)
def test_count_of_random_segments(segments: list[tuple[int, int, int, int]]) -> None:
    """Segments thrown down anyhow, which may close cycles."""
    faults = []
    for k, (x, y, eighth, length) in enumerate(segments):
        angle = eighth * np.pi / 4 + 0.11 * k
        start = np.array([100.0 * x + 13.7, 100.0 * y + 7.3])
        end = start + 100.0 * length * np.array([np.cos(angle), np.sin(angle)])
        faults.append(Line(start, end, 80.0).fault(f"F{k}"))
    obeys_euler(model_of(grid_horizon(lambda x, y: 0.05 * x + 20.0 * np.sin(y / 700.0)), *faults))


@pytest.mark.parametrize("name", names())
def test_count_of_the_demo_models(name: str) -> None:
    obeys_euler(model_of_demo(demo(name)))
