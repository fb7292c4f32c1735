from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from graben.errors import ModelingError
from graben.modeling.coverage import MARGIN
from graben.modeling.fitting import NOISE_ACCURACY, fit_points
from graben.surface import boundary_loops, edge_sharing, edge_table
from tests.modeling.meshes import area, turned

DATA = Path(__file__).parents[3] / "shared" / "data"


def hills(plan):
    return np.sin(2 * np.pi * plan[:, 0]) * np.cos(1.5 * np.pi * plan[:, 1])


def scattered_picks(count, value=hills, seed=0):
    plan = np.random.default_rng(seed).random((count, 2))
    return np.column_stack([plan, value(plan)])


def smallest_angle(surface):
    corner = surface.vertices[surface.triangles][:, :, :2]
    sides = np.linalg.norm(np.roll(corner, -1, axis=1) - np.roll(corner, 1, axis=1), axis=2)
    a, b, c = np.sort(sides, axis=1).T
    return np.degrees(np.arccos((b**2 + c**2 - a**2) / (2 * b * c))).min()


def rms(values):
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("size", [1e-3, 1.0, 5e4])
def test_planes_are_reproduced_at_any_size_and_place(size):
    def plane(plan):
        return 0.2 * plan[:, 0] - 0.3 * plan[:, 1]

    picks = size * scattered_picks(2000, plane) + [4e5, 7e6, -2e3]
    surface = fit_points(picks, size / 40)
    error = surface.vertices[:, 2] + 2e3 - plane(surface.vertices[:, :2] - [4e5, 7e6])
    # 7e6 itself has no more than nine digits below one.
    assert np.abs(error).max() < 1e-9 * size + 1e-9
    assert np.nanmax(np.abs(surface.residuals)) < 1e-9 * size + 1e-9


def test_a_smooth_surface_is_found_with_the_order_of_linear_interpolation():
    errors = []
    for step in (0.05, 0.025, 0.0125):
        vertices = fit_points(scattered_picks(int(step**-2)), step).vertices
        covered = ((vertices[:, :2] > 0) & (vertices[:, :2] < 1)).all(axis=1)
        errors.append(rms((vertices[:, 2] - hills(vertices[:, :2]))[covered]))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 1.8).all()
    assert errors[-1] < 2e-3


def test_noise_is_brought_to_the_residual_and_the_error_falls():
    picks = scattered_picks(4000)
    picks[:, 2] += 0.1 * np.random.default_rng(4).standard_normal(4000)
    plain, smooth = fit_points(picks, 0.02), fit_points(picks, 0.02, noise=0.1)
    assert rms(smooth.residuals) == pytest.approx(0.1, rel=NOISE_ACCURACY)
    assert smooth.smoothing > plain.smoothing == pytest.approx(0.02)

    def error(surface):
        inner = (np.abs(surface.vertices[:, :2] - 0.5) < 0.45).all(axis=1)
        return rms((surface.vertices[:, 2] - hills(surface.vertices[:, :2]))[inner])

    assert error(smooth) < 0.8 * error(plain)


def test_noise_beyond_any_relief_gives_nearly_a_plane():
    surface = fit_points(scattered_picks(1000), 0.04, noise=50.0)
    design = np.column_stack([np.ones(len(surface.vertices)), surface.vertices[:, :2]])
    plane = np.linalg.lstsq(design, surface.vertices[:, 2], rcond=None)[0]
    assert np.abs(surface.vertices[:, 2] - design @ plane).max() < 1e-3


def test_the_surface_turns_and_moves_with_the_picks_whatever_their_order():
    picks = scattered_picks(3000)
    picks[:, 0] *= 1.3
    first = fit_points(picks, 0.02)
    order = np.random.default_rng(5).permutation(len(picks))
    shift = np.array([5e5, 7e6])
    moved = np.column_stack([1e3 * turned(picks[:, :2], 17.0) + shift, 1e3 * picks[:, 2]])
    second = fit_points(moved[order], 20.0)
    assert len(second.vertices) == len(first.vertices)
    expected = 1e3 * turned(first.vertices[:, :2], 17.0) + shift
    distance, nearest = cKDTree(second.vertices[:, :2]).query(expected)
    assert distance.max() < 1e-6 * 20.0
    assert second.vertices[nearest, 2] == pytest.approx(1e3 * first.vertices[:, 2], abs=1e-6)
    assert second.residuals == pytest.approx(1e3 * first.residuals[order], abs=1e-6)


def test_triangles_are_good_and_lie_on_the_picks():
    picks = scattered_picks(2500)
    surface = fit_points(picks, 0.02)
    assert smallest_angle(surface) > 20.0
    edges, sides = edge_table(surface.triangles)
    assert edge_sharing(sides, len(edges)).max() == 2
    assert len(boundary_loops(surface.triangles)) == 1
    distance = cKDTree(picks[:, :2]).query(surface.vertices[:, :2])[0]
    assert distance.max() < 3.0 * 0.02
    assert (
        (surface.vertices[:, :2] > -1.1 * MARGIN * 0.02) & (surface.vertices[:, :2] < 1 + 1.1 * MARGIN * 0.02)
    ).all()
    plan = surface.vertices[:, :2]
    assert len(plan) * 0.02**2 == pytest.approx(area(plan, surface.triangles), rel=0.1)


@pytest.mark.parametrize(("width", "loops"), [(0.15, 1), (0.4, 2)])
def test_narrow_holes_are_filled_and_wide_ones_are_not(width, loops):
    picks = scattered_picks(2500)
    hole = (np.abs(picks[:, :2] - 0.5) < width / 2).all(axis=1)
    surface = fit_points(picks[~hole], 0.02)
    assert len(boundary_loops(surface.triangles)) == loops
    assert area(surface.vertices[:, :2], surface.triangles) == pytest.approx(
        1.07 - (loops - 1) * width**2, rel=0.05
    )


def test_picks_that_stand_alone_are_left_out_and_named():
    picks = np.concatenate([scattered_picks(2000), [[2.0, 2.0, 0.0], [np.nan, 0.5, 0.0]]])
    surface = fit_points(picks, 0.025)
    assert np.isnan(surface.residuals).tolist() == [False] * 2000 + [True] * 2
    assert "2 points" in surface.note
    assert surface.vertices[:, 0].max() < 1.1


def test_picks_at_one_place_count_as_their_mean():
    picks = scattered_picks(1500)
    up = np.array([0.0, 0.0, 0.3])
    doubled = np.concatenate([picks + up, picks - up])
    one, other = fit_points(picks, 0.03), fit_points(doubled, 0.03)
    assert other.vertices == pytest.approx(one.vertices, abs=1e-12)
    assert other.residuals[:1500] == pytest.approx(one.residuals + 0.3, abs=1e-12)


def test_picks_further_apart_than_the_step_still_make_one_surface():
    surface = fit_points(scattered_picks(100), 0.01)
    assert len(boundary_loops(surface.triangles)) == 1
    assert area(surface.vertices[:, :2], surface.triangles) > 0.8


@pytest.mark.parametrize(
    ("picks", "reason"),
    [
        (np.zeros((0, 3)), "fewer than three"),
        (np.array([[0.0, 0, 0], [1, 0, 0]]), "fewer than three"),
        (np.column_stack([np.arange(9.0), 2 * np.arange(9.0), np.arange(9.0)]), "line"),
        (np.column_stack([np.arange(9.0) / 3 + 4e5, np.arange(9.0) / 7 + 6e6, np.arange(9.0)]), "line"),
        (np.tile([[1.0, 2, 3]], (5, 1)), "line"),
    ],
)
def test_picks_that_span_nothing_are_refused_in_one_sentence(picks, reason):
    with pytest.raises(ModelingError, match=reason) as error:
        fit_points(picks, 1.0, name="Top A")
    assert "'Top A'" in str(error.value)
    assert ". " not in str(error.value)


@pytest.mark.skipif(not DATA.is_dir(), reason="../shared/data is missing")
@pytest.mark.parametrize(("name", "step"), [("H1", 0.1), ("H5", 0.1), ("H8", 0.1)])
def test_real_picks_sixteen_units_wide(name, step):
    picks = np.loadtxt(DATA / "hecho" / f"{name}.csv", delimiter=";", skiprows=1, usecols=(0, 1, 2))
    surface = fit_points(picks, step)
    assert smallest_angle(surface) > 20.0
    assert np.isfinite(surface.residuals).all()


@pytest.mark.skipif(not DATA.is_dir(), reason="../shared/data is missing")
def test_real_picks_of_a_survey():
    picks = np.loadtxt(DATA / "claudius" / "APoints.csv", delimiter=";", skiprows=1, usecols=(0, 1, 2))
    surface = fit_points(picks, 50.0)
    assert len(boundary_loops(surface.triangles)) == 1
    assert rms(surface.residuals) < 2.0
    assert smallest_angle(surface) > 20.0
