"""Replicas of the paper's models: have they the figures of its Table 2, and is their answer known?"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from graben.modeling.results import TerminationType
from graben.pipeline import build
from graben.refinement import refined
from graben.validators.measuring.contacts import ContactKind, contacts
from tests.bench.replica_list import REPLICAS, Replica
from tests.bench.replica_models import Field, field
from tests.bench.replicas import dips, errors, truths

# The cheapest without and with faults that cross: (name, faults, intersections, step, least and mean dip).
CHEAPEST = (("Fang", 4, 0, 200.0, 33.0, 44.0), ("OGX", 5, 1, 200.0, 38.0, 46.0))
CONTACT = 0.01  # distance at which faults touch, m
DIP_TO = 1.0  # what a corrugation may add to a dip, degrees
FAR = 1100.0  # where neither smear nor heave reaches, m across strike
SEEN_TO = 1e-5  # by what seismic may miss the truth there, m
BAR = 6.0  # percent of the largest throw: the bar of the synthetic models


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


@pytest.mark.parametrize("name", [row[0] for row in CHEAPEST])
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


@pytest.mark.parametrize("name", [row[0] for row in CHEAPEST])
def test_all_subdomains_converge_near_the_truth(name: str, tmp_path: Path) -> None:
    model = made(name).model()
    known = truths(made(name), tmp_path)
    run = build(model, mend=False)
    result = run.horizons[0]
    assert run.after.passed
    assert len(result.subdomains) == 1 + len(REPLICAS[name].crossed)
    assert {s.termination.type for s in result.subdomains} == {TerminationType.CONVERGED}
    cutoff, _ = errors(result, known)
    assert 100.0 * cutoff / max(t.largest for t in known) < BAR
