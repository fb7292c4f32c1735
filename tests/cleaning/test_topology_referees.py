"""Repaired surfaces and fault blocks, looked at by other libraries: PyMeshLab and trimesh."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest
import trimesh

from graben.cleaning.blocks import fault_blocks
from tests.cleaning.clean_networks import clean_network
from tests.cleaning.corruption import Case, mended

CASES = (
    Case("tee", ("fins", "holes"), 1),
    Case("cross", ("non-conforming",), 1),
    Case("splays", ("unwelded", "slivers"), 1),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_pymeshlab_finds_one_manifold_sheet_with_one_rim(case: Case) -> None:
    for fault in mended(case)[1].model.faults:
        measures = topology(fault.surface)
        assert measures["non_two_manifold_edges"] == 0
        assert measures["non_two_manifold_vertices"] == 0
        assert measures["connected_components_number"] == 1
        assert measures["number_holes"] == 1  # its rim


def test_pymeshlab_sees_what_was_done_to_them() -> None:
    built = Case("tee", ("fins", "holes"), 1).built()
    seen = [topology(fault.surface) for fault in built.model.faults]
    assert any(m["non_two_manifold_edges"] > 0 for m in seen)


def test_trimesh_finds_blocks_watertight_and_of_the_same_volume() -> None:
    blocks = fault_blocks(clean_network("leaving"), 300.0, -300.0)
    for block in blocks:
        mesh = trimesh.Trimesh(block.surface.vertices, block.surface.triangles, process=False)
        assert mesh.is_watertight
        assert mesh.is_winding_consistent
        assert mesh.volume == pytest.approx(block.volume, rel=1e-9)


def topology(surface) -> dict[str, int]:
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.array(surface.vertices), np.array(surface.triangles, dtype=np.int32)))
    return meshes.get_topological_measures()
