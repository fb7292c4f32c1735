"""Closed fault blocks: known volumes, volumes that add up, what parts and what does not."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

from graben import demo
from graben.cleaning.blocks import ADD_UP, fault_blocks, shared_depths
from graben.errors import ModelingError
from graben.model import Fault, Model
from graben.prism import bounds_solid, volume
from graben.surface import Surface, boundary_edges
from tests.models import grid_triangles, model_of_demo
from tests.zoo.networks import conforming, pipe, plane
from tests.zoo.shapes import STEP

SQUARE = np.array([[-2.0, -2], [2, -2], [2, 2], [-2, 2]])
FRAMES = [(0.0, (0.0, 0.0, 0.0)), (0.7, (500_000.0, -300_000.0, -2000.0))]


def moved(points, angle, shift):
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])[: points.shape[1], : points.shape[1]]
    return points @ turn + np.array(shift)[: points.shape[1]]


def sheet(name, normal, away, rng=None, half=6.0, parts=(9, 8), right=None):
    """A plane through ``away`` times its normal, its nodes shaken in the plane; ``right``: where it ends."""
    along = np.cross(normal, [0.0, 0.0, 1.0])
    along /= np.linalg.norm(along)
    s, t = np.meshgrid(
        np.linspace(-half, half if right is None else right, parts[0]),
        np.linspace(-half, half, parts[1]),
        indexing="ij",
    )
    if rng is not None:
        s, t = s + rng.uniform(-0.2, 0.2, s.shape), t + rng.uniform(-0.2, 0.2, s.shape)
    points = normal * away + s[..., None] * along + t[..., None] * np.cross(normal, along)
    return Surface(name, points.reshape(-1, 3), grid_triangles(*parts))


def tilted(rng):
    azimuth, dip = rng.uniform(0.0, 2.0 * np.pi), np.radians(rng.uniform(35.0, 88.0))
    return np.array([np.cos(azimuth) * np.sin(dip), np.sin(azimuth) * np.sin(dip), np.cos(dip)])


def convex_volumes(planes):
    """Volumes of the parts of the box |x|, |y| < 2, |z| < 1 between planes (normal, away), largest first."""
    box = np.concatenate([np.eye(3), -np.eye(3)])
    found = []
    for signs in product((1.0, -1.0), repeat=len(planes)):
        rows = np.concatenate([box, *(s * n[None] for s, (n, _) in zip(signs, planes, strict=True))])
        ends = np.array([2, 2, 1, 2, 2, 1, *(s * d for s, (_, d) in zip(signs, planes, strict=True))])
        norms = np.linalg.norm(rows, axis=1)
        inner = linprog([0, 0, 0, -1], np.c_[rows, norms], ends, bounds=[(None, None)] * 3 + [(0, None)])
        if inner.status == 0 and inner.x[3] > 1e-7:
            corners = HalfspaceIntersection(np.c_[rows, -ends], inner.x[:3]).intersections
            found.append(ConvexHull(corners).volume)
    return np.sort(found)[::-1]


def check(blocks, whole):
    """What holds for all blocks."""
    assert sum(b.volume for b in blocks) == pytest.approx(whole, rel=ADD_UP)
    assert [b.name for b in blocks] == [f"block {k}" for k in range(1, len(blocks) + 1)]
    by_name = {b.name: b for b in blocks}
    for block in blocks:
        assert bounds_solid(block.surface)
        assert block.volume == volume(block.surface) > 0.0
        assert len(boundary_edges(block.surface.triangles)) == 0
        assert len(block.origin) == len(block.surface.triangles)
        assert set(block.origin) == {-1, *range(len(block.faults))}
        assert all(block.name in by_name[other].neighbours for other in block.neighbours)


def test_one_plane_at_a_known_place():
    blocks = fault_blocks([sheet("F", np.array([1.0, 0, 0]), 1.0)], 1.0, -1.0, SQUARE)
    check(blocks, 32.0)
    assert [b.volume for b in blocks] == pytest.approx([24.0, 8.0], rel=1e-12)
    assert [b.faults for b in blocks] == [("F",), ("F",)]
    assert [b.neighbours for b in blocks] == [("block 2",), ("block 1",)]
    large = blocks[0].surface
    assert large.vertices[:, 0].max() == 1.0
    on_fault = large.vertices[large.triangles[blocks[0].origin == 0]]
    assert (on_fault[..., 0] == 1.0).all()


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize(("angle", "shift"), FRAMES)
def test_planes_that_cross_part_a_box_as_half_spaces_do(seed, angle, shift):
    rng = np.random.default_rng(seed)
    planes = [(tilted(rng), rng.uniform(-1.5, 1.5)) for _ in range(1 + seed % 5)]
    faults = [sheet(f"F{k}", n, d, rng) for k, (n, d) in enumerate(planes)]
    placed = [replace(f, vertices=moved(f.vertices, angle, shift)) for f in faults]
    blocks = fault_blocks(placed, 1.0 + shift[2], -1.0 + shift[2], moved(SQUARE, angle, shift))
    check(blocks, 32.0)
    assert [b.volume for b in blocks] == pytest.approx(convex_volumes(planes), abs=1e-8)


@pytest.mark.parametrize("seed", range(6))
def test_splays_that_end_on_a_main_part_one_side_of_it(seed):
    rng = np.random.default_rng(seed)
    azimuth = rng.uniform(0.0, 2.0 * np.pi)
    along = np.array([np.cos(azimuth), np.sin(azimuth)])
    across = np.array([-along[1], along[0]])
    line = (-14 * along, 14 * along, rng.uniform(60.0, 85.0))
    main = plane(*line[:2], "M", dip=line[2], parts=(12, 6))
    splays = [
        plane(k * along + 12 * across, k * along - 6 * across, f"S{k}", dip=rng.uniform(70, 88), parts=(7, 5))
        for k in (-3, 3)
    ]
    model = conforming(main, *splays, ends_on={s.name: line for s in splays})
    corners = 3.0 * STEP * SQUARE
    volumes = []
    for angle, shift in FRAMES:
        faults = [replace(f, vertices=moved(f.vertices, angle, shift)) for f in model]
        top, bottom = 1.5 * STEP + shift[2], -1.5 * STEP + shift[2]
        blocks = fault_blocks(faults, top, bottom, moved(corners, angle, shift))
        check(blocks, 144.0 * 3.0 * STEP**3)
        assert sorted(b.faults for b in blocks) == [("M",), ("M", "S-3"), ("M", "S-3", "S3"), ("M", "S3")]
        volumes.append([b.volume for b in blocks])
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-9)


def network(seed):
    """A main, up to three splays and, for every third seed, a fault across all, exactly: hence slivers."""
    rng = np.random.default_rng(seed)
    azimuth = rng.uniform(0.0, 2.0 * np.pi)
    along = np.array([np.cos(azimuth), np.sin(azimuth)])
    across = np.array([-along[1], along[0]])
    main_dip = rng.uniform(45.0, 85.0, 2)[0]
    middle = rng.uniform(-1.0, 1.0, 2)
    line = (middle - 14 * along, middle + 14 * along, main_dip)
    splays = []
    for k in range(rng.integers(1, 4)):
        foot = middle + (4 * k - 4) * along
        dip = rng.uniform(50, 88)
        splays.append(plane(foot + 12.6 * across, foot - 6 * across, f"S{k}", dip=dip, parts=(7, 5)))
    main = plane(*line[:2], "M", dip=main_dip, parts=(12, 6))
    foot = middle + 2.3 * along
    crossing = plane(foot - 12 * across, foot + 12 * across, "X", dip=70, parts=(9, 5))
    faults = [main, *splays, *([crossing] if seed % 3 == 0 else [])]
    return conforming(*faults, ends_on={s.name: line for s in splays if s.name != "S2"})


@pytest.mark.parametrize("seed", [9, 15, 63, 85, 121])
def test_slivers_of_exact_intersections_neither_open_nor_join_blocks(seed):
    volumes = []
    for angle, shift in FRAMES:
        faults = [replace(f, vertices=moved(f.vertices, angle, shift)) for f in network(seed)]
        top, bottom = 1.5 * STEP + shift[2], -1.5 * STEP + shift[2]
        blocks = fault_blocks(faults, top, bottom, moved(3.0 * STEP * SQUARE, angle, shift))
        check(blocks, 144.0 * 3.0 * STEP**3)
        volumes.append([b.volume for b in blocks])
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-8)


def test_a_flat_triangle_that_leaves_the_prism_does_not_open_the_fault():
    corners = [[0, -6, -6], [0, 6, -6], [0, 6, 0.3], [0, -6, 0.3], [0, -1, 0.3], [0, 6, 6], [0, -6, 6]]
    triangles = [[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 6], [4, 2, 5], [4, 5, 6]]
    blocks = fault_blocks([Surface("F", corners, triangles)], 1.0, -1.0, SQUARE)
    check(blocks, 32.0)
    assert [b.volume for b in blocks] == pytest.approx([16.0, 16.0])


def test_a_fault_that_ends_inside_parts_nothing():
    (whole,) = fault_blocks([sheet("F", np.array([1.0, 0, 0]), 0.0, right=1.0)], 1.0, -1.0, SQUARE)
    assert whole.volume == pytest.approx(32.0)
    assert whole.faults == whole.neighbours == ()


def test_a_fault_that_hangs_free_parts_nothing():
    (whole,) = fault_blocks([sheet("F", np.array([0.8, 0, 0.6]), 0.0, half=0.5)], 1.0, -1.0, SQUARE)
    assert whole.volume == pytest.approx(32.0)


SPLAY = Surface("S", [[0, 0, -6], [6, 0, -6], [6, 0, 6], [0, 0, 6]], [[0, 1, 2], [0, 2, 3]])


def test_what_ends_on_a_loose_end_is_one_too():
    main = sheet("M", np.array([1.0, 0, 0]), 0.0, half=1.5)
    (whole,) = fault_blocks([main, SPLAY], 1.0, -1.0, SQUARE)
    assert whole.faults == ()


def test_a_splay_parts_with_the_half_of_a_main_that_leaves():
    main = sheet("M", np.array([1.0, 0, 0]), 0.0, right=1.0)  # ends one unit south of the splay
    blocks = fault_blocks([main, SPLAY], 1.0, -1.0, SQUARE)
    check(blocks, 32.0)
    assert [b.volume for b in blocks] == pytest.approx([24.0, 8.0])
    assert [b.faults for b in blocks] == [("M", "S")] * 2


def test_a_closed_pipe_has_an_inside():
    blocks = fault_blocks([pipe(3.0)], STEP, -STEP, 3 * STEP * SQUARE)
    check(blocks, 144.0 * 2.0 * STEP**3)
    assert [b.faults for b in blocks] == [("F",), ("F",)]


def test_no_fault_gives_the_prism():
    (whole,) = fault_blocks([], 2.0, 1.0, SQUARE)
    assert whole.volume == pytest.approx(16.0)


def test_a_fault_on_the_wall_of_the_prism_parts_nothing():
    (whole,) = fault_blocks([sheet("F", np.array([1.0, 0, 0]), 2.0)], 1.0, -1.0, SQUARE)
    assert whole.volume == pytest.approx(32.0)


def test_order_and_orientation_of_triangles_do_not_matter():
    rng = np.random.default_rng(4)
    faults = [sheet(f"F{k}", tilted(rng), d, rng) for k, d in enumerate((0.2, -0.6))]
    before = fault_blocks(faults, 1.0, -1.0, SQUARE)
    mixed = []
    for fault in faults:
        rows = fault.triangles[rng.permutation(len(fault.triangles))].copy()
        rows[::3] = rows[::3, ::-1]
        mixed.append(replace(fault, triangles=rows))
    after = fault_blocks(mixed, 1.0, -1.0, SQUARE[::-1])
    assert [b.volume for b in before] == pytest.approx([b.volume for b in after], rel=1e-12)
    assert [b.faults for b in before] == [b.faults for b in after]


@pytest.mark.parametrize("frame", [{}, {"rotation": 33.0, "shift": (450_000.0, 6_100_000.0)}])
def test_the_domain_of_a_model_is_that_of_its_horizon(frame):
    model = model_of_demo(demo.build("exit-both", **frame))
    blocks = fault_blocks(model)
    levels = np.concatenate([s.vertices[:, 2] for s in model.surfaces])
    check(blocks, 8800.0 * 8000.0 * np.ptp(levels))
    assert [b.faults for b in blocks] == [("F1",), ("F1",)]
    rim = model.horizons[0].surface
    nodes = rim.vertices[np.unique(boundary_edges(rim.triangles)), :2]
    made = np.concatenate([b.surface.vertices[:, :2] for b in blocks])
    assert {row.tobytes() for row in nodes} <= {row.tobytes() for row in made}


@pytest.mark.parametrize(
    ("name", "centre", "half", "faults"),
    [
        ("cross", (4500.0, 4050.0), 700.0, [("F1", "F2")] * 4),
        ("tee", (2600.0, 3800.0), 900.0, [("F1",), ("F1", "F2"), ("F1", "F2")]),
    ],
)
@pytest.mark.parametrize("frame", [{}, {"rotation": 33.0, "shift": (450_000.0, 6_100_000.0), "shuffle": 3}])
def test_demo_models_within_their_tips(name, centre, half, faults, frame):
    made = demo.build(name, **frame)
    outline = made.frame.outward(np.array(centre) + 0.5 * half * SQUARE)
    blocks = fault_blocks(model_of_demo(made), -1250.0, -1750.0, outline)
    check(blocks, (2.0 * half) ** 2 * 500.0)
    assert [b.faults for b in blocks] == faults


def test_the_box_about_faults_can_be_narrowed():
    fault = Surface("F", [[0, 0, 0], [4, 0, 0], [4, 1, 4], [0, 1, 4]], [[0, 1, 2], [0, 2, 3]])
    other = Surface("G", [[2, -3, 0], [2, 3, 0], [2, 3, 4], [2, -3, 4]], [[0, 1, 2], [0, 2, 3]])
    assert len(fault_blocks([fault, other], margin=1.0)) == 1
    narrow = fault_blocks([fault, other], margin=-1.0)
    check(narrow, 2.0 * 4.0 * 4.0)
    assert len(narrow) == 4


def test_the_depths_that_faults_share():
    high = sheet("F", np.array([1.0, 0, 0]), 1.0)
    low = replace(high.moved(np.array([-2.0, 0.0, -5.0])), name="G")
    model = Model("m", faults=(Fault(high), Fault(low)))
    assert shared_depths(model) == (1.0, -6.0)
    assert len(fault_blocks(model, outline=SQUARE)) == 1
    assert len(fault_blocks(model, *shared_depths(model), SQUARE)) == 3


@pytest.mark.parametrize(
    ("surfaces", "given", "said"),
    [
        ([], {}, "give top and bottom"),
        ([], {"top": 1.0, "bottom": 0.0}, "give an outline"),
        ([], {"top": 0.0, "bottom": 1.0}, "must lie above their bottom"),
        ([], {"top": 1.0, "bottom": 0.0, "outline": SQUARE[[0, 2, 1, 3]]}, "does not cross itself"),
        ([], {"top": 1.0, "bottom": 0.0, "outline": SQUARE[:2]}, "three corners or more"),
        (
            [Surface("F", [[0, 0, np.nan]] * 3, [[0, 1, 2]])],
            {"outline": SQUARE},
            "F has undefined coordinates",
        ),
    ],
)
def test_misuse_is_told_in_a_sentence(surfaces, given, said):
    with pytest.raises(ModelingError, match=said):
        fault_blocks(surfaces, **given)


def test_a_fault_that_crosses_itself_is_named():
    one, two = (sheet("F", n, 0.0) for n in (np.array([1.0, 0, 0]), np.array([0.6, 0.8, 0])))
    both = Surface(
        "F",
        np.concatenate([one.vertices, two.moved(np.array([0.01, 0.02, 0.03])).vertices]),
        np.concatenate([one.triangles, two.triangles + len(one.vertices)]),
    )
    with pytest.raises(ModelingError, match="F crosses itself"):
        fault_blocks([both], 1.0, -1.0, SQUARE)


def test_a_fault_that_closes_in_itself_inside_is_told_of():
    corners = [[0, 0, 0.5], [1, 0, 0], [0, 1, 0], [-1, -1, 0]]
    closed = Surface("F", corners, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [2, 1, 3]])
    with pytest.raises(ModelingError, match="The blocks of F are not closed"):
        fault_blocks([closed], 1.0, -1.0, SQUARE)
