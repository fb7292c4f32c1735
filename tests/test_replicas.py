"""Replicas of the paper's models: the figures of its Table 2, a known answer, and files that hold both."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.linalg import block_diag

from graben.cli import app
from graben.demo import HORIZON
from graben.demo_by_name import build as build_demo
from graben.demo_by_name import names
from graben.demo_by_name import write as write_demo
from graben.errors import InputError
from graben.formats.irap import read_irap
from graben.modeling.results import HorizonResult, Score, TerminationType
from graben.modeling.scoring import score
from graben.modeling.truth import read_truth
from graben.pipeline import build
from graben.reading import read_model
from graben.refinement import refined
from graben.replica_list import REPLICAS, Replica
from graben.replica_models import Field, field
from graben.validators.measuring.contacts import ContactKind, contacts
from tests.bench.replicas import dips, errors, truths
from tests.modeling.test_scoring import EXACT, true_result

# The cheapest without and with faults that cross: (name, faults, intersections, step, least and mean dip).
CHEAPEST = (("fang", 4, 0, 200.0, 33.0, 44.0), ("ogx", 5, 1, 200.0, 38.0, 46.0))
CONTACT = 0.01  # distance at which faults touch, m
DIP_TO = 1.0  # what a corrugation may add to a dip, degrees
FAR = 1100.0  # where neither smear nor heave reaches, m across strike
SEEN_TO = 1e-5  # by what seismic may miss the truth there, m
BAR = 6.0  # percent of the largest throw: the bar of the synthetic models
ABOUT = 0.05  # share by which the field's score may miss its clusters', whose largest throws are their own
NAMES = [row[0] for row in CHEAPEST]


@cache
def made(name: str) -> Field:
    return field(REPLICAS[name], 0)


@pytest.mark.parametrize(("name", "faults", "intersections", "step", "least", "mean"), CHEAPEST)
def test_figures_are_those_of_table_2(
    name: str, faults: int, intersections: int, step: float, least: float, mean: float
) -> None:
    model = made(name).model()
    surfaces = [f.surface for f in model.faults]
    grid = model.horizons[0].grid
    found = contacts(surfaces, refined(surfaces), CONTACT)
    assert grid is not None
    assert (grid.dx, grid.dy) == (step, step)
    assert len(surfaces) == faults
    assert [c.kind for c in found] == [ContactKind.CROSSING] * intersections
    assert len({c.surfaces for c in found}) == intersections
    assert abs(float(dips(model).min()) - least) < DIP_TO
    assert abs(float(dips(model).mean()) - mean) < DIP_TO


@pytest.mark.parametrize("replica", REPLICAS.values(), ids=list(REPLICAS))
def test_cells_add_up_to_the_faults_and_intersections(replica: Replica) -> None:
    assert replica.intersections == sum(replica.crossed) + replica.crossings + replica.branchings
    assert 0 <= replica.alone <= replica.across * replica.rows
    assert all(extent % replica.step == 0 for extent in replica.size)


@pytest.mark.parametrize("name", NAMES)
def test_seismic_shows_the_truth_far_from_faults(name: str) -> None:
    for part in made(name).parts():
        nodes = part.grid.nodes()
        cluster = part.geology
        away = np.stack([cluster.distance(f, nodes) for f in range(len(cluster.faults))], axis=-1)
        far = (np.abs(away) > FAR).all(axis=-1)
        assert far.any()
        for signs in cluster.blocks:
            block = far & (np.sign(away) == signs).all(axis=-1)
            assert np.abs(cluster.horizon(signs, nodes[block]) - part.values[block]).max(initial=0) < SEEN_TO


@pytest.fixture(scope="module", params=NAMES)
def written(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """A replica's name, and the folder that the command wrote of it."""
    folder = tmp_path_factory.mktemp(request.param) / "model"
    done = CliRunner().invoke(app, ["demo", request.param, "-o", str(folder)])
    assert (done.exit_code, done.output) == (0, f"model: {folder / 'model.toml'}\n")
    return request.param, folder


def test_what_is_written_is_what_was_built(written: tuple[str, Path]) -> None:
    name, folder = written
    read, kept = read_model(folder / "model.toml"), made(name).model()
    assert read.name == kept.name == REPLICAS[name].name
    assert read.horizons[0].grid == kept.horizons[0].grid
    assert np.array_equal(read.horizons[0].surface.vertices, kept.horizons[0].surface.vertices)
    assert [(f.name, f.gamma) for f in read.faults] == [(f.name, f.gamma) for f in kept.faults]
    for one, other in zip(read.faults, kept.faults, strict=True):
        assert np.array_equal(one.surface.vertices, other.surface.vertices)


def test_truth_names_the_faults_of_one_cluster_on_the_grids_of_its_window(written: tuple[str, Path]) -> None:
    name, folder = written
    index = json.loads((folder / "truth" / "truth.json").read_text())
    blocks = index["horizons"][HORIZON]["blocks"]
    clusters = [{f.name for f in c.faults} for c in made(name).clusters]
    told = [set(block["sides"]) for block in blocks]
    assert all(told.count(c) == len(g.blocks) for c, g in zip(clusters, made(name).clusters, strict=True))
    assert set(index["faults"]) == set.union(*clusters)
    whole = made(name).grid
    for block, faults in zip(blocks, told, strict=True):
        grids = {read_irap(folder / "truth" / index["faults"][f])[0] for f in faults}
        (grid,) = grids | {read_irap(folder / "truth" / block["file"])[0]}
        assert grid.step == 0.5 * whole.step
        assert grid.rows * grid.dy < whole.rows * whole.dy


def test_a_run_scores_the_whole_field_as_its_clusters(written: tuple[str, Path], tmp_path: Path) -> None:
    name, folder = written
    run = build(read_model(folder / "model.toml"), mend=False)
    result = run.horizons[0]
    assert run.after.passed
    assert len(result.subdomains) == 1 + len(REPLICAS[name].crossed)
    assert {s.termination.type for s in result.subdomains} == {TerminationType.CONVERGED}
    assert result.score is not None
    assert result.score.cutoff.percent < BAR
    known = truths(made(name), tmp_path)
    cutoff, throw = errors(result, known)
    assert result.score.cutoff.value == pytest.approx(cutoff, rel=ABOUT)
    assert result.score.throw.value == pytest.approx(throw, rel=ABOUT)
    largest = max(t.largest for t in known)
    assert result.score.cutoff.percent == pytest.approx(100.0 * result.score.cutoff.value / largest)


@cache
def true_field(name: str) -> HorizonResult:
    """Return a result that holds the truth of each cluster in its window."""
    parts = [true_result(part) for part in made(name).parts()]
    first = np.concatenate([r.first for r in parts])
    return replace(
        parts[0],
        surface=parts[0].surface.with_vertices(np.concatenate([r.surface.vertices for r in parts])),
        first=first,
        subdomain=np.zeros(len(first)),
        fixed=np.concatenate([r.fixed for r in parts]),
        side=np.zeros(len(first)),
        block=block_diag(*(r.block for r in parts)),
        graph_faults=tuple(f for r in parts for f in r.graph_faults),
        smears=np.concatenate([r.smears for r in parts]),
        cutoffs=tuple(c for r in parts for c in r.cutoffs),
    )


@cache
def true_score(name: str, truth: Path) -> Score:
    found = score(truth, true_field(name), made(name).faults)
    assert found is not None
    return found


def test_the_truth_of_all_clusters_scores_nothing(written: tuple[str, Path]) -> None:
    name, folder = written
    truth, faults = folder / "truth", made(name).faults
    whole, exact = true_field(name), true_score(name, truth)
    assert max(exact.cutoff.value, exact.throw.value, exact.zone.value) < EXACT
    assert exact.zone_input.value > 4.0
    up = whole.surface.vertices + np.array([0.0, 0.0, 2.5])
    lifted = score(truth, replace(whole, surface=whole.surface.with_vertices(up)), faults)
    assert lifted is not None
    assert lifted.zone.value == pytest.approx(2.5, abs=EXACT)


def test_faults_of_other_clusters_may_be_told_as_0(written: tuple[str, Path], tmp_path: Path) -> None:
    name, folder = written
    copy = shutil.copytree(folder / "truth", tmp_path / "truth")
    index = json.loads((copy / "truth.json").read_text())
    for block in index["horizons"][HORIZON]["blocks"]:
        block["sides"] = dict.fromkeys(index["faults"], 0) | block["sides"]
    (copy / "truth.json").write_text(json.dumps(index))
    plain, full = (read_truth(path, HORIZON).clusters for path in (folder / "truth", copy))
    assert len(plain) == len(made(name).clusters)
    for one, other in zip(plain, full, strict=True):
        assert np.array_equal(one.faults, other.faults) and np.array_equal(one.blocks, other.blocks)


def test_nodes_beyond_the_windows_are_left_out(written: tuple[str, Path]) -> None:
    name, folder = written
    truth, faults = folder / "truth", made(name).faults
    whole = true_field(name)
    far = np.flatnonzero(whole.fixed)[0]
    points, fixed = whole.surface.vertices.copy(), whole.fixed.copy()
    points[far], fixed[far] = (-1e5, -1e5, 1e5), False
    more = replace(whole, surface=whole.surface.with_vertices(points), fixed=fixed)
    other = score(truth, more, faults)
    assert other is not None
    assert other.zone == true_score(name, truth).zone


def test_seeds_place_the_faults_and_noise_has_its_standard_deviation() -> None:
    plain, noisy = made("fang"), field(REPLICAS["fang"], 0, 2.0)
    off = noisy.values - plain.values
    assert abs(off.std() - 2.0) < 0.1 and abs(off.mean()) < 0.1
    assert noisy.clusters[0].faults[0].centre == plain.clusters[0].faults[0].centre
    assert field(REPLICAS["fang"], 1).clusters[0].faults[0].centre != plain.clusters[0].faults[0].centre


def test_noise_is_told_and_the_same_replica_gives_the_same_bytes(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        write_demo(build_demo("fang", noise=2.0, seed=3), tmp_path / folder)
    files = sorted(p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file())
    assert files
    assert all((tmp_path / "a" / f).read_bytes() == (tmp_path / "b" / f).read_bytes() for f in files)
    assert read_model(tmp_path / "a" / "model.toml").horizons[0].noise == 2.0


def test_the_list_names_the_replicas_with_their_figures() -> None:
    said = CliRunner().invoke(app, ["demo", "--list"]).output
    assert [line.split()[0] for line in said.splitlines()] == list(names())
    for name, replica in REPLICAS.items():
        assert f"replica of {replica.name}: {replica.faults} faults" in names()[name]
    assert set(REPLICAS) == {"fang", "bohai", "krsloboda", "ashtart", "chicontepec", "chesapeake", "ogx"}


def test_another_step_noise_below_zero_and_unknown_names_are_refused() -> None:
    with pytest.raises(InputError, match="replica fang has the step of the paper, 200 m"):
        build_demo("fang", step=100.0)
    with pytest.raises(InputError, match="Noise of -1 m from seed 0 cannot be made"):
        build_demo("fang", noise=-1.0)
    with pytest.raises(InputError, match=r"no demo 'double'; choose one of single, .*, ogx\."):
        build_demo("double")
