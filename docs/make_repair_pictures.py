"""Draw a fault before and after repair: `python docs/make_repair_pictures.py`.

The branch fault of the demo model `tee`, in smaller triangles, is damaged as in the tests: it stops short of
the main fault, has a hole, and a patch of it is overturned. The picture is the one that the report shows.
"""

from __future__ import annotations

import base64
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import graben  # noqa: E402
from graben import demo  # noqa: E402
from graben.model import Model  # noqa: E402
from graben.reports.repair_figures import fault_picture  # noqa: E402
from graben.reports.repair_moves import fault_changes  # noqa: E402
from graben.reports.style import Frame  # noqa: E402
from graben.surface import Surface, edge_table  # noqa: E402
from tests.cleaning import corrupt_meshes, corrupt_networks, corrupt_shapes  # noqa: E402
from tests.cleaning.corrupt_sheets import Corrupted, Done, sheet_of  # noqa: E402

TARGET = Path(__file__).parent / "images" / "repair-tee.png"
#: What it shows, by the name of its file.
PICTURES = {
    "repair-tee": "A fault of the demo model tee with a gap, a hole and a fold: as it was, and repaired."
}
#: The fault, how often its triangles are parted in four, and the seed of the damage.
FAULT, PARTED, SEED = "F2", 2, 2
#: Bytes of the picture: too few for a drawing.
MOST = 149_000


def main() -> int:
    """Write the picture."""
    result = graben.repair(damaged(SEED), "paper")
    change = next(c for c in fault_changes(result) if c.name == FAULT)
    places = [
        (number, np.array(action.place))
        for number, action in enumerate(result.actions, start=1)
        if FAULT in action.objects and action.place is not None
    ]
    others = [f.surface for f in result.model.faults if f.name != FAULT]
    made = fault_picture(change, (), others, places, Frame.of(result.model), MOST)
    assert made is not None
    assert result.passed
    TARGET.write_bytes(base64.b64decode(made.source.partition(",")[2]))
    print(result)
    print(f"{TARGET.name}: {made.caption}")
    return 0


def damaged(seed: int) -> Model:
    """Return the model with the damaged fault."""
    with tempfile.TemporaryDirectory() as folder:
        demo.write(demo.build("tee"), Path(folder))
        clean = graben.read_model(Path(folder) / "model.toml")
    clean = replace(clean, truth=None)
    rng = np.random.default_rng(seed)
    state = corrupt_networks.gaps(Corrupted(clean, clean), rng)
    finer = in_four(state.surface(FAULT), PARTED)
    state = state.with_surfaces([finer], Done("finer", (FAULT,), finer.vertices[:0], "smaller triangles"))
    for damage in (corrupt_meshes.holes, corrupt_shapes.overturned):
        made = damage(state, sheet_of(state, FAULT), rng)
        assert made is not None
        surface, at, what = made
        state = state.with_surfaces([surface], Done(damage.__name__, (FAULT,), at, what))
    return state.model


def in_four(surface: Surface, times: int) -> Surface:
    """Return a surface with each triangle parted in four at the middles of its edges, so many times."""
    for _ in range(times):
        edges, sides = edge_table(surface.triangles)
        middle = len(surface.vertices) + sides.reshape(-1, 3)
        (a, b, c), (bc, ca, ab) = surface.triangles.T, middle.T
        triangles = np.concatenate(
            [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        )
        vertices = np.concatenate([surface.vertices, surface.vertices[edges].mean(axis=1)])
        surface = Surface(surface.name, vertices, triangles)
    return surface


if __name__ == "__main__":
    sys.exit(main())
