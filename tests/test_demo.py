"""The synthetic models: is the known answer one, and does what is written say the same?"""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from graben import demo
from graben.demo_catalogue import SIZE, THROW
from graben.errors import InputError
from graben.formats.irap import read_irap
from graben.formats.tsurf import read_tsurf
from graben.settings import ModelFile
from graben.surface import Surface, boundary_edges, edge_sharing, edge_table, strong_components, triangle_dips

NAMES = list(demo.names())
TRUTH_TO = 0.1  # what the truth may miss the faults by, m


@cache
def built(name: str) -> demo.SyntheticModel:
    return demo.build(name)


def height_above(surface: Surface, points: np.ndarray) -> np.ndarray:
    """Return z minus the surface's elevation at the same place in plan; NaN beyond the surface."""
    result = np.full(len(points), np.nan)
    corners = surface.vertices[surface.triangles]
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    for k, p in enumerate(points):
        d = p[:2] - a[:, :2]
        v = (d[:, 0] * ac[:, 1] - d[:, 1] * ac[:, 0]) / area
        w = (ab[:, 0] * d[:, 1] - ab[:, 1] * d[:, 0]) / area
        inside = np.flatnonzero(np.minimum(np.minimum(v, w), 1.0 - v - w) >= -1e-6)
        if len(inside):
            t = inside[0]
            result[k] = p[2] - (a[t, 2] + v[t] * ab[t, 2] + w[t] * ac[t, 2])
    return result


def traces(model: demo.SyntheticModel) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Yield each fault's index with s and d of the grid nodes."""
    xy = model.frame.inward(model.grid.nodes())
    for f, fault in enumerate(model.geology.faults):
        yield f, fault.coordinates(xy)[0], model.geology.distance(f, xy)


@pytest.mark.parametrize("name", NAMES)
def test_true_lips_lie_on_the_triangulated_faults(name: str) -> None:
    model = built(name)
    for cutoff in model.cutoffs:
        above = height_above(model.faults[cutoff.fault], cutoff.points[::10])
        assert np.isfinite(above).all()
        assert np.abs(above).max() < TRUTH_TO


@pytest.mark.parametrize("name", NAMES)
def test_true_lips_are_the_true_horizon_of_their_block(name: str) -> None:
    model = built(name)
    for cutoff in model.cutoffs:
        z = model.horizon(cutoff.block, cutoff.points[:, :2])
        np.testing.assert_allclose(z, cutoff.points[:, 2], atol=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_faults_reach_well_above_and_below_the_lips(name: str) -> None:
    model = built(name)
    for cutoff in model.cutoffs:
        z = model.faults[cutoff.fault].vertices[:, 2]
        assert cutoff.points[:, 2].min() - z.min() >= demo.MARGIN
        assert z.max() - cutoff.points[:, 2].max() >= demo.MARGIN


@pytest.mark.parametrize("name", NAMES)
def test_faults_are_single_oriented_sheets_of_plain_triangles(name: str) -> None:
    model = built(name)
    for surface, fault in zip(model.faults, model.geology.faults, strict=True):
        edges, sides = edge_table(surface.triangles)
        assert edge_sharing(sides, len(edges)).max() == 2
        assert strong_components(surface.triangles).max() == 0
        # a disk: V - E + T = 1; oriented: no directed edge twice
        assert len(surface.vertices) - len(edges) + len(surface.triangles) == 1
        directed = np.concatenate([surface.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
        assert len(np.unique(directed, axis=0)) == len(directed)
        dips = triangle_dips(surface.vertices, surface.triangles)
        assert fault.dip - 1e-6 <= dips.min() and dips.max() < fault.dip + 6.0
        assert len(boundary_edges(surface.triangles)) < len(edges) / 2


def test_single_has_the_throw_profile_at_the_trace() -> None:
    model = built("single")
    fault = model.geology.faults[0]
    s = np.linspace(-2500.0, 2500.0, 21)
    on_trace = fault.position(s, model.geology.traces[0](s))
    separation = model.geology.horizon((-1,), on_trace) - model.geology.horizon((1,), on_trace)
    np.testing.assert_allclose(separation, THROW * (1.0 - (s / 2500.0) ** 2) ** 1.5, atol=1e-6)


@pytest.mark.parametrize("name", ["single", "reverse", "low-dip", "low-dip-12"])
def test_throw_is_the_separation_less_the_regional_slope_across_the_heave(name: str) -> None:
    model = built(name)
    regional, fault = model.geology.regional, model.geology.faults[0]
    hanging, foot = sorted(model.cutoffs, key=lambda c: -c.side)
    rise = regional(hanging.points[:, :2]) - regional(foot.points[:, :2])
    out = fault.coordinates(hanging.points[:, :2])[1] - fault.coordinates(foot.points[:, :2])[1]
    separation = fault.separation(fault.coordinates(hanging.points[:, :2])[0])
    # displacement has died out a little at the lips: exp(-(heave / 2 / 1500)^2) > 0.97
    loss = separation - (hanging.throw + rise)
    assert (np.abs(loss) <= 0.03 * np.abs(separation) + 1e-6).all()
    assert (out * fault.throw >= -1e-6).all()
    np.testing.assert_allclose(hanging.throw, out * fault.grade, atol=1e-5)


def test_branch_throw_is_largest_at_the_branch_line_and_ends_at_the_free_tip() -> None:
    model = built("tee")
    for cutoff in (c for c in model.cutoffs if c.fault == 1):
        profile = cutoff.throw[np.argsort(cutoff.s)]
        assert profile[0] > 0.95 * profile.max() > 120.0
        assert abs(profile[-1]) < 1e-6


def test_cross_has_four_blocks_whose_lips_meet_in_pairs_on_the_branch_line() -> None:
    model = built("cross")
    assert len(model.geology.blocks) == 4
    for block in range(4):
        lips = [c for c in model.cutoffs if c.block == block]
        assert {c.fault for c in lips} == {0, 1}
        gaps = np.linalg.norm(lips[0].points[[0, -1], None, :] - lips[1].points[None, [0, -1], :], axis=-1)
        assert gaps.min() < 1e-3


def test_seismic_is_the_true_horizon_off_the_faults() -> None:
    model = built("single")
    (_, s, d) = next(traces(model))
    xy = model.grid.nodes()
    far = np.abs(d) >= model.gamma
    for block, side in ((0, 1), (1, -1)):
        mine = far & (np.sign(d) == side)
        off = model.values[mine] - model.horizon(block, xy[mine])
        assert np.abs(off).max() < 0.005 * THROW
    beyond = np.abs(s) >= 2500.0
    regional = model.geology.regional(model.frame.inward(xy))
    np.testing.assert_allclose(model.values[beyond], regional[beyond], atol=1e-9)


def test_true_horizon_is_continuous_around_tips() -> None:
    for name in ("single", "tee", "cross", "elliptic"):
        model = built(name)
        xy = model.frame.inward(model.grid.nodes())
        outside = [np.abs(f.coordinates(xy)[0]) >= f.half_length for f in model.geology.faults]
        nowhere = np.logical_and.reduce(outside)
        values = [model.horizon(b, model.grid.nodes()[nowhere]) for b in range(len(model.geology.blocks))]
        assert nowhere.any()
        np.testing.assert_allclose(np.ptp(values, axis=0), 0.0, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_gamma_covers_half_the_heave_and_two_smears(name: str) -> None:
    model = built(name)
    half = max(float(h.max()) for _, h in model.geology.half_heaves)
    assert model.gamma >= half + 2.0 * 120.0


@pytest.mark.parametrize("name", ["low-dip", "low-dip-12"])
def test_low_dip_horizon_dips_against_the_fault_and_meets_it_once(name: str) -> None:
    geology = built(name).geology
    fault = geology.faults[0]
    s, q = np.meshgrid(np.linspace(-2490.0, 2490.0, 51), np.arange(-1200.0, 1200.0, 5.0), indexing="ij")
    above = geology.seismic(fault.position(s, q)) - fault.elevation_at(s, q)
    assert (np.count_nonzero(np.diff(above > 0.0, axis=1), axis=1) == 1).all()
    down = fault.axes[1]
    rise = geology.regional(np.array(fault.centre) + 1000.0 * down) - geology.regional(np.array(fault.centre))
    assert rise > 50.0


def test_exits_leave_with_throw() -> None:
    for name, ends in (("exit", 1), ("exit-both", 2)):
        for cutoff in built(name).cutoffs:
            near = np.minimum(cutoff.points[:, 1], SIZE[1] - cutoff.points[:, 1]) < 1e-3
            assert np.count_nonzero(near) == ends
            assert (cutoff.throw[near] > 60.0).all()


def test_reverse_lips_overlap() -> None:
    model = built("reverse")
    hanging, foot = sorted(model.cutoffs, key=lambda c: -c.side)
    down = model.geology.faults[0].axes[1]
    middle = slice(100, 400)
    assert (((hanging.points - foot.points)[middle, :2] @ down) < -50.0).all()
    assert (hanging.throw[middle] < -20.0).all()


def test_branch_line_is_shared_to_the_bit_in_the_files(tmp_path: Path) -> None:
    demo.write(demo.build("tee", rotation=17.0, shift=(431_234.56, 6_512_345.67), shuffle=3), tmp_path)
    main, branch = (read_tsurf(tmp_path / f"{name}.ts")[0].surface for name in ("F1", "F2"))
    where = {tuple(v): k for k, v in enumerate(main.vertices.tolist())}
    rim = boundary_edges(branch.triangles)
    shared = [(where.get(tuple(branch.vertices[a])), where.get(tuple(branch.vertices[b]))) for a, b in rim]
    joined = {tuple(sorted(e)) for e in shared if None not in e}
    edges = {tuple(e) for e in edge_table(main.triangles)[0].tolist()}
    assert len(joined) >= 5
    assert joined <= edges
    z = np.array([main.vertices[k, 2] for e in joined for k in e])
    assert (z.min(), z.max()) == (branch.vertices[:, 2].min(), branch.vertices[:, 2].max())


@pytest.mark.parametrize("step", [50.0, 200.0])
def test_steps_sample_one_geology(step: float) -> None:
    fine, coarse = sorted([built("single"), demo.build("single", step=step)], key=lambda m: m.grid.step)
    every = round(coarse.grid.step / fine.grid.step)
    np.testing.assert_allclose(fine.values[::every, ::every], coarse.values, atol=1e-9)


@pytest.mark.parametrize(("rotation", "mirrored"), [(17.0, False), (45.0, True), (0.0, True)])
def test_moved_models_are_the_same_model(rotation: float, mirrored: bool) -> None:
    plain, moved = (
        built("single"),
        demo.build("single", rotation=rotation, mirrored=mirrored, shift=(1e5, 2e5)),
    )
    nodes = plain.grid.nodes()
    np.testing.assert_allclose(moved.frame.inward(moved.frame.outward(nodes)), nodes, atol=1e-6)
    expected = plain.values[::-1] if mirrored else plain.values
    np.testing.assert_allclose(moved.values, expected, atol=1e-6)
    back = moved.frame.inward(moved.faults[0].vertices[:, :2])
    np.testing.assert_allclose(back, plain.faults[0].vertices[:, :2], atol=1e-6)
    upwards = [s.triangles[0] for s in (plain.faults[0], moved.faults[0])]
    normals = [
        np.cross(*(m.faults[0].vertices[t[1:]] - m.faults[0].vertices[t[0]]))[2]
        for m, t in zip((plain, moved), upwards, strict=True)
    ]
    assert np.sign(normals[0]) == np.sign(normals[1])


def test_shuffled_faults_are_the_same_surface_in_another_order() -> None:
    plain, other = built("single").faults[0], demo.build("single", shuffle=1).faults[0]
    assert not np.array_equal(plain.vertices, other.vertices)

    def corners(s: Surface) -> set[frozenset[tuple[float, ...]]]:
        return {frozenset(map(tuple, t)) for t in s.vertices[s.triangles].tolist()}

    assert corners(plain) == corners(other)


def test_noise_has_its_standard_deviation_and_follows_its_seed() -> None:
    plain, noisy = built("single"), demo.build("single", noise=2.0, seed=1)
    off = noisy.values - plain.values
    assert abs(off.std() - 2.0) < 0.1 and abs(off.mean()) < 0.1
    assert np.array_equal(noisy.values, demo.build("single", noise=2.0, seed=1).values)


@pytest.mark.parametrize("name", ["single", "tee"])
def test_what_is_written_is_what_was_built(name: str, tmp_path: Path) -> None:
    import tomllib

    model = built(name)
    demo.write(model, tmp_path)
    settings = ModelFile.model_validate(tomllib.loads((tmp_path / "model.toml").read_text()))
    assert settings.parameters.gamma == model.gamma and settings.model.truth == "truth"
    geometry, values = read_irap(tmp_path / settings.horizons[0].file)
    assert geometry == model.grid and np.array_equal(values, model.values)
    for surface, section in zip(model.faults, settings.faults, strict=True):
        read = read_tsurf(tmp_path / section.file)[0]
        assert read.z == "elevation" and np.array_equal(read.surface.vertices, surface.vertices)
    truth = tmp_path / "truth"
    index = json.loads((truth / "truth.json").read_text())
    for b, entry in enumerate(index["horizons"][demo.HORIZON]["blocks"]):
        fine, block = read_irap(truth / entry["file"])
        assert fine.step == 0.5 * model.grid.step
        np.testing.assert_allclose(block, model.horizon(b, fine.nodes()), atol=1e-9)


def test_same_model_gives_same_bytes(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        demo.write(demo.build("short", noise=1.0), tmp_path / folder)
    files = sorted(p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file())
    assert files
    assert all((tmp_path / "a" / f).read_bytes() == (tmp_path / "b" / f).read_bytes() for f in files)


def test_unfit_steps_are_told_in_a_sentence() -> None:
    for step in (130.0, 0.0):
        with pytest.raises(InputError, match="does not divide the domain"):
            demo.build("single", step=step)
