"""What the throw of a rebuilt horizon says of its faults: ends that are no tips, places without throw, jumps.

Throw vanishes at the tips of a fault and nowhere else, and changes smoothly on the way. Where it does not, a
fault was picked too short, joined to another that is not the same, or the horizon was picked across it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import pairwise

import numpy as np

from graben.arrays import FloatArray, IntArray, floats
from graben.cutgraph import NodeKind
from graben.model import Model
from graben.modeling.beyond import step_beyond
from graben.modeling.misfit import Missed, misfit_of
from graben.modeling.results import HorizonResult, TerminationType
from graben.modeling.throws import TOLD, Along, along, sign_changes, told_from
from graben.validators.measuring.measures import amount

#: Share of the largest throw by which the horizon may step beyond a tip: what is taken on over half a gamma
#: is told half as well as throw is.
_BEYOND = 2.0 * TOLD
#: A change of throw from node to node is a jump where it goes beyond both its neighbours by this many median
#: changes. On the models with a known answer it does by at most 0.2, on rough real faults by 1.5.
_JUMP = 3.0
#: Differences from the input in the outer half of the zone above this share of the largest throw, and as many
#: times those beyond the zone, throw doubt on it. Input smeared as wide as gamma leaves 15 % of the throw
#: there, and the real horizons at hand that follow their input 1 to 7 %; a throw that came out at half of
#: what the picks show left 60 %.
_MISSED, _MISSED_TIMES = 0.2, 3.0
#: The same beyond the smear, where nothing but noise should be left: what is left besides it, over the
#: largest throw and over the noise. On demo models with zones of 3 to 12 standard widths of the smear, throws
#: were off by 9 to 33 % where 2 % and more was left, by 1 to 10 % where less was.
_MISSED_CLEAR, _OVER_NOISE = 0.02, 0.5
#: Below this many steps gamma leaves the zone hardly a node of its own; points have a finer step.
_LEAST_GAMMA, _USUAL_GAMMA = 2.0, 4.0


class Doubt(StrEnum):
    """What is doubtful about a throw."""

    NO_TIP = "no tip"  #: the horizon steps on beyond an end inside it
    NO_THROW = "no throw"  #: it all but vanishes between the ends
    TURN = "turn"  #: it changes its sign along strike
    JUMP = "jump"  #: it changes from one node to the next
    MISSED = "missed"  #: the rebuilt horizon does not follow the input in the outer half of the zone


@dataclass(frozen=True, eq=False)
class ThrowDoubt:
    """A place at which the throw of a fault is not as that of a fault should be.

    Parameters
    ----------
    kind : Doubt
        What it is.
    horizon, fault : str
        Names.
    value, largest : float
        The throw, or step of it, that is doubtful, and the largest throw of the fault, model units.
    place : (3,) array
        Halfway between the lips, model units.
    message : str
        A sentence with place and remedy, elevations in the model's own convention.
    """

    kind: Doubt
    horizon: str
    fault: str
    value: float
    largest: float
    place: FloatArray
    message: str

    def __str__(self) -> str:
        return self.message


def judged(result: HorizonResult, model: Model) -> HorizonResult:
    """Return a rebuilt horizon with its misfit, its doubts, and warnings that tell these.

    Parameters
    ----------
    result : HorizonResult
        A rebuilt horizon, in the frame of the model.
    model : Model
        The model that it was rebuilt from: its faults, gammas, tolerance and unit.
    """
    later = misfit_of(result, model)
    asked = list(_asked(result, model))
    own = [list(fault.along()) for fault in asked]
    found = later()
    missed = {m.fault: m for m in found.missed}
    doubts = tuple(
        doubt
        for fault, told in zip(asked, own, strict=True)
        for doubt in (*told, *(fault.missed(missed[fault.name]) if fault.name in missed else ()))
    )
    warnings = (*result.warnings, *(str(doubt) for doubt in doubts))
    return replace(result, misfit=found, doubts=doubts, warnings=warnings)


def _asked(result: HorizonResult, model: Model) -> Iterator[_Asked]:
    """Yield the faults whose throws are asked.

    These are faults whose subdomains all converged: elsewhere the termination says what is wrong. Throws that
    cannot be told from none (:func:`graben.modeling.throws.told_from`) say nothing.
    """
    ended = [s for s in result.subdomains if s.termination.type is not TerminationType.CONVERGED]
    unsure = {name for s in ended for name in s.faults}
    lines = along(result, [f.surface for f in model.faults])
    for name in dict.fromkeys(a.cutoff.fault for a in lines):
        mine = tuple(a for a in lines if a.cutoff.fault == name)
        largest = max(float(np.abs(a.cutoff.throw).max()) for a in mine)
        least = told_from(largest, model.tolerance, result.horizon.noise)
        if name not in unsure and largest > least:
            yield _Asked(result, model, name, mine, largest, least)


@dataclass(frozen=True, eq=False)
class _Asked:
    """One fault on one horizon: its cutoffs, its largest throw, and that which cannot be told from none."""

    result: HorizonResult
    model: Model
    name: str
    lines: tuple[Along, ...]
    largest: float
    least: float

    def along(self) -> Iterator[ThrowDoubt]:
        """Yield what is doubtful along its cutoffs."""
        for line in self.lines:
            yield from (*self.ends(line), *self.gone(line), *self.turns(line), *self.jumps(line))

    def ends(self, line: Along) -> Iterator[ThrowDoubt]:
        """Yield ends inside the horizon beyond which the horizon steps on."""
        for row, rows in ((0, line.stretches()[0]), (len(line.kinds) - 1, line.stretches()[-1])):
            if line.kinds[row] not in (NodeKind.TIP, NodeKind.LOOSE):
                continue
            name = line.cutoff.fault
            step = step_beyond(self.result, self.model, name, line.middle[rows], last=row > 0)
            sign = float(np.sign(line.cutoff.throw[rows].sum()))
            if step is None or not step.clear or sign * step.value <= _BEYOND * self.largest:
                continue
            said = (
                f"{self.result.name} steps by {self._length(step.value)} beyond the end of {name}, whose "
                f"throw of up to {self._length(self.largest)} is cut to none there: pick the fault further"
            )
            yield self._doubt(Doubt.NO_TIP, line, row, step.value, said)

    def gone(self, line: Along) -> Iterator[ThrowDoubt]:
        """Yield stretches between two with throw of the same sign on which there is none."""
        throw = line.cutoff.throw
        for a, b in pairwise(np.flatnonzero(np.abs(throw) > self.least).tolist()):
            if b - a < 2 or throw[a] * throw[b] < 0:
                continue
            row = a + int(np.argmin(np.abs(throw[a : b + 1])))
            said = (
                f"The throw of {line.cutoff.fault} on {self.result.name} falls to {self._length(throw[row])} "
                f"between its ends, from up to {self._length(self.largest)}: look whether two faults were "
                "picked as one"
            )
            yield self._doubt(Doubt.NO_THROW, line, row, float(throw[row]), said)

    def turns(self, line: Along) -> Iterator[ThrowDoubt]:
        """Yield places at which a fault turns from normal to reverse, or back."""
        for row in sign_changes(line.cutoff.throw, self.least).tolist():
            words = "normal to reverse" if line.cutoff.throw[row] > 0 else "reverse to normal"
            said = (
                f"{line.cutoff.fault} turns from {words} on {self.result.name}: look whether two faults were "
                "picked as one, or the horizon was picked across it"
            )
            yield self._doubt(Doubt.TURN, line, row, float(line.cutoff.throw[row]), said)

    def jumps(self, line: Along) -> Iterator[ThrowDoubt]:
        """Yield places at which the throw jumps from one node to the next, off junctions."""
        for rows in line.stretches():
            throw = line.cutoff.throw[rows]
            for k in jumps(line.cutoff.s[rows], throw, self.least).tolist():
                size = float(throw[k + 1] - throw[k])
                said = (
                    f"The throw of {line.cutoff.fault} on {self.result.name} jumps by {self._length(size)} "
                    "within a step: look at the picks of the horizon and of the fault"
                )
                yield self._doubt(Doubt.JUMP, line, rows.start + k, size, said)

    def missed(self, found: Missed) -> Iterator[ThrowDoubt]:
        """Yield where the input of the outer part of the zone is not followed."""
        if found.clear:
            noise = max(found.beyond, self.result.horizon.noise or 0.0)
            left = np.sqrt(max(found.rms**2 - noise**2, 0.0))
            least = max(_MISSED_CLEAR * self.largest, _OVER_NOISE * noise, self.model.tolerance)
        else:
            left = found.rms
            least = max(_MISSED * self.largest, _MISSED_TIMES * found.beyond, self.least)
        if left <= least:
            return
        where, times = (", beyond its smear,", "several times ") if found.clear else ("", "")
        what = "picks" if len(self.result.horizon.picks) else "nodes"
        said = (
            f"{self.result.name} misses its {what} {self._length(found.near)} to {self._length(found.far)} "
            f"from {found.fault}{where} by {self._length(found.rms)} (rms), beside a largest throw of "
            f"{self._length(self.largest)}, which may be {times}as wrong; the zone holds relief that is not "
            f"used: {self._finer(found)}"
        )
        yield self._at(Doubt.MISSED, found.fault, found.place, found.rms, said)

    def _finer(self, found: Missed) -> str:
        """Return how to make the zone of a fault narrower."""
        step = self.result.horizon.step
        if found.near >= _LEAST_GAMMA * step:
            return f"lower gamma to about {self._length(found.near)}"
        if len(self.result.horizon.picks):
            finer = float(f"{found.near / _USUAL_GAMMA:.2g}")
            return f"set step = {finer:.12g}, and with it gamma to {self._length(found.near)}"
        return "give a grid with a smaller step, and lower gamma"

    def _doubt(self, kind: Doubt, line: Along, row: int, value: float, said: str) -> ThrowDoubt:
        return self._at(kind, line.cutoff.fault, line.middle[row], value, said)

    def _at(self, kind: Doubt, fault: str, place: FloatArray, value: float, said: str) -> ThrowDoubt:
        z = self.model.z_factor * place[2]
        at = f"x {place[0]:.7g}, y {place[1]:.7g}, {self.model.z} {z:.5g}"
        message = f"{said} (at {at})."
        return ThrowDoubt(kind, self.result.name, fault, value, self.largest, floats(place), message)

    def _length(self, value: float) -> str:
        return amount(abs(value), "" if self.model.unit == "none" else self.model.unit)


def jumps(s: FloatArray, throw: FloatArray, least: float) -> IntArray:
    """Return the rows after which throw jumps: more than beside it, by far more than it changes elsewhere.

    Parameters
    ----------
    s, throw : (k,) arrays
        Along one stretch without a junction.
    least : float
        Jumps up to this are none, model units.

    >>> jumps(floats([0, 1, 2, 3, 4, 5, 6]), floats([5, 6, 7, 27, 28, 29, 30]), 2.0).tolist()
    [2]
    """
    if len(s) < 4:
        return np.zeros(0, dtype=np.int64)
    step = np.diff(s)
    slope = np.diff(throw) / step
    # By how much a slope lies outside those of its neighbours: not at all at a peak, at a corner, beside a
    # jump. The first and the last have one neighbour each: ends are asked elsewhere.
    before, here, after = slope[:-2], slope[1:-1], slope[2:]
    over = np.maximum(here - np.maximum(before, after), np.minimum(before, after) - here)
    excess = np.maximum(over, 0.0) * step[1:-1]
    usual = float(np.median(np.abs(np.diff(throw))))
    padded = np.pad(excess, 1)
    # Of the two sides of a single wrong node, the larger.
    peak = (excess >= padded[:-2]) & (excess > padded[2:])
    return np.flatnonzero((excess > max(least, _JUMP * usual)) & peak) + 1
