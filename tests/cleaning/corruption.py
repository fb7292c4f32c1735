"""Corruptions of clean networks by kind, reproducible cases of them, and the judge of what a repair made.

A kind is a function of what was corrupted so far and a random generator. Pairs of kinds are applied in the
order of the list, in which corruptions of how faults meet come first, those of the mesh last: the first need
branch lines that are still shared, the last leave surfaces on which nothing else can be built.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from types import MappingProxyType

import numpy as np

from graben.arrays import floats, ints
from graben.cleaning.ledger import RepairAction, measured
from graben.cleaning.shaping.limits import ROUNDING, distances
from graben.finding import CheckResult, Profile, Status
from graben.model import Model
from graben.pipeline import check
from graben.repairs import RepairResult, repair
from graben.surface import Surface
from tests.cleaning import corrupt_meshes, corrupt_networks, corrupt_shapes
from tests.cleaning.clean_networks import clean_network
from tests.cleaning.corrupt_sheets import CannotCorruptError, Corrupted, on_one_fault
from tests.cleaning.network_list import NETWORKS

#: The kinds in the order in which pairs of them are applied.
KINDS: Mapping[str, Callable[[Corrupted, np.random.Generator], Corrupted]] = MappingProxyType(
    {
        "gaps": corrupt_networks.gaps,
        "stubs": corrupt_networks.stubs,
        "tangency": corrupt_networks.tangent,
        "non-conforming": corrupt_networks.strayed,
        "bumps": on_one_fault("bumps", corrupt_shapes.bumps),
        "overturned": on_one_fault("overturned", corrupt_shapes.overturned),
        "parted": on_one_fault("parted", corrupt_shapes.parted),
        "holes": on_one_fault("holes", corrupt_meshes.holes),
        "self-intersection": on_one_fault("self-intersection", corrupt_shapes.flaps),
        "fins": on_one_fault("fins", corrupt_meshes.fins),
        "t-vertices": on_one_fault("t-vertices", corrupt_meshes.hanging),
        "slivers": on_one_fault("slivers", corrupt_meshes.thin),
        "specks": on_one_fault("specks", corrupt_meshes.specks),
        "flipped": on_one_fault("flipped", corrupt_meshes.flipped),
        "unwelded": on_one_fault("unwelded", corrupt_meshes.unwelded),
        "not-finite": on_one_fault("not-finite", corrupt_meshes.not_finite),
    }
)

#: Repairs that add to a fault on purpose, or cut it back: what they add is measured against max_extension.
ADDING = frozenset({"components", "contacts", "holes", "margin", "trace-ends", "unfit"})
#: How much the area of a repaired fault may differ from the clean one's, as a share.
AREA = 0.02
#: How much its mean dip may differ, degrees.
DIP = 1.0
_TRIES = 5  # seeds tried until a network has a place for all kinds of a case


def corrupted(model: Model, kinds: Sequence[str], rng: np.random.Generator) -> Corrupted:
    """A clean model corrupted by kinds, in the order of :data:`KINDS`.

    Raises
    ------
    CannotCorruptError
        Where no fault has a place for one of them.
    """
    state = Corrupted(model, model)
    for kind in sorted(kinds, key=list(KINDS).index):
        state = KINDS[kind](state, rng)
    return state


@dataclass(frozen=True)
class Case:
    """A network, the kinds that corrupt it, and the number of the case among those of the same kinds."""

    network: str
    kinds: tuple[str, ...]
    seed: int

    @property
    def name(self) -> str:
        return f"{self.network}-{'+'.join(self.kinds)}-{self.seed}"

    def built(self) -> Corrupted:
        """The corrupted network; it depends on nothing but the case."""
        for attempt in range(_TRIES):
            rng = np.random.default_rng(zlib.crc32(f"{self.name}/{attempt}".encode()))
            try:
                return corrupted(clean_network(self.network), self.kinds, rng)
            except CannotCorruptError:
                continue
        raise CannotCorruptError(self.name)


@cache
def mended(case: Case) -> tuple[Corrupted, RepairResult]:
    """A case of which several tests look at what repair under the paper makes: built and repaired once."""
    built = case.built()
    return built, repair(built.model, Profile.PAPER)


def kind_sets() -> list[tuple[str, ...]]:
    """All kinds and all pairs of them."""
    return [(k,) for k in KINDS] + list(combinations(KINDS, 2))


@cache
def cases(count: int, seed: int = 0) -> tuple[Case, ...]:
    """Return cases that go through all kinds and pairs before one comes again, a third of them single kinds.

    The first cases of a longer list are those of a shorter one with the same seed.
    """
    rng = np.random.default_rng(seed)
    singles, pairs = [(k,) for k in KINDS], list(combinations(KINDS, 2))
    queues: dict[int, list[tuple[str, ...]]] = {1: [], 2: []}
    made: list[Case] = []
    while len(made) < count:
        size = 1 if len(made) % 3 == 0 else 2
        if not queues[size]:
            of = singles if size == 1 else pairs
            queues[size] = [of[k] for k in rng.permutation(len(of))]
        kinds = queues[size].pop()
        number = int(rng.integers(2**31))
        for name in rng.permutation(list(NETWORKS)).tolist():
            case = Case(name, kinds, number)
            try:
                case.built()
            except CannotCorruptError:
                continue
            made.append(case)
            break
        else:
            raise CannotCorruptError("+".join(kinds))
    return tuple(made)


@dataclass(frozen=True)
class Verdict:
    """What does not hold of a repaired network: (criterion, fault or faults, sentence) each.

    ``warned``: what the gate warns of, which fails nothing.
    """

    failed: tuple[tuple[str, str, str], ...] = ()
    warned: tuple[tuple[str, str, str], ...] = ()

    @property
    def passed(self) -> bool:
        return not self.failed

    @property
    def criteria(self) -> frozenset[str]:
        return frozenset(criterion for criterion, _, _ in self.failed)

    def __str__(self) -> str:
        return "\n".join(": ".join(f) for f in self.failed) or "passed"


def judged(
    clean: Model,
    corrupted: Model,
    repaired: Model,
    actions: Sequence[RepairAction] = (),
    gate: CheckResult | None = None,
) -> Verdict:
    """Whether a repaired network passes the gate and is what it was before it was corrupted.

    Parameters
    ----------
    clean, corrupted, repaired : Model
        Faults of the repaired one named "F1 (2)" are parts of F1.
    actions : sequence of RepairAction
        The ledger: faults to which it added something may be moved by max_extension, not max_move alone.
    gate : CheckResult, optional
        Of the repaired model under the profile of the paper, where it has been checked already.
    """
    findings = (gate or check(repaired, Profile.PAPER)).findings
    failed, warned = (
        [(f"gate {f.check}", ", ".join(f.objects), f.message) for f in findings if f.status is status]
        for status in (Status.FAIL, Status.WARN)
    )
    return Verdict((*failed, *differences(clean, corrupted, repaired, actions)), tuple(warned))


def differences(
    clean: Model, corrupted: Model, repaired: Model, actions: Sequence[RepairAction] = ()
) -> list[tuple[str, str, str]]:
    """Where a repaired network lies too far from the corrupted one, or is not what the clean one was.

    Parameters and result as of :func:`judged`, without the gate.
    """
    failed = []
    inputs = {f.name: f.surface for f in corrupted.faults}
    added = {family(name) for a in actions if a.action in ADDING for name in a.objects}
    for fault in clean.faults:
        parts = [f.surface for f in repaired.faults if family(f.name) == fault.name]
        if not parts:
            failed.append(("missing", fault.name, "The fault is gone."))
            continue
        whole = union(parts)
        limit = clean.max_extension(fault) if fault.name in added else clean.max_move(fault)
        away = float(distances(whole, [inputs[fault.name]]).max(initial=0.0))
        if away > limit * (1.0 + ROUNDING):
            failed.append(("move", fault.name, f"{away:.1f} m from the input, {limit:.1f} m allowed"))
        before, after = measured(fault.surface), measured(whole)
        change = after.area / before.area - 1.0
        if abs(change) > AREA:
            failed.append(("area", fault.name, f"{100 * change:+.2f} % of the clean area"))
        if abs(after.dip - before.dip) > DIP:
            failed.append(("dip", fault.name, f"{after.dip - before.dip:+.2f} degrees from the clean dip"))
    return failed


def family(name: str) -> str:
    """The fault of which one of this name is a part.

    >>> family("F1 (2)")
    'F1'
    """
    return re.sub(r"( \(\d+\))+$", "", name)


def union(parts: Sequence[Surface]) -> Surface:
    """Several surfaces as one, under the name of the first; no vertices are merged."""
    first = np.cumsum([0, *(len(s.vertices) for s in parts[:-1])])
    return Surface(
        parts[0].name,
        floats(np.concatenate([s.vertices for s in parts])),
        ints(np.concatenate([s.triangles + k for s, k in zip(parts, first, strict=True)])),
    )
