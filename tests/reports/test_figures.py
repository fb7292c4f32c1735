"""Figures: what they measure is right, and drawing is deterministic and open to any name."""

from __future__ import annotations

import base64
import io

import numpy as np
import pytest
from PIL import Image

from graben.modeling.results import Cutoff
from graben.reports.along_strike import fitted_name
from graben.reports.convergence import run_convergence_figure
from graben.reports.figures import throw_figure
from graben.reports.images import data_address, png_bytes, svg_bytes
from graben.reports.plan_map import detail_window, map_figure
from graben.reports.section import Plane, cut_by, plane_across, section_figure, section_place
from graben.reports.style import Frame
from graben.surface import Surface
from tests.reports import sample

METRES = Frame("m", 1.0)


def test_vertical_cut_through_a_plane_lies_on_the_plane():
    horizon = sample.uncut_result().surface
    points = horizon.vertices.copy()
    gradient = np.array([0.3, -0.1])
    points[:, 2] = (points[:, :2] - sample.ORIGIN) @ gradient
    along = np.array([np.cos(0.4), np.sin(0.4)])
    origin = np.array(sample.ORIGIN) + 2500.0
    segments, triangles = cut_by(Plane(origin, along), Surface("plane", points, horizon.triangles))
    expected = (origin - sample.ORIGIN) @ gradient + segments[..., 0] * (along @ gradient)
    np.testing.assert_allclose(segments[..., 1], expected, atol=1e-6)
    assert len(segments) == len(triangles) == len(np.unique(triangles))
    # The pieces cover the way through the square once.
    length = segments[..., 0].max() - segments[..., 0].min()
    assert np.abs(np.diff(segments[..., 0], axis=1)).sum() == pytest.approx(length)


def test_section_stands_across_the_fault_at_its_largest_throw():
    result = sample.cut_result()
    cutoff, row = section_place(result, "F1", sample.GAMMA)
    assert cutoff.throw[row] == cutoff.throw.max()
    plane = plane_across(cutoff, row)
    along, off = plane.coordinates(np.stack([cutoff.hanging[row], cutoff.foot[row]]))
    assert along[0] > along[1]  # dips east, and the section runs eastwards
    np.testing.assert_allclose(off, 0.0, atol=10.0)
    assert section_place(result, "other", sample.GAMMA) is None
    assert section_place(sample.uncut_result(), "F1", sample.GAMMA) is None


def figures(result, frame=METRES, name="F1"):
    cutoff, row = section_place(result, name, sample.GAMMA)
    window = detail_window(result, sample.GAMMA)
    return {
        "map": map_figure(result, frame),
        "detail": map_figure(result, frame, window),
        "section": section_figure(result, cutoff, row, [sample.fault(name)], frame, 800.0),
        "throw": throw_figure(result, frame, [cutoff.throw]),
        "convergence": run_convergence_figure([result], 0.1, frame),
    }


def test_every_figure_is_the_same_picture_twice():
    result = sample.cut_result(throw=-138.0)
    first, second = ({key: svg_bytes(figure) for key, figure in figures(result).items()} for _ in range(2))
    assert first == second
    assert all(b"<dc:date>" not in picture for picture in first.values())
    section = figures(result)["section"]
    assert png_bytes(section, 60) == png_bytes(section, 60)


def test_names_with_markup_and_dollars_are_drawn_as_they_stand():
    result = sample.cut_result(fault_name=sample.EVIL)
    drawn = figures(result, name=sample.EVIL)
    texts = {text.get_text() for text in drawn["map"].axes[0].texts}
    assert fitted_name(sample.EVIL) in texts
    for figure in drawn.values():
        assert b"<script" not in svg_bytes(figure)


def test_long_names_leave_a_figure_its_size():
    name = "a fault of a very long name " * 11
    short, long = (figures(sample.cut_result(n, n), name=n) for n in ("F1", name))
    for key in ("map", "section", "throw", "convergence"):
        width = [Image.open(io.BytesIO(png_bytes(f[key], 40))).width for f in (short, long)]
        assert width[1] <= 1.3 * width[0], key


def test_throws_on_the_map_show_the_largest():
    result = sample.cut_result(throw=138.0)
    texts = [text.get_text() for text in map_figure(result, METRES).axes[0].texts]
    assert "138" in texts


def test_gap_is_white_on_the_map_and_an_overlap_is_not():
    window = (sample.ORIGIN[0] + 2900.0, sample.ORIGIN[0] + 3200.0, sample.ORIGIN[1] + 2850.0, 0.0)
    shares = []
    for throw in (400.0, -400.0):
        figure = map_figure(sample.cut_result(throw=throw), METRES, (*window[:3], window[2] + 300.0))
        axes = figure.axes[0]
        for artist in [*axes.lines, *axes.texts]:
            artist.set_visible(False)
        picture = np.asarray(Image.open(io.BytesIO(png_bytes(figure, 50))).convert("RGB"), dtype=int)
        inner = picture[
            picture.shape[0] // 4 : picture.shape[0] // 2, picture.shape[1] // 4 : picture.shape[1] // 2
        ]
        shares.append((inner.min(axis=2) > 250).mean())
    assert shares[0] > 0.2 > shares[1]


def test_uncut_level_horizon_has_a_map():
    result = sample.uncut_result()
    points = result.surface.vertices * [1.0, 1.0, 0.0] + [0.0, 0.0, 100.0]
    level = Surface("level", points, result.surface.triangles)
    object.__setattr__(result, "surface", level)
    assert svg_bytes(map_figure(result, METRES))
    assert detail_window(result, 1.0) is None


def test_many_pieces_share_a_figure_and_say_what_is_left_out():
    result = sample.cut_result()
    line = result.cutoffs[0]
    pieces = tuple(
        Cutoff("F1", line.s, line.hanging, line.foot, line.throw * k / 15, line.heave) for k in range(1, 16)
    )
    object.__setattr__(result, "cutoffs", pieces)
    figure = throw_figure(result, METRES)
    assert "3 cutoffs" in figure.get_suptitle()
    assert figure.axes[0].get_title(loc="left") == "F1, piece 4 of 15"


def test_large_drawings_become_pictures():
    figure = map_figure(sample.cut_result(), METRES)
    assert data_address(figure, 10**7).startswith("data:image/svg+xml;base64,")
    address = data_address(figure, 60_000)
    assert address.startswith("data:image/png;base64,")
    assert base64.b64decode(address.split(",")[1]).startswith(b"\x89PNG")
