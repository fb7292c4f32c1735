"""What figures are made of: cuts, contours, rims, the view face-on, and labels that keep apart."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

from graben.reports.labels import Label, write_labels
from graben.reports.map_parts import silhouette
from graben.reports.marks import fitted, window_of
from graben.reports.shapes import FaceOn, Shape, compass, crossings, level_lines, usable
from graben.surface import Surface
from tests.zoo import shapes


@pytest.mark.parametrize("dip", [20.0, 60.0, 89.0])
def test_face_on_keeps_the_lengths_of_a_plane(dip):
    surface = shapes.dipping(dip)
    face = FaceOn.of(surface)
    seen = face(surface.vertices)
    np.testing.assert_allclose(
        np.stack([face.along, face.up, face.towards]) @ face.towards, [0, 0, 1], atol=1e-12
    )
    np.testing.assert_allclose(np.ptp(seen, axis=0), [300.0, 200.0], atol=1e-6)
    np.testing.assert_allclose(seen.min(axis=0), 0.0, atol=1e-6)
    assert np.ptp(face.depth(surface.vertices)) < 0.1
    # it dips towards +y: seen from there, east lies to the left
    assert face.towards[1] > 0
    assert (compass(-face.along), compass(face.along)) == ("E", "W")
    highest = surface.vertices[:, 2] == 0.0
    np.testing.assert_allclose(seen[highest, 1], 200.0, atol=1e-6)


def test_face_of_a_level_surface_has_north_up():
    face = FaceOn.of(shapes.dipping(0.0))
    assert face.up[1] > 0.99
    assert face.along[0] > 0.99


def test_upper_rim_is_the_upper_edge():
    (line,) = Shape.of(shapes.dipping(60.0)).upper_rim
    np.testing.assert_allclose(line[:, 2], 0.0)
    assert np.ptp(line[:, 0]) == 300.0
    flipped = shapes.dipping(60.0)
    (same,) = Shape.of(Surface("F", flipped.vertices, flipped.triangles[:, ::-1])).upper_rim
    np.testing.assert_allclose(np.sort(same, axis=0), np.sort(line, axis=0))


def test_contours_of_a_plane_lie_at_their_elevations():
    surface = shapes.dipping(60.0)
    segments, levels = level_lines(surface, 5)
    np.testing.assert_allclose(segments[..., 2], levels[:, None] * np.ones(2), atol=1e-9)
    for level in np.unique(levels):
        ways = np.diff(segments[levels == level], axis=1)[:, 0]
        np.testing.assert_allclose(np.linalg.norm(ways, axis=1).sum(), 300.0, atol=1e-9)


def test_nothing_is_cut_where_nothing_vanishes():
    surface = shapes.dipping(60.0)
    segments, triangles = crossings(surface.vertices, surface.triangles, np.ones(len(surface.vertices)))
    assert segments.shape == (0, 2, 3)
    assert len(triangles) == 0


def test_usable_leaves_out_what_has_no_place():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0], [0, 0, 1e30]]
    kept = usable(Surface("S", vertices, [[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 1, 99], [-1, 0, 1]]))
    assert kept.triangles.tolist() == [[0, 1, 2]]
    assert kept.vertices.tolist() == vertices[:3]


def test_silhouette_has_one_sense():
    corners = np.array([[[0, 0], [1, 0], [0, 1]], [[0, 0], [0, 1], [1, 0]]], dtype=float)
    path = silhouette(corners)
    turned = path.vertices.reshape(2, 4, 2)[:, :3]
    a, b = turned[:, 1] - turned[:, 0], turned[:, 2] - turned[:, 0]
    assert (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] > 0).all()


def test_windows_fit_the_paper():
    window = window_of(np.array([[0.0, 0.0], [10.0, 2.0]]), 1.0)
    assert window == (-1.0, 11.0, -1.0, 3.0)
    west, east, south, north = fitted(window, 1.0)
    assert (east - west, north - south) == (12.0, 12.0)
    assert (north + south) / 2 == 1.0
    west, east, south, north = window_of(np.array([[5.0, 5.0]]), 0.0)
    assert east > west and north > south


def test_labels_keep_apart():
    figure = Figure(figsize=(4, 4))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, 1), ylim=(0, 1))
    rng = np.random.default_rng(1)
    labels = [
        Label(f"{k}, {k + 1}", tuple(p), "#000000")
        for k, p in enumerate(0.5 + 0.1 * rng.normal(size=(25, 2)))
    ]
    missing = write_labels(axes, labels, (4.0, 4.0))
    figure.draw_without_rendering()
    assert len(axes.texts) == 25 - len(missing)
    assert len(missing) < 10
    assert not {t.get_text() for t in axes.texts} & {label.text for label in missing}
    boxes = [Text.get_window_extent(t) for t in axes.texts]  # without the line to its place
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[k + 1 :])
    outside = Label("out", (7.0, 7.0), "#000000")
    assert write_labels(axes, [outside], (4.0, 4.0)) == [outside]
