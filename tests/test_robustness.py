"""Inputs at the edge of the possible end with a result or a reason, never with an error of graben's own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from graben.arrays import FloatArray
from graben.errors import InputError, OutputError
from graben.formats.stick_surface import sticks_surface
from graben.formats.text import load_bytes
from graben.formats.writing import write_model
from graben.model import Fault, Horizon, Model
from graben.output import require_free, whole_folder
from graben.pipeline import RunResult, build, check
from graben.reading import read_model
from graben.reports.writing import write_run
from graben.surface import Surface
from tests.models import grid_horizon, grid_triangles, model_of, plane_fault

STEP = 100.0
GAMMA = 400.0
NORTH = ((0.0, -1500.0), (0.0, 1500.0))


def height(x: FloatArray, y: FloatArray) -> FloatArray:
    """A slope with a smeared step along x = 0 that dies out at y = -1500 and 1500."""
    profile = np.clip(1 - (y / 1500) ** 2, 0, 1) ** 1.5
    return 0.05 * x + 0.02 * y - 30 * np.exp(-((x / 900) ** 2)) * (1 + np.tanh(x / 100)) * profile


def flat(x: FloatArray, y: FloatArray) -> FloatArray:
    return 0.0 * x


def built(*faults: Fault, surface: Callable[[FloatArray, FloatArray], FloatArray] = height) -> RunResult:
    return build(model_of(grid_horizon(surface, step=STEP), *faults, gamma=GAMMA))


def shifted(fault: Fault, offset: tuple[float, float, float], name: str = "F2") -> Fault:
    return Fault(Surface(name, fault.surface.vertices + np.array(offset), fault.surface.triangles))


def cylinder(radius: float, count: int = 40) -> Fault:
    """A vertical fault whose trace is closed."""
    around = np.linspace(0, 2 * np.pi, count + 1)
    z = np.linspace(-400.0, 400.0, 9)
    points = np.stack(
        [np.repeat(radius * np.cos(around), 9), np.repeat(radius * np.sin(around), 9), np.tile(z, count + 1)],
        axis=1,
    )
    triangles = grid_triangles(count + 1, 9)
    return Fault(
        Surface(
            "F1", points[: 9 * count], np.where(triangles < 9 * count, triangles, triangles % (9 * count))
        )
    )


@pytest.mark.parametrize("offset", [0.0, 1e-12, 1e-9, 1e-3, 0.02])
def test_a_fault_given_twice_is_named_not_modeled(offset: float) -> None:
    fault = plane_fault(*NORTH)
    result = built(fault, shifted(fault, (offset, 0.0, 0.0)))
    assert not result.horizons
    assert "F1 and F2" in result.not_modeled["H"]
    assert any(f.objects[-2:] == ("F1", "F2") and f.status.value == "fail" for f in result.after.findings)


@pytest.mark.parametrize("gap", [-1e-3, -1e-9, 0.0, 1e-9, 1e-3, 0.05])
def test_a_fault_that_ends_at_another_to_the_digits_of_its_file_is_a_t(gap: float) -> None:
    main = plane_fault(*NORTH, dip=90)
    branch = plane_fault((gap, 0.0), (1200.0, 300.0), dip=90, name="F2")
    result = built(main, branch)
    failing = {f.check for f in result.before.findings if f.status.value == "fail"}
    assert failing == {"junction-values" if gap > 1e-2 else "simplicial-complex"}
    assert result.passed  # the repair has given the two common edges
    graph = result["H"].graph
    ends = np.flatnonzero(np.bincount(graph.edges.ravel()) == 3)
    assert len(ends) == 1
    assert np.hypot(*graph.nodes[ends[0], :2]) < 1e-3 * STEP


@pytest.mark.parametrize("gap", [-1.0, 0.0, 1e-9, 1e-6, 1e-3, 0.05])
def test_a_fault_that_ends_at_the_boundary_to_the_digits_of_its_file_leaves_through_it(gap: float) -> None:
    result = built(plane_fault((0.0, -2000.0 + gap), (0.0, 2000.0 - gap)))
    assert result.passed
    assert len(result["H"].subdomains) == 2


@pytest.mark.parametrize("inward", [0.0, 1e-6, 0.05])
def test_a_fault_along_the_boundary_cuts_nothing_and_is_named(inward: float) -> None:
    x = 2000.0 - inward
    result = built(plane_fault((x, -1500.0), (x, 1500.0), dip=90))
    assert result.passed
    (finding,) = [f for f in result.after.findings if f.check == "trace"]
    assert finding.status.value == "warn"
    assert "boundary" in finding.message


@pytest.mark.parametrize("gap", [0.1, 1.0, 30.0])
@pytest.mark.parametrize("sides", [1, 2])
def test_a_horizon_that_stops_short_of_a_fault_is_named_with_the_distance(gap: float, sides: int) -> None:
    whole = grid_horizon(flat, step=STEP)
    x, y, z = whole.surface.vertices.T
    north = (y[whole.surface.triangles] >= 0).all(axis=1)
    south = (y[whole.surface.triangles] <= 0).all(axis=1) & (sides == 2)
    # each side has nodes of its own along the fault
    n = len(x)
    vertices = np.concatenate([np.stack([x, y + gap, z], axis=1), np.stack([x, y - gap, z], axis=1)])
    triangles = np.concatenate([whole.surface.triangles[north], whole.surface.triangles[south] + n])
    used, index = np.unique(triangles, return_inverse=True)
    surface = Surface("H", vertices[used], index.reshape(-1, 3))
    model = model_of(Horizon("H", surface, STEP), plane_fault((-3000.0, 0.0), (3000.0, 0.0), dip=90))
    (finding,) = check(model).of("trace")
    assert finding.status.value == "warn" and finding.objects == ("H", "F1")
    assert finding.worst is not None and np.isclose(finding.worst.value, gap, rtol=0.01)
    assert finding.message.startswith("H ends") and abs(finding.worst.y) <= gap + 1


def test_a_fault_in_the_horizon_is_named() -> None:
    corners = np.array([[-500.0, -500, 0], [500, -500, 0], [500, 500, 0], [-500, 500, 0]])
    result = built(Fault(Surface("F1", corners, np.array([[0, 1, 2], [0, 2, 3]]))), surface=flat)
    assert "F1 lies in the horizon" in result.not_modeled["H"]


@pytest.mark.parametrize("angle", [0.003, 0.03, 0.3])
def test_faults_that_cross_at_a_small_angle_cross_in_one_point(angle: float) -> None:
    way = 1400.0 * np.array([np.sin(angle), np.cos(angle)])
    other = plane_fault((-way[0], 30 - way[1]), (way[0], 30 + way[1]), name="F2", parts=(17, 8))
    result = built(plane_fault(*NORTH), other)
    assert (np.bincount(result["H"].graph.edges.ravel()) == 4).sum() == 1


def test_three_faults_through_one_point_to_rounding_meet_in_one_node() -> None:
    way = [1200.0 * np.array([np.cos(a), np.sin(a)]) for a in (0.3, 1.3, 2.3)]
    faults = [plane_fault((-w[0], -w[1]), (w[0], w[1]), dip=89.999, name=f"F{k}") for k, w in enumerate(way)]
    result = built(*faults)
    assert (np.bincount(result["H"].graph.edges.ravel()) == 6).sum() == 1
    assert np.isfinite(result["H"].surface.vertices).all()


def test_a_closed_trace_is_cut_and_another_fault_may_cross_it() -> None:
    assert built(cylinder(800.0)).passed
    crossed = built(cylinder(900.0), plane_fault((-1800.0, -300.0), (1800.0, 300.0), dip=75, name="F2"))
    assert len(crossed["H"].subdomains) == 3 and crossed["H"].converged


def test_pieces_left_out_leave_no_node_behind() -> None:
    stub = plane_fault((-60.0, 0.0), (1200.0, 300.0), dip=80, name="F2")
    graph = built(plane_fault(*NORTH), stub)["H"].graph
    assert np.isin(np.arange(len(graph.nodes)), graph.edges).all()


def test_a_gamma_wider_than_any_horizon_takes_no_more_memory() -> None:
    result = build(model_of(grid_horizon(height, step=200.0), plane_fault(*NORTH), gamma=1e9))
    assert result.horizons or result.not_modeled


def test_a_grid_described_by_numpy_numbers_is_written_to_be_read(tmp_path: Path) -> None:
    horizon = grid_horizon(height, size=np.float64(2000.0), step=np.float64(200.0))  # type: ignore[arg-type]
    assert read_model(write_model(Model("M", (horizon,)), tmp_path)).horizons[0].grid == horizon.grid


@pytest.mark.parametrize(
    "name", ["a\x00b", "new\nline", "</script><script>", "..", "x" * 300, "model", "END"]
)
def test_any_name_is_written_to_be_read(tmp_path: Path, name: str) -> None:
    result = build(
        model_of(
            grid_horizon(flat, step=200.0, name=name), plane_fault(*NORTH, name=name + "!", parts=(2, 2))
        )
    )
    write_run(result, tmp_path)
    again = read_model(tmp_path / "model" / "model.toml")
    assert [s.name for s in again.surfaces] == [name, name + "!"]
    assert "<script><" not in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_device_is_no_file() -> None:
    with pytest.raises(InputError, match="device"):
        load_bytes(Path("/dev/zero"))


def test_stick_points_that_are_no_places_are_left_loose() -> None:
    sticks = [np.array([[1e300, 0, 0], [0.0, 0, -1], [0, 0, -2]]), np.array([[0.0, 1, -1], [0, 1, -2]])]
    surface = sticks_surface("F", sticks)
    assert len(surface.triangles)
    assert (np.abs(surface.vertices[surface.triangles]) < 10).all()


def test_an_output_that_cannot_be_made_is_refused_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to("folder")
    for target in ("file", "file/x", "file/x/y", "link"):
        with pytest.raises(OutputError):
            require_free(tmp_path / target)


def test_a_link_in_the_place_of_the_partial_folder_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / ".graben-partial").touch()
    (tmp_path / "x.partial").symlink_to("other")
    with pytest.raises(OutputError, match="in the way"), whole_folder(tmp_path / "x"):
        pass
    assert (tmp_path / "x.partial").is_symlink() and (tmp_path / "other" / ".graben-partial").exists()
