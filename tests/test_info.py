from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graben.errors import InputError
from graben.formats.kinds import Kind
from graben.info import GridInfo, PointsInfo, SticksInfo, SurfaceInfo, describe, surface_info
from graben.surface import Surface
from tests.formats.test_meshes import fault_files
from tests.formats.zmap_samples import PLAIN
from tests.test_reading import folder_of
from tests.zoo.shapes import F60

DATA = Path(__file__).parents[2] / "shared" / "data"


@pytest.mark.parametrize("shift", [0.0, 5e5])
@pytest.mark.parametrize(("strike", "dip"), [(0.0, 60.0), (30.0, 12.0), (90.0, 89.0), (135.0, 90.0)])
def test_dip_and_strike_of_a_plane(strike: float, dip: float, shift: float) -> None:
    s, d = np.radians(strike), np.radians(dip)
    along = np.array([np.sin(s), np.cos(s), 0])
    down = np.array([np.cos(s) * np.cos(d), -np.sin(s) * np.cos(d), -np.sin(d)])
    corners = [a * 1000 * along + b * 400 * down + shift for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    info = surface_info(Surface("F", corners, [[0, 1, 2], [0, 3, 2]]))
    assert np.isclose(info.mean_dip, dip, atol=1e-4) and np.isclose(info.least_dip, dip, atol=1e-4)
    assert min(abs(info.strike - strike), 180 - abs(info.strike - strike)) < 1e-3
    assert np.isclose(info.dip_direction, strike + 90.0, atol=1e-3)
    assert (info.loops, info.components, info.unfit) == (1, 1, 0)


def test_unfit_surfaces_are_described() -> None:
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 1], [np.nan, 0, 0]]
    info = surface_info(Surface("F", vertices, [[0, 1, 2], [0, 1, 9], [0, 3, 2], [0, 0, 0]]))
    assert info.unfit == 2 and info.extents.high == (1, 1, 1) and np.isclose(info.mean_dip, 45)
    assert "unfit triangles 2" in str(info)
    nothing = surface_info(Surface("F", [[np.nan] * 3], [[0, 0, 0]]))
    assert nothing.mean_dip is None and "no finite" in str(nothing) and nothing.components == 0


def test_every_kind_is_described(tmp_path: Path) -> None:
    folder_of(tmp_path, "")
    (tmp_path / "zmap").write_text(PLAIN)
    kinds = {
        "zmap": GridInfo,
        "top.irap": GridInfo,
        "top.gri": GridInfo,
        "f1.ts": SurfaceInfo,
        "p.csv": PointsInfo,
        "s.pol": SticksInfo,
    }
    for file, kind in kinds.items():
        info = describe(tmp_path / file)
        assert isinstance(info.parts[0], kind)
        assert str(info).startswith(f"{tmp_path / file}: {info.kind}")
    two = describe(tmp_path / "two.ts")
    assert [part.name for part in two.parts if isinstance(part, SurfaceInfo)] == ["F1", "F 2"]
    assert all(sign.startswith("depth, as stated") for sign in two.signs)
    assert "not stated" in str(describe(tmp_path / "unstated.ts"))
    sticks = describe(tmp_path / "s.pol").parts[0]
    assert isinstance(sticks, SticksInfo) and (sticks.sticks, sticks.points, sticks.least) == (2, 4, 2)
    with pytest.raises(InputError, match="model"):
        describe(tmp_path / "model.toml")


@pytest.mark.parametrize("suffix", ["obj", "ply", "stl", "vtp"])
def test_mesh_files_are_described(tmp_path: Path, suffix: str) -> None:
    info = describe(fault_files(tmp_path, F60)[suffix])
    (part,) = info.parts
    assert isinstance(part, SurfaceInfo) and info.kind is Kind[suffix.upper()]
    assert (part.vertices, part.triangles) == (len(F60.vertices), len(F60.triangles))
    assert part.mean_dip is not None and np.isclose(part.mean_dip, 60.0, atol=1e-3)
    assert info.signs[0].startswith("sign not stated")


@pytest.mark.skipif(not DATA.is_dir(), reason="shared data are not here")
def test_real_faults() -> None:
    (claudius,) = describe(DATA / "claudius" / "Fault.ts").parts
    assert isinstance(claudius, SurfaceInfo)
    assert claudius.mean_dip is not None and round(claudius.mean_dip) in (68, 69)
    assert min(p.mean_dip or 0 for p in describe(DATA / "hecho" / "AllFaultSurfaces.ts").parts) < 33  # type: ignore[union-attr]
