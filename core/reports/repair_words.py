"""What a repair came to, in words: the verdict, each change, what is left, and the lines for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from graben.finding import Status
from graben.reports.check_parts import sized
from graben.reports.check_words import Teller, seen
from graben.reports.check_words import verdict as check_verdict
from graben.reports.style import Frame, rounded
from graben.reports.summary import plural

if TYPE_CHECKING:
    from graben.cleaning.ledger import Left, RepairAction
    from graben.repairs import RepairResult

#: So many lines of one kind are listed without -v, and so many names in one.
_MOST, _MOST_NAMES = 20, 6
#: Moves below this share of the distance at which things are told apart are rounding.
_NOISE = 1e-8
#: What a defect leads to where it is modeled all the same, and what a person should do (paper, Table 4).
_STAGNATES = (
    "Iteration may stagnate (termination type 1): the geometry contradicts itself. Change theta, or enlarge "
    "gamma."
)
_LEAVES = (
    "A point may leave its fault (termination type 2): the fault dips too little or ends too early. Extend "
    "the fault, or change its elevations."
)
_CROSSED = (
    "A vertex where faults meet may find no place (termination type 3): their intersection is not right. "
    "Correct the intersection, or enlarge the domain."
)
TABLE_4 = {
    "self-intersection": _CROSSED,
    "functional": _LEAVES,
    "z-monotone": _LEAVES,
    "min-dip": _LEAVES,
    "simplicial-complex": _CROSSED,
    "pairwise-connected": _CROSSED,
    "near-miss": _CROSSED,
    "horizon": _STAGNATES,
    "trace": _LEAVES,
    "junction": _CROSSED,
    "junction-values": _CROSSED,
    "acyclic": _STAGNATES,
    "anchored": _STAGNATES,
}


def repair_verdict(result: RepairResult) -> str:
    """Return the verdict in one or two sentences, which begin with "PASSED" or "NOT PASSED"."""
    done = _done(result)
    left = [f for f in result.after.findings if f.status is Status.FAIL]
    if result.passed:
        begin = "PASSED" if result.before.passed and not result.actions else "PASSED after repair"
        notes = len(result.left)
        verb = "remains" if notes == 1 else "remain"
        look = f" {plural(notes, 'warning')} {verb} that it could not repair." if notes else ""
        return f"{begin}: {done}.{look}"
    checks = ", ".join(dict.fromkeys(f.check for f in left))
    count = sum(f.status is Status.FAIL for f in result.before.findings)
    verb = "fails" if len(left) == 1 else "fail"
    still = f"{plural(len(left), 'finding')} still {verb} ({checks}), {count} before; {done}"
    return f"NOT PASSED: {still}."


def _done(result: RepairResult) -> str:
    """Return how much was changed."""
    if not result.actions:
        return "nothing was changed"
    given = {f.name: f.surface for f in result.input.faults}
    same = {result.lineage.get(f.name, f.name) for f in result.model.faults if f.surface is given.get(f.name)}
    count = len(given) - len(same)
    return f"{plural(len(result.actions), 'change')} on {count} of {plural(len(given), 'fault')}"


def action_words(action: RepairAction, teller: Teller) -> str:
    """Return one change in words: why, how many elements, how much, how far and where."""
    said = [plural(action.count, "element")]
    if action.size is not None:
        said.append(sized(action.size, action.unit))
    move = move_words(action.max_move, teller.frame, teller.step)
    said.append(f"moves up to {move}" if move else "no vertex moved")
    where = "" if action.place is None else f", at {teller.place(action.place)}"
    return f"{action.reason} ({', '.join(said)}{where})"


def move_words(value: float, frame: Frame, step: float) -> str:
    """Return a move in words; empty where it is rounding for things ``step`` units apart."""
    return frame.length(value) if value > _NOISE * step else ""


def left_words(left: Left, teller: Teller) -> tuple[str, str]:
    """Return what is left in words: why and where, and what to do."""
    more = "" if left.needed is None else f" It would take {needed_words(left)} more."
    where = "" if left.place is None else f" At {teller.place(left.place)}."
    return f"{left.reason}{more}{where}", left.advice


def needed_words(left: Left) -> str:
    """Return how much more of a limit it would take; empty where that is not known."""
    return "" if left.needed is None else f"{rounded(left.needed)} {left.unit}".rstrip()


def named(objects: Sequence[str]) -> str:
    """Return names in one line, not without end."""
    more = len(objects) - _MOST_NAMES
    return ", ".join(objects[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


def repair_summary(
    result: RepairResult, *, verbose: bool = False, plan: bool = False, blocks: str = ""
) -> str:
    """Return a repair in lines of plain text for a terminal: what was done, fault by fault, and what is left.

    Parameters
    ----------
    result : RepairResult
        A finished repair.
    verbose : bool
        List everything, and how long it took.
    plan : bool
        Whether nothing was written: say so.
    blocks : str
        What to say of the fault blocks, where they were asked for.
    """
    teller = Teller.of(result.input)
    most = None if verbose else _MOST
    lines = [repair_verdict(result)]
    if plan:
        lines.append("This is the plan: nothing was written.")
    lines.append(f"Model {result.input.name}, profile {result.after.profile}.")
    lines.append(f"Before: {check_verdict(result.before)}")
    if result.actions:
        lines += [f"After:  {check_verdict(result.after)}", "", "Changes", *_actions(result, teller, most)]
    if result.left:
        lines += ["", "Left", *_left(result, teller, most)]
    if blocks:
        lines += ["", blocks]
    if verbose:
        lines += ["", f"{result.seconds:.1f} s, largest memory {result.peak_memory_mb:.0f} MiB."]
    return "\n".join(map(seen, lines))


def _actions(result: RepairResult, teller: Teller, most: int | None) -> list[str]:
    """Return the changes grouped by the faults they are about, in the order of the first of each."""
    groups: dict[tuple[str, ...], list[RepairAction]] = {}
    for action in result.actions[:most]:
        groups.setdefault(action.objects, []).append(action)
    lines = []
    for objects, actions in groups.items():
        lines.append(f"  {named(objects)}")
        lines += [f"    {a.action} ({a.check}): {action_words(a, teller)}" for a in actions]
    return lines + _more(len(result.actions), most)


def _left(result: RepairResult, teller: Teller, most: int | None) -> list[str]:
    lines = []
    for left in result.left[:most]:
        why, advice = left_words(left, teller)
        lines.append(f"  {left.check}, {named(left.objects) or 'the model'}: {why}")
        lines += [f"    To do: {advice}"] if advice else []
    return lines + _more(len(result.left), most)


def _more(count: int, most: int | None) -> list[str]:
    if most is None or count <= most:
        return []
    return [f"  and {count - most} more: -v and report.json list them."]
