"""Steps that a grid draws over one cell, and the bubbles that a fault closes off in what is smeared."""

from __future__ import annotations

import numpy as np
import pytest

from graben.arrays import FloatArray, floats, ints
from graben.cutgraph import NodeKind
from graben.errors import ModelingError
from graben.finding import Status
from graben.modeling import tracing
from graben.modeling.bubbles import unbubbled
from graben.modeling.calming import calmed
from graben.modeling.resampling import Trace
from graben.modeling.tracing import cut_graph
from graben.pipeline import check
from graben.refinement import refined
from tests.models import grid_horizon, model_of, plane_fault

STEP, THROW = 25.0, 60.0


def closed(points: list[tuple[float, float]], start: int) -> list[tuple[int, int]]:
    return [(start + k, start + (k + 1) % len(points)) for k in range(len(points))]


def trace_of(points: list[tuple[float, float]], edges: list[tuple[int, int]], faults: list[int]) -> Trace:
    nodes = np.column_stack([floats(points), np.zeros(len(points))])
    outer = np.zeros(len(points), dtype=np.int64)
    return Trace(floats(nodes), ints(edges), ints(faults), outer, ints(np.zeros((len(edges), 2))))


LINE = [(float(x), 0.0) for x in range(7)]
WAY = [(k, k + 1) for k in range(6)]


def test_a_small_ring_beside_the_line_is_left_out_and_a_large_one_stays() -> None:
    small = [(2.0, 1.0), (4.0, 1.0), (4.0, 3.0), (2.0, 3.0)]
    large = [(2.0, -1.0), (4.0, -1.0), (4.0, -6.0), (2.0, -6.0)]
    edges = [*WAY, *closed(small, 7), *closed(large, 11)]
    trace, left = unbubbled(trace_of([*LINE, *small, *large], edges, [0] * len(edges)), 1.0)
    assert trace.edges.tolist() == [list(e) for e in [*WAY, *closed(large, 11)]]
    assert not trace.outer.any()
    ((fault, middle, length),) = left
    assert (fault, middle.tolist(), length) == (0, [3.0, 2.0, 0.0], 8.0)


def test_the_line_goes_the_shorter_way_past_a_bubble() -> None:
    around = [(2.0, 1.5), (4.0, 1.5)]
    edges = [*WAY, (2, 7), (7, 8), (8, 4)]
    trace, left = unbubbled(trace_of([*LINE, *around], edges, [0] * len(edges)), 1.0)
    assert trace.edges.tolist() == [list(e) for e in WAY]
    assert [length for _, _, length in left] == [5.0]


def test_what_several_faults_close_is_no_bubble() -> None:
    around = [(2.0, 1.5), (4.0, 1.5)]
    edges = [*WAY, (2, 7), (7, 8), (8, 4)]
    trace = trace_of([*LINE, *around], edges, [0] * 6 + [1] * 3)
    assert unbubbled(trace, 1.0) == (trace, [])


def stepped(dip: float, wobble: float = 12.0, step: float = STEP):
    """A horizon that falls by the throw within a cell, whose line of cells wobbles beside the fault."""

    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        side = x > wobble * np.sin(y / 90.0)
        bed = 0.02 * x + 3.0 * np.sin(x / 200.0) * np.cos(y / 150.0)
        throw = THROW * np.clip(1.0 - (y / 780.0) ** 2, 0.0, 1.0)
        return np.asarray(bed + np.where(side, -0.5, 0.5) * throw)

    return model_of(grid_horizon(height, 2000.0, step), plane_fault((0, -800), (0, 800), dip=dip))


@pytest.mark.parametrize("dip", [35.0, 45.0, 60.0])
@pytest.mark.parametrize("step", [12.5, 25.0, 50.0])
def test_a_step_over_one_cell_is_traced_as_one_line(dip: float, step: float) -> None:
    model = stepped(dip, step=step)
    graph = cut_graph(model, model.horizons[0], refined([f.surface for f in model.faults]))
    assert len(graph.edges) == len(graph.nodes) - 1, "one line from tip to tip"
    assert (graph.kinds == NodeKind.TIP).sum() == 2
    assert not graph.dropped
    half_heave = 0.5 * THROW / np.tan(np.radians(dip))
    assert np.abs(graph.nodes[:, 0]).max() < half_heave + 2.0 * step


def test_a_horizon_steeper_than_the_fault_is_no_step() -> None:
    fault = plane_fault((0, -800), (0, 800), dip=20.0)
    horizon = grid_horizon(lambda x, y: -0.8 * x + 0.0 * y, 1000.0, 25.0)
    assert calmed(horizon.surface, [fault.surface]) is horizon.surface


def test_traces_that_cross_are_named_with_their_place(monkeypatch: pytest.MonkeyPatch) -> None:
    model = stepped(60.0)
    monkeypatch.setattr(tracing, "_crossing", lambda graph: ints([[0, 1]]))
    with pytest.raises(ModelingError, match=r"crosses itself in plan.*as points with a step") as caught:
        cut_graph(model, model.horizons[0], refined([f.surface for f in model.faults]))
    place = caught.value.place
    assert place is not None
    far = model.moved(floats([5e5, 6e6, 0.0]))
    (said,) = [f for f in check(far).of("trace") if f.status is Status.FAIL]
    assert said.worst is not None
    assert (said.worst.x - 5e5, said.worst.y - 6e6) == pytest.approx(place[:2], abs=1e-3)
