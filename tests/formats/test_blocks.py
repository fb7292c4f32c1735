"""Blocks written: files that read back to the same closed surfaces, and a table that adds up."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
import pyvista

from graben.cleaning.blocks import fault_blocks
from graben.formats.blocks import COLUMNS, block_files, write_blocks
from graben.formats.tsurf import read_tsurf
from graben.prism import volume
from graben.surface import Surface

SQUARE = np.array([[0.0, 0], [3, 0], [3, 2], [0, 2]])


@pytest.fixture
def blocks():
    made = []
    for name, x in (("F/1", 1.0), ("F 2", 1.5)):
        corners = [[x, -1, -2], [x, 3, -2], [x, 3, 2], [x, -1, 2]]
        made.append(Surface(name, corners, [[0, 1, 2], [0, 2, 3]]))
    return fault_blocks(made, 1.0, 0.0, SQUARE)


@pytest.mark.parametrize("z", ["elevation", "depth"])
def test_surfaces_read_back_to_the_bit_and_the_table_adds_up(blocks, tmp_path, z):
    table = pd.read_csv(write_blocks(blocks, tmp_path / "out", z=z), keep_default_na=False)
    assert tuple(table.columns) == COLUMNS
    assert table["volume"].tolist() == [b.volume for b in blocks] == [3.0, 2.0, 1.0]
    assert table["share"].sum() == pytest.approx(1.0)
    assert table["faults"].tolist() == ["F 2", "F/1", "F/1; F 2"]
    assert table["neighbours"].tolist() == ["block 3", "block 3", "block 1; block 2"]
    assert table["file"].tolist() == block_files(blocks) == ["block_1.ts", "block_2.ts", "block_3.ts"]
    for block, file in zip(blocks, table["file"], strict=True):
        (read,) = read_tsurf(tmp_path / "out" / file)
        assert read.z == z
        assert np.array_equal(read.surface.vertices, block.surface.vertices)
        assert volume(read.surface) == block.volume


@pytest.mark.parametrize("z", ["elevation", "depth"])
def test_vtk_files_are_closed_and_turned_outward(blocks, tmp_path, z):
    write_blocks(blocks, tmp_path, kind="vtp", z=z)
    for block in blocks:
        mesh = pyvista.read(tmp_path / f"{block.name.replace(' ', '_')}.vtp")
        assert mesh.n_open_edges == 0
        read = Surface("read", mesh.points, mesh.regular_faces)
        assert volume(read) == pytest.approx(block.volume)
