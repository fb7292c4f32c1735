"""Throw profiles, Allan diagrams, nets and convergence: what they show, for any names."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.patches import PathPatch

from graben.arrays import floats
from graben.reports.along_strike import fitted_name, looks
from graben.reports.convergence import run_convergence_figure
from graben.reports.images import png_bytes, svg_bytes
from graben.reports.juxtaposition import juxtaposition_figure
from graben.reports.stereonet import equal_area, mean_plane, poles, stereonet_figure, strike_shares
from graben.reports.style import Frame
from graben.reports.throw_profiles import throw_profile_figure
from graben.surface import Surface
from tests.modeling.test_strike import cut_by_wall, horizons, wall
from tests.reports import sample

METRES = Frame("m", 1.0)
DEPTH = Frame("m", -1.0)
NAMES = [
    sample.EVIL,
    "'\"><svg onload=x>",
    "x" * 300,
    "Störung \N{FIRE}\N{MOUNTAIN} 断層",
    "_hidden",
    "two\nlines\tand\x00more",
    "",
]


def legend(figure) -> list[str]:
    return [text.get_text() for box in figure.legends for text in box.get_texts()]


def texts(figure) -> list[str]:
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def test_a_throw_profile_has_a_line_for_every_horizon():
    results = horizons(30.0)
    figure = throw_profile_figure(results, wall(), METRES)
    (axes,) = figure.axes
    lines = [line for line in axes.lines if len(line.get_xdata()) > 2]
    assert [len(line.get_xdata()) for line in lines] == [7, 5, 9]
    for line in lines:
        np.testing.assert_array_equal(line.get_ydata(), 30.0)
        assert line.get_xdata()[-1] == pytest.approx(1000.0)
    assert legend(figure) == ["B", "C", "A"]
    # Both ends of each have throw, and a ring.
    assert sum(line.get_marker() == "o" for line in axes.lines) == 6
    assert texts(figure) == ["S", "N"]
    assert throw_profile_figure(results, Surface("other", wall().vertices, wall().triangles), METRES) is None


def test_tips_have_no_ring():
    figure = throw_profile_figure([sample.cut_result()], sample.fault().surface, METRES)
    assert not any(line.get_marker() == "o" for line in figure.axes[0].lines)


def test_an_allan_diagram_shows_layers_of_both_walls_and_numbers_where_they_meet():
    figure = juxtaposition_figure(horizons(60.0), wall(), METRES)
    (axes,) = figure.axes
    patches = [p for p in axes.patches if isinstance(p, PathPatch)]
    assert len(patches) == 4  # two layers on two walls
    assert [p.get_hatch() for p in patches] == [None, None, "////", "////"]
    assert len(axes.lines) == 6
    told = [t for t in texts(figure) if "|" in t]
    assert sorted(told) == ["2|1", "2|2"]
    box = patches[0].get_path().get_extents()
    assert (box.y0, box.y1) == (-50.0, 0.0)
    assert any(text.startswith("1  A") for text in legend(figure))


def test_depth_grows_downwards():
    figure = juxtaposition_figure(horizons(20.0), wall(), DEPTH)
    (axes,) = figure.axes
    low, high = axes.get_ylim()
    assert low > high
    assert axes.get_ylabel() == "depth [m]"
    box = axes.patches[0].get_path().get_extents()
    assert (box.y0, box.y1) == (0.0, 50.0)


def test_a_fault_of_one_horizon_has_no_diagram():
    assert juxtaposition_figure([cut_by_wall("A", 0.0, 9.0)], wall(), METRES) is None


@pytest.mark.parametrize(("dip", "azimuth"), [(30.0, 0.0), (60.0, 77.0), (85.0, 200.0), (45.0, 315.0)])
def test_poles_and_planes_on_the_net_lie_where_trigonometry_puts_them(dip, azimuth):
    d, a = np.radians(dip), np.radians(azimuth)
    down = np.array([np.sin(a) * np.cos(d), np.cos(a) * np.cos(d), -np.sin(d)])
    along = np.array([-np.cos(a), np.sin(a), 0.0])
    plane = Surface("P", floats([[0.0, 0.0, 0.0], along, along + down, down]), [[0, 1, 2], [0, 2, 3]])
    pole, area = poles(plane)
    assert area.sum() == pytest.approx(1.0)
    # The pole plunges 90 - dip, against the direction of dip.
    expected = np.sqrt(2.0) * np.sin(d / 2.0) * -np.array([np.sin(a), np.cos(a)])
    np.testing.assert_allclose(equal_area(pole), np.tile(expected, (2, 1)), atol=1e-9)
    circle = mean_plane(plane)
    np.testing.assert_allclose(np.hypot(*circle[[0, -1]].T), 1.0, atol=1e-9)
    deepest = circle[np.argmin(np.hypot(*circle.T))]
    expected = np.sqrt(2.0) * np.sin((np.pi / 2 - d) / 2.0) * np.array([np.sin(a), np.cos(a)])
    np.testing.assert_allclose(deepest, expected, atol=1e-9)
    shares = strike_shares([plane])
    assert shares.sum() == pytest.approx(1.0)
    assert np.argmax(shares) == int((azimuth + 90.0) % 180.0 // 10)


def test_the_net_keeps_areas():
    z = -np.linspace(0.0, 1.0, 101)[:, None]
    rings = equal_area(np.hstack([np.sqrt(1 - z**2), 0 * z, z]))
    # Zones of the sphere of equal height have equal area; so have their rings on the net.
    np.testing.assert_allclose(np.diff(rings[:, 0] ** 2), -0.01, atol=1e-9)


def test_the_net_shows_every_fault_and_the_rose_its_strikes():
    figure = stereonet_figure([wall(0.0), sample.fault().surface])
    rose = figure.axes[1]
    assert legend(figure) == ["W", "F1"]
    assert {"N", "E", "S", "W"} <= set(texts(figure))
    heights = np.array([bar.get_height() for bar in rose.patches])
    assert heights.sum() == pytest.approx(200.0)  # each petal with its opposite
    np.testing.assert_allclose(heights[:18], heights[18:])
    assert stereonet_figure([]) is None
    assert stereonet_figure([Surface("flat", floats([[0, 0, 0], [1, 0, 0], [2, 0, 0]]), [[0, 1, 2]])]) is None


def test_convergence_has_a_line_for_each_subdomain_and_marks_what_failed():
    failed = sample.failed_run().horizons[0]
    good = sample.cut_result("Top B")
    (subdomain,) = good.subdomains
    twice = replace(good, subdomains=(subdomain, replace(subdomain, id=1, history=(5.0, 0.0))))
    figure = run_convergence_figure([failed, twice, sample.uncut_result()], 0.1, METRES)
    (axes,) = figure.axes
    assert axes.get_yscale() == "log"
    assert [line.get_marker() for line in axes.lines] == ["None", "X", "None", "o", "None", "o", "None"]
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), subdomain.history)
    np.testing.assert_array_equal(axes.lines[-1].get_ydata(), 0.1)
    assert "type 3" in texts(figure)
    assert legend(figure) == ["Top A", "Top B"]
    assert run_convergence_figure([sample.uncut_result()], 0.1, METRES) is None


def all_figures(names: list[str]):
    """The four figures of horizons and faults of these names; the first fault is drawn."""
    results = [
        replace(r, horizon=replace(r.horizon, name=name), cutoffs=(replace(r.cutoffs[0], fault=names[0]),))
        for r, name in ((cut_by_wall("H", -50.0 * k, 20.0), name) for k, name in enumerate(names))
    ]
    faults = [Surface(name, wall().vertices, wall().triangles) for name in names]
    yield throw_profile_figure(results, faults[0], METRES)
    yield juxtaposition_figure(results, faults[0], METRES)
    yield stereonet_figure(faults)
    yield run_convergence_figure(results, 0.1, METRES)


def test_any_names_are_drawn_as_they_stand_and_do_no_harm():
    for figure in all_figures(NAMES):
        root = ElementTree.fromstring(svg_bytes(figure))
        assert not [e for e in root.iter() if e.tag.endswith("script") or "onload" in e.attrib]
        assert all(len(line) < 80 for text in legend(figure) for line in text.splitlines())


@pytest.mark.parametrize("name", NAMES, ids=range(len(NAMES)))
def test_every_name_gets_a_place_in_the_legends(name):
    profile, diagram, net, course = all_figures([name, "B"])
    for figure in (profile, net, course):
        assert legend(figure) == [fitted_name(name), "B"]
    assert len(legend(diagram)) == 5
    assert max(len(axes.get_title(loc="left")) for axes in profile.axes) < 100


def test_the_same_picture_comes_twice():
    names = ["F1", "F2"]
    first, second = ([png_bytes(f, 40) for f in islice(all_figures(names), 1, 2)] for _ in range(2))
    assert first == second


def test_many_horizons_are_told_apart_and_the_legend_stays_short():
    many = [cut_by_wall(f"H{k}", -10.0 * k, 15.0) for k in range(25)]
    for draw in (throw_profile_figure, juxtaposition_figure):
        figure = draw(many, wall(), METRES)
        assert legend(figure)[-1].startswith("and ")
        assert len(legend(figure)) < 20
    assert len(set(looks(25))) == 25
    assert len(set(looks(7))) == 7


@pytest.mark.parametrize("name", NAMES, ids=range(len(NAMES)))
def test_fitted_names_are_short_lines_that_a_legend_shows(name):
    told = fitted_name(name, 20)
    assert len(told) <= 21
    assert not told.startswith("_")
    assert "\n" not in told
