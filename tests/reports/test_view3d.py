"""The 3D view: precision of large coordinates, thinning that keeps lips, colours."""

from __future__ import annotations

import base64
import json
from dataclasses import replace

import numpy as np

from graben.reports import view3d
from graben.reports.colouring import node_throws, throw_on
from graben.reports.scene import thinned_surface
from graben.reports.view3d import Spot, scene
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
    assert "Thinned" not in scene(sample.run_result()).note
    monkeypatch.setattr(view3d, "MOST_TRIANGLES", 5_000)
    view = scene(sample.run_result())
    assert "Thinned" in view.note
    lengths = [len(decoded(t["i"])) for t in view.data if t["type"] == "mesh3d"]
    assert sum(lengths) < 9_000
    for colouring in view.colourings.values():
        for mesh, values in zip(view.meshes, colouring["values"], strict=True):
            if values is not None:
                assert len(decoded(values)) == len(decoded(view.data[mesh]["x"]))


def test_throw_of_a_node_is_that_of_the_cutoff_beside_it():
    result = sample.cut_result()
    throws = node_throws(result)
    cutoff = result.cutoffs[0]
    lip = np.flatnonzero(result.side == 1)
    expected = sample.throw_at(result.first[lip, 1], 138.0)
    np.testing.assert_allclose(throws[lip], expected, atol=1e-9)
    assert throws[result.fixed].max() == 0.0
    assert throws.max() == cutoff.throw.max()


def test_throw_on_a_fault_is_that_of_its_cutoffs_and_linear_between_two_horizons():
    surface = sample.fault().surface
    y = surface.vertices[:, 1]
    one = throw_on([sample.cut_result(throw=100.0)], surface)
    np.testing.assert_allclose(
        one, sample.throw_at(y, 100.0), atol=0.5
    )  # the fault is no plane: its strike bends
    low = sample.cut_result("Low", throw=200.0).moved(np.array([0.0, 0.0, -200.0]))
    both = throw_on([sample.cut_result(throw=100.0), low], surface)
    level = sample.regional(y) - surface.vertices[:, 2]  # below the upper horizon
    share = np.clip(level / 200.0, 0.0, 1.0)
    inside = sample.throw_at(y, 100.0) > 0
    np.testing.assert_allclose(both[inside], (sample.throw_at(y, 100.0) * (1 + share))[inside], atol=3.0)
    assert throw_on([sample.uncut_result()], surface) is None


def test_view_is_coloured_by_height_throw_move_and_subdomain():
    result = sample.run_result()
    moves = np.linspace(0.0, 30.0, len(result.repaired.faults[0].surface.vertices))
    view = scene(result, {"F1": moves})
    assert list(view.colourings) == ["height", "throw", "move", "subdomain"]
    cut, uncut, fault = view.colourings["move"]["values"]
    first = result.horizons[0]
    np.testing.assert_allclose(
        decoded(cut), np.linalg.norm(first.surface.vertices - first.first, axis=1), atol=1e-4
    )
    assert not decoded(uncut).any()
    np.testing.assert_allclose(decoded(fault), moves, rtol=1e-6)
    assert view.colourings["height"]["values"][2] is None  # a fault keeps its own colour
    assert view.colourings["subdomain"]["values"][2] is None


def test_normal_throws_alone_fill_the_colours():
    axes = [scene(sample.run_result(throw=throw)).colourings["throw"]["axis"] for throw in (138.0, -138.0)]
    assert [a["cmin"] == 0.0 for a in axes] == [True, False]
    assert [a["cmax"] == 0.0 for a in axes] == [False, True]


def test_uncut_horizons_are_switched_off_where_others_are_cut():
    view = scene(sample.run_result())
    assert {g.label: g.shown for g in view.groups} == {"Top A": True, "Top B": False, "F1": True}
    assert "switched off" in view.note
    assert view.data[view.meshes[1]]["visible"] is False
    alone = replace(sample.run_result(), horizons=(sample.uncut_result("Top B"),))
    assert all(g.shown for g in scene(alone).groups)


def test_places_of_the_page_are_marked_with_their_words():
    spot = Spot("to look at", 3, "Top A: <b>here</b>", np.array([*sample.ORIGIN, -2000.0]), "#B3261E")
    view = scene(sample.run_result(), spots=[spot])
    (group,) = [g for g in view.groups if g.kind == "Places"]
    trace = view.data[group.traces[0]]
    assert trace["hovertext"] == ["3. Top A: &lt;b&gt;here&lt;/b&gt;"]
    assert decoded(trace["z"]).tolist() == [-2000.0]


def test_a_view_of_too_many_surfaces_leaves_some_out_and_says_so(monkeypatch):
    monkeypatch.setattr(view3d, "MOST_TRIANGLES", 100)
    assert "3 surfaces left out" in scene(sample.run_result()).note


def test_names_are_text_for_plotly_as_well():
    view = scene(sample.run_result(sample.EVIL))
    assert "<script" not in json.dumps(view.data)
    assert "<script" not in json.dumps(view.layout)


def test_nothing_to_show_is_no_scene():
    result = sample.run_result()
    empty = replace(result, horizons=(), repaired=replace(result.repaired, faults=()))
    assert scene(empty) is None
