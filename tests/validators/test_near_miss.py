"""Gaps and stubs of known size, the right neighbour, and rims that run through."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from graben.demo import build
from graben.finding import Element
from graben.formats.tsurf import read_tsurf
from graben.proximity import nearest
from graben.reading import read_model
from graben.refinement import refined
from graben.settings import ContactRule, RepairSettings
from graben.surface import Surface, boundary_edges
from graben.validators.context import CheckContext, Evidence
from graben.validators.measuring.contacts import contacts
from graben.validators.measuring.hits import TriangleTree
from graben.validators.measuring.rim_labels import RimLabel
from graben.validators.measuring.rims import rim_stretches
from graben.validators.near_miss import CHECK
from tests.strategies import NASTY
from tests.zoo.near_miss import G, middle, splay
from tests.zoo.shapes import STEP, dipping, faults, level, sheet

DATA = Path(__file__).parents[2].parent / "shared" / "data"
LIMIT = 250.0


def found(model):
    model = model.moved(-model.local_origin())
    surfaces = [f.surface for f in model.faults]
    context = CheckContext(model, frozenset(s.name for s in model.surfaces))
    network = refined(surfaces)
    evidence = Evidence(network, contacts=contacts(surfaces, network, context.contact))
    return CHECK.run(replace(context, evidence=evidence))


def within(*surfaces: Surface, limit: float = LIMIT, **keys):
    return found(faults(*surfaces, checks={"near-miss": limit}, **keys))


def stretches(*surfaces: Surface, limit: float = LIMIT, contact: float = 1e-3, horizons=()):
    limits = (limit,) * len(surfaces)
    return rim_stretches(refined(surfaces), tuple(surfaces), limits, contact, tuple(horizons))


def named(surface: Surface, name: str) -> Surface:
    return Surface(name, surface.vertices, surface.triangles)


def rim_length(surface: Surface) -> float:
    a, b = np.moveaxis(surface.vertices[boundary_edges(surface.triangles)], 1, 0)
    return float(np.linalg.norm(b - a, axis=1).sum())


@pytest.mark.parametrize("angle", [90, 45, 30])
@pytest.mark.parametrize("dip", [85, 60, 40])
@pytest.mark.parametrize(("off", "kind"), [(30, "gap"), (200, "gap"), (-40, "stub"), (-200, "stub")])
def test_the_size_is_that_along_the_fault(angle, dip, off, kind):
    fault = splay(off, angle, dip)
    (defect,) = within(fault, G)
    assert defect.objects == ("F", "G")
    (part,) = defect.parts
    assert (part.kind, part.count, part.unit) == (kind, 1, "m")
    assert np.isclose(part.value, abs(off), rtol=0.01)
    assert np.isclose(defect.value, abs(off), rtol=0.01)
    (path,) = defect.paths
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert 0.85 * 8 * STEP <= length <= 1.5 * 8 * STEP
    assert defect.element is Element.TRIANGLE
    near = fault.triangles[defect.elements]
    assert set(range(9)) <= set(near.ravel().tolist())


def test_the_place_is_the_middle_of_the_rim():
    for off in (30, -40):
        origin = faults(splay(off), G).local_origin()
        (defect,) = within(splay(off), G)
        assert np.allclose(defect.place + origin, middle(splay(off)), atol=1e-6)


def test_a_gap_that_opens_is_told_from_least_to_greatest():
    fault = splay(30)
    away = np.sin(np.radians(70)) * fault.vertices[:, 1] + np.cos(np.radians(70)) * fault.vertices[:, 2]
    rows = np.arange(len(fault.vertices)) % 9
    tilted = fault.vertices + np.c_[0 * rows, 10.0 * rows, 0 * rows] * (away < 31)[:, None]
    (defect,) = within(fault.with_vertices(tilted), G)
    (part,) = defect.parts
    assert 30 <= part.value <= 40
    assert " short of G" in defect.message
    assert " to " in defect.message


@pytest.mark.parametrize("dip", [80, 60, 40])
@pytest.mark.parametrize("angle", [90, 60, 40])
def test_rims_run_through_a_crossing(dip, angle):
    for top in (0, 3, 60):
        through = splay(-820, angle, dip, columns=30, rows=8, top=top)
        assert within(through, G) == []


def test_a_rim_on_the_other_fault_is_no_gap():
    fault = splay(0)
    for surface, other in ((fault, G), (NASTY.surface(fault), NASTY.surface(G))):
        lines = [s for s in stretches(surface, other, contact=2e-3) if s.label is RimLabel.ON]
        assert {(s.fault, s.neighbour) for s in lines} == {("F", "G")}
        assert np.isclose(sum(s.length for s in lines), 8 * STEP, rtol=0.1)
        assert within(surface, other) == []


def test_the_neighbour_is_the_fault_met_first():
    behind = named(G.moved(np.array([0, -60.0, 0])), "behind")
    beside = named(splay(10).moved(np.array([40.0, 0, 0])), "beside")
    assert [d.objects for d in within(splay(30), G, behind)] == [("F", "G")]
    pairs = [d.objects for d in within(splay(30), G, behind, beside)]
    assert pairs == [("F", "G"), ("beside", "G")]


def test_ends_that_face_each_other_are_told_of_both():
    one = dipping(60, 8, 6)
    other = named(one.moved(np.array([8 * STEP + 40, 0, 0])), "G")
    defects = within(one, other)
    assert [d.objects for d in defects] == [("F", "G"), ("G", "F")]
    assert np.allclose([d.value for d in defects], 40)


@pytest.mark.parametrize("dip", [75, 60, 45, 25])
def test_faults_cut_off_at_one_depth_have_no_gap(dip):
    one = dipping(dip, 12, 8)
    y = one.vertices[:, 1]
    towards = Surface("G", one.vertices * [1, -1, 1] + [0, 2 * y.max() + 40, 0], one.triangles)
    along = named(one.moved(np.array([0, 40.0, 0])), "G")
    assert within(one, towards) == []
    assert within(one, along) == []


@pytest.mark.parametrize(("rule", "told"), [("accept", 0), ("forbid", 0), ("force", 1)])
def test_what_is_settled_is_not_told(rule, told):
    contacts = (ContactRule(faults=("G", "F"), rule=rule),)
    assert len(within(splay(30), G, contacts=contacts)) == told


def test_the_limit_is_max_extension_unless_the_check_has_its_own():
    assert found(faults(splay(100), G)) != []  # 2.5 median edges
    assert found(faults(splay(150), G)) == []
    assert within(splay(100), G, limit=90) == []
    assert within(splay(30), G, limit=0) == []


def test_the_stretches_are_the_whole_rim():
    for surfaces in ((splay(30), G), (splay(-40), G), (splay(0), G)):
        lines = stretches(*surfaces)
        for s in surfaces:
            assert np.isclose(sum(x.length for x in lines if x.fault == s.name), rim_length(s))
        for x in lines:
            assert np.isclose(np.linalg.norm(np.diff(x.path, axis=0), axis=1).sum(), x.length)
            assert (x.neighbour == "") == (x.label in (RimLabel.FREE, RimLabel.TIP))


def test_a_tip_is_where_a_horizon_passes():
    fault = dipping(60, 6, 4).moved(np.array([50.0, 50, 60]))
    top = level(size=10).surface
    (loop,) = stretches(fault)
    assert loop.label is RimLabel.FREE
    tips = [s for s in stretches(fault, horizons=[top]) if s.label is RimLabel.TIP]
    assert len(tips) == 2
    for tip in tips:
        height = tip.path[:, 2] - 0.1 * tip.path[:, 0]
        assert height.min() <= 0 <= height.max()


def test_the_findings_do_not_depend_on_the_frame():
    for off in (30, -40):
        pair = (splay(off, 45), G)
        moved = tuple(NASTY.surface(s) for s in pair)
        for a, b in zip(within(*pair), within(*moved), strict=True):
            assert a.objects == b.objects
            assert np.isclose(a.value, b.value, rtol=1e-6)


@pytest.mark.parametrize("name", ["single", "exit", "cross", "tee", "reverse", "low-dip"])
def test_demos_have_no_near_miss(name):
    demo = build(name, rotation=37.0, shift=(4e5, 6e6), shuffle=1)
    assert found(faults(*demo.faults, repair=RepairSettings(max_extension=LIMIT))) == []


@pytest.mark.parametrize(
    ("files", "limit", "pairs"),
    [
        # a corner of F2 ends 10 m short of F1; the horizons' step is 50 m
        ("drogon/faults/F*.pol", 125.0, [("F2", "F1")]),
        # a branch passes the fault on which it ends by a thousandth of its size; the step is 0.1
        ("hecho/AllFaultSurfaces.ts", 0.25, [("F2Surf", "F3Surf")]),
        ("claudius/Fault.ts", 125.0, []),
    ],
)
def test_real_faults(tmp_path, files, limit, pairs):
    paths = sorted(DATA.glob(files))
    if not paths:
        pytest.skip(f"no {DATA / files}")
    named = [f'[[faults]]\nname = "{p.stem}"' if p.suffix == ".pol" else "[[faults]]" for p in paths]
    tables = [f'{head}\nfile = "{p}"\n' for head, p in zip(named, paths, strict=True)]
    text = "\n".join(['[model]\nname = "M"\n', *tables, f"[repair]\nmax_extension = {limit}\n"])
    (tmp_path / "model.toml").write_text(text)
    defects = found(read_model(tmp_path / "model.toml"))
    assert [d.objects for d in defects] == pairs


def test_real_gaps_and_stubs_are_where_they_are_said_to_be():
    files = sorted((DATA / "cfm").glob("SAFS-MHFZ*.ts"))
    if not files:
        pytest.skip(f"no {DATA / 'cfm'}")
    surfaces = {s.name: s for s in (read_tsurf(file)[0].surface for file in files)}
    offset = np.mean([s.vertices.mean(axis=0) for s in surfaces.values()], axis=0)
    surfaces = {name: s.moved(-offset) for name, s in surfaces.items()}
    sized = [s for s in stretches(*surfaces.values(), limit=500.0) if s.label in ("gap", "stub")]
    assert {s.label for s in sized} == {"gap", "stub"}
    for s in sized:
        other = surfaces[s.neighbour]
        direct = nearest(s.place[None], other.vertices, other.triangles).distance[0]
        # along the fault it is never less than straight, but for places between two pieces
        assert 0 < s.least <= s.greatest <= 500
        assert direct <= 1.2 * s.size + 1


def test_ways_are_stopped_by_the_first_triangle():
    rng = np.random.default_rng(0)
    walls = [named(sheet(4, 4, lambda i, j, x=x: (x + 0 * i, i, j)), f"{x}") for x in (1.0, 2.0, 3.0)]
    tree = TriangleTree(walls)
    start = np.c_[np.zeros(50), rng.uniform(0.1, 3.9, (50, 2))]
    way = np.tile([4.0, 0, 0], (50, 1))
    hits = tree.first(start, way, 0)
    assert np.allclose(hits.distance, 0.5)
    assert (hits.owner == 1).all()
    assert (tree.first(start, -way, 0).owner == -1).all()
    assert (tree.first(start, way / 5, -1).owner == -1).all()
    along = tree.first(np.array([[1.0, -1, 1.3]]), np.array([[0, 9.0, 0]]), -1)
    assert along.owner.tolist() == [-1]
    assert tree.near(start, start + way, 1).sum(axis=0).tolist() == [50, 0, 50]
