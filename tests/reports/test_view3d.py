"""The 3D view: precision of large coordinates, thinning that keeps lips, colours."""

from __future__ import annotations

import base64
import json
from dataclasses import replace

import numpy as np

from graben.reports import view3d
from graben.reports.view3d import node_throws, scene, thinned_surface
from graben.surface import boundary_edges
from tests.reports import sample


def decoded(values):
    return np.frombuffer(base64.b64decode(values["bdata"]), dtype=f"<{values['dtype']}")


def test_points_keep_their_place_to_a_millimetre():
    result = sample.run_result()
    view = scene(result)
    mesh = view.data[0]
    written = [view.layout["scene"][k]["title"]["text"] for k in ("xaxis", "yaxis")]
    offset = [float(text.split(" − ")[1].split(" ")[0]) for text in written]
    points = np.stack([decoded(mesh[k]) for k in "xyz"], axis=1) + np.array([*offset, 0.0])
    np.testing.assert_allclose(points, result.horizons[0].surface.vertices, rtol=0, atol=1e-3)
    corners = np.stack([decoded(mesh[k]) for k in "ijk"], axis=1)
    np.testing.assert_array_equal(corners, result.horizons[0].surface.triangles)


def test_depth_models_count_downwards_on_a_turned_axis():
    view = scene(sample.run_result(depth=True))
    assert decoded(view.data[0]["z"]).min() > 0
    low, high = view.layout["scene"]["zaxis"]["range"]
    assert low > high


def test_thinning_moves_no_vertex_and_keeps_every_lip():
    result = sample.cut_result()
    surface = result.surface
    kept, triangles = thinned_surface(surface, 0.3)
    assert len(triangles) < 0.5 * len(surface.triangles)
    before = {tuple(sorted(e)) for e in boundary_edges(surface.triangles).tolist()}
    after = {tuple(sorted(e)) for e in kept[boundary_edges(triangles)].tolist()}
    assert before == after


def test_thinned_view_says_so(monkeypatch):
    assert scene(sample.run_result()).note == ""
    monkeypatch.setattr(view3d, "MOST_TRIANGLES", 5_000)
    view = scene(sample.run_result())
    assert "Thinned" in view.note
    lengths = [len(decoded(t["i"])) for t in view.data if t["type"] == "mesh3d"]
    assert sum(lengths) < 9_000
    for colouring in view.colourings.values():
        sizes = [len(decoded(values)) for values in colouring["values"]]
        assert sizes == [len(decoded(view.data[m]["x"])) for m in view.meshes]


def test_throw_of_a_node_is_that_of_the_cutoff_beside_it():
    result = sample.cut_result()
    throws = node_throws(result)
    cutoff = result.cutoffs[0]
    lip = np.flatnonzero(result.side == 1)
    expected = sample.throw_at(result.first[lip, 1], 138.0)
    np.testing.assert_allclose(throws[lip], expected, atol=1e-9)
    assert throws[result.fixed].max() == 0.0
    assert throws.max() == cutoff.throw.max()


def test_names_are_text_for_plotly_as_well():
    view = scene(sample.run_result(sample.EVIL))
    assert "<script" not in json.dumps(view.data)
    assert "<script" not in json.dumps(view.layout)


def test_nothing_to_show_is_no_scene():
    result = sample.run_result()
    empty = replace(result, horizons=(), repaired=replace(result.repaired, faults=()))
    assert scene(empty) is None
