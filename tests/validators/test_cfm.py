"""The 142 faults of the SCEC Community Fault Model in one model: the gate against independent counts."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from graben.finding import Profile, Status
from graben.formats.tsurf import read_tsurf
from graben.model import Fault, Model
from graben.stages import examined, quiet
from graben.surface import strong_components
from graben.validators.measuring.contacts import ContactKind
from graben.validators.simplicial_complex import WITHIN_CONTACT
from tests.validators.piercing import by_fault, crosses_properly, touching_pairs

DATA = Path(__file__).parents[2].parent / "shared" / "data" / "cfm"
CONFORMING = {ContactKind.EDGE, ContactKind.VERTEX}
#: Vertices of one lie on edges of the other to the last digit, and edges touch, but none passes through.
TOUCH = (
    "SAFS-SAFZ-MULT-Southern_San_Andreas_fault_and_Banning-CFM6",
    "SAFS-SAFZ-SBMT-Garnet_Hill_fault-CFM6",
)
#: Within the contact distance of 0.81 m, and not touching.
NEAR = {
    ("CRFA-CSBL-CSML-Casmalia_fault-CFM4", "CRFA-CSBL-PEZN-Pezzoni_Casmalia_fault-CFM5"),
    ("ETRA-CLGZ-SBMT-Tunnel_Ridge_Arrastre_Canyon_fault-CFM5", "ETRA-CLGZ-SCHS-Cleghorn_fault-CFM5"),
    ("MJVA-JVHZ-MULT-Johnson_Valley_fault-CFM5", "MJVA-JVHZ-SJVS-Kickapoo_fault-CFM3"),
}


@pytest.fixture(scope="module")
def cfm():
    """The gate's findings, and the pairs of faults by independent counts."""
    files = sorted(DATA.glob("*.ts"))
    if not files:
        pytest.skip(f"no files in {DATA}")
    surfaces = [t.surface for file in files for t in read_tsurf(file)]
    names = [s.name for s in surfaces]
    result, evidence, _ = examined(Model("cfm", (), tuple(map(Fault, surfaces))), Profile.EXTENDED, quiet)
    pairs, joined = touching_pairs(surfaces)

    def named(which):
        return {(names[a], names[b]) for a, b in by_fault(surfaces, which)}

    contacts = {}
    for contact in evidence.contacts:
        key = tuple(names[k] for k in contact.surfaces)
        contacts.setdefault(key, []).append(contact)
    return SimpleNamespace(
        surfaces=surfaces,
        result=result,
        contacts=contacts,
        proper=named(pairs[crosses_properly(surfaces, pairs)]),
        unjoined=named(pairs[~joined]),
        touching=named(pairs),
    )


def crossing_pairs(result, *kinds: str) -> set[tuple[str, ...]]:
    """The objects of the findings of simplicial-complex with a part of one of these kinds."""
    return {f.objects for f in result.of("simplicial-complex") if any(p.kind in kinds for p in f.parts)}


def test_the_counts_that_are_independent_of_the_gate(cfm):
    assert len(cfm.surfaces) == 142
    assert len(cfm.proper) == 132
    assert len(cfm.unjoined) == 133
    assert cfm.unjoined - cfm.proper == {TOUCH}
    assert len(cfm.touching) == 149


def test_the_gate_finds_every_crossing_pair_and_no_other(cfm):
    beyond = crossing_pairs(cfm.result, str(ContactKind.CROSSING))
    within = crossing_pairs(cfm.result, WITHIN_CONTACT)
    assert beyond | within == cfm.proper
    assert len(beyond) == 116


def test_what_crosses_within_the_contact_distance_alone_is_a_rim_on_the_other(cfm):
    beyond = crossing_pairs(cfm.result, str(ContactKind.CROSSING))
    alone = crossing_pairs(cfm.result, WITHIN_CONTACT) - beyond
    assert len(alone) == 16
    assert all(any(c.kind is ContactKind.T for c in cfm.contacts[pair]) for pair in alone)


def test_the_pair_that_only_the_refinement_counts_touches_in_a_rim(cfm):
    (found,) = cfm.contacts[TOUCH]
    assert found.kind is ContactKind.T
    assert found.passing == 0


def test_pairs_joined_in_edges_or_a_vertex_that_both_have_are_no_defect(cfm):
    conforming = {pair for pair, met in cfm.contacts.items() if {c.kind for c in met} <= CONFORMING}
    assert conforming == cfm.touching - cfm.unjoined
    assert len(conforming) == 16
    assert not conforming & {f.objects for f in cfm.result.of("simplicial-complex")}


def test_what_the_gate_adds_lies_within_the_contact_distance(cfm):
    assert set(cfm.contacts) - cfm.touching == NEAR


def test_a_pair_that_does_nothing_but_cross_warns_and_any_other_fails(cfm):
    for finding in cfm.result.of("simplicial-complex"):
        only = {p.kind for p in finding.parts} == {str(ContactKind.CROSSING)}
        assert finding.status is (Status.WARN if only else Status.FAIL)


def test_pairs_that_meet_in_several_pieces_have_one_finding_each(cfm):
    several = {pair for pair, met in cfm.contacts.items() if met[-1].piece > 0}
    found = {f.objects: f for f in cfm.result.of("pairwise-connected")}
    assert several < set(found)
    for pair in several:
        assert len(found[pair].parts) == cfm.contacts[pair][-1].piece + 1
    rest = set(found) - several
    assert all("in a single point" in found[pair].message for pair in rest)
    assert len(rest) == 2


def test_the_faults_of_several_components_and_the_one_that_crosses_itself(cfm):
    split = {s.name for s in cfm.surfaces if strong_components(s.triangles).max() > 0}
    found = {f.objects[0] for f in cfm.result.of("strongly-connected")}
    assert found <= split
    assert len(found) == 12
    # the thirteenth is a crack: two vertices stand twice at their places
    assert len(split) == 13
    assert [f.objects for f in cfm.result.of("self-intersection")] == [
        ("ETRA-BBFS-1992-Big_Bear_rupture-CFM6",)
    ]


def test_checks_that_need_a_horizon_say_so(cfm):
    for check in ("horizon", "trace", "junction", "junction-values", "acyclic", "anchored"):
        (finding,) = cfm.result.of(check)
        assert finding.status is Status.SKIPPED
        assert "horizon" in finding.message
