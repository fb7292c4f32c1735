"""What a repair came to, in words: the verdict, each change, what is left, and the lines for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from graben.finding import Status
from graben.reports.check_parts import sized
from graben.reports.check_words import Teller, seen
from graben.reports.check_words import verdict as check_verdict
from graben.reports.plain import PAGE, counts, fitted, folded, more, named, unsaid
from graben.reports.style import Frame, rounded
from graben.words import plural

if TYPE_CHECKING:
    from graben.cleaning.ledger import Left, RepairAction
    from graben.pipeline import RunResult
    from graben.repairs import RepairResult

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
    warned = warnings_words(result)
    look = f" {warned}." if warned else ""
    if result.passed:
        begin = "PASSED" if result.before.passed and not result.actions else "PASSED after repair"
        return f"{begin}: {done}.{look}"
    failing = [f for f in result.after.findings if f.status is Status.FAIL]
    checks = ", ".join(dict.fromkeys(f.check for f in failing))
    count = sum(f.status is Status.FAIL for f in result.before.findings)
    verb = "fails" if len(failing) == 1 else "fail"
    still = f"{plural(len(failing), 'finding')} still {verb} ({checks}), {count} before; {done}"
    return f"NOT PASSED: {still}.{look}"


def left_sentence(result: RunResult) -> str:
    """Return what stands over the list of what repair left: which of all that warns is in it."""
    warned = warnings_words(result)
    listed = "Listed is what repair looked at, with the reason why it was left; To look at lists all."
    return f"{warned}. {listed}" if warned else listed


def warnings_words(result: RepairResult | RunResult) -> str:
    """Return how many findings warn after repair, and how many of these repair looked at and left."""
    warning = [(f.check, f.objects) for f in result.after.findings if f.status is Status.WARN]
    if not warning:
        return ""
    seen_to = {(left.check, left.objects) for left in result.left}
    count = sum(key in seen_to for key in warning)
    one = len(warning) == 1
    checks = [check for check, _ in warning]
    which = counts(checks) if len(set(checks)) > 1 else checks[0]
    said = f"{plural(len(warning), 'warning')} {'remains' if one else 'remain'} ({which})"
    if not count:
        return said
    if count == len(warning):
        return f"{said}, which repair looked at and left"
    return f"{said}, {count} of which repair looked at and left"


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


def repair_summary(
    result: RepairResult,
    *,
    verbose: bool = False,
    plan: bool = False,
    blocks: str = "",
    seconds: float | None = None,
) -> str:
    """Return a repair in lines of plain text for a terminal or a mail: what was done, and what is left.

    Parameters
    ----------
    result : RepairResult
        A finished repair.
    verbose : bool
        List each change and each thing that is left, in one line each, and how long it took.
    plan : bool
        Whether nothing was written: say so.
    blocks : str
        What to say of the fault blocks, where they were asked for.
    seconds : float, optional
        How long it took from the start of the command; default how long the repair took.
    """
    teller = Teller.of(result.input)
    head = _head(result, plan, result.seconds if seconds is None else seconds)
    each, ending = _actions(result, teller), ["", blocks] if blocks else []
    if verbose:
        left = [f"  {line}" for line in _left(result.left, teller)]
        lines = [*head, *_titled("Changes", each), *_titled("Left", left), *ending]
        return "\n".join(map(seen, lines))

    def whole(changes: list[str], most: int) -> list[str]:
        """Return all lines with at most so many things of a kind, but one at least; none is too long."""
        most = max(most, 1)
        shown = [line for text in changes[:most] for line in folded(seen(text), _indent(text))]
        top, end = (
            [line for text in texts for line in folded(seen(text)) or [""]] for texts in (head, ending)
        )
        titled = _titled("Changes", [*shown, *more(len(changes), most, "  ")])
        return [*top, *titled, *_left_lines(result, teller, most), *end]

    lines = whole(each, len(each))
    counted = _counted_actions(result, teller)
    return "\n".join(lines if len(lines) <= PAGE else fitted(lambda most: whole(counted, most)))


def _head(result: RepairResult, plan: bool, seconds: float) -> list[str]:
    """Return the verdict, what it is of and what it cost, and the verdicts of the checks."""
    head = [repair_verdict(result)]
    if plan:
        head.append("This is the plan: nothing was written.")
    cost = f"{rounded(seconds)} s, {result.peak_memory_mb:.0f} MB"
    head.append(f"Model {result.input.name}, profile {result.after.profile}; {cost}.")
    head.append(f"Before: {check_verdict(result.before)}")
    return head + ([f"After:  {check_verdict(result.after)}"] if result.actions else [])


def _indent(text: str) -> str:
    return text[: len(text) - len(text.lstrip())]


def _left_lines(result: RepairResult, teller: Teller, most: int) -> list[str]:
    """Return what is left under a title, at most so much of it."""
    told = [line for text in _left(result.left[:most], teller) for line in folded(seen(text), "  ")]
    checks = counts(left.check for left in result.left)
    return _titled(f"Left (see report): {checks}", [*told, *more(len(result.left), most, "  ")])


def _titled(title: str, lines: list[str]) -> list[str]:
    return ["", title, *lines] if lines else []


def _counted_actions(result: RepairResult, teller: Teller) -> list[str]:
    """Return a line for the changes of each fault or group of faults: how many of each kind, how far."""
    lines = []
    for objects, actions in _by_objects(result).items():
        move = move_words(max(a.max_move for a in actions), teller.frame, teller.step)
        far = f"moves up to {move}" if move else "no vertex moved"
        lines.append(f"  {named(objects)}: {counts(a.action for a in actions)}; {far}")
    return lines


def _by_objects(result: RepairResult) -> dict[tuple[str, ...], list[RepairAction]]:
    """Return the changes by the faults they are about, in the order of the first of each."""
    groups: dict[tuple[str, ...], list[RepairAction]] = {}
    for action in result.actions:
        groups.setdefault(action.objects, []).append(action)
    return groups


def _actions(result: RepairResult, teller: Teller) -> list[str]:
    """Return every change under the faults that it is about."""
    lines = []
    for objects, actions in _by_objects(result).items():
        lines.append(f"  {named(objects)}")
        lines += [f"    {a.action} ({a.check}): {action_words(a, teller)}" for a in actions]
    return lines


def _left(notes: Sequence[Left], teller: Teller) -> list[str]:
    """Return what is left and why; what to do for several alike is said once, after the last of them."""
    lines = []
    for k, left in enumerate(notes):
        why, advice = left_words(left, teller)
        # a pair is told as one: half of it would read as another finding
        names = named(left.objects) if unsaid(left.objects, why) else ""
        lines.append(f"{left.check}, {names}: {why}" if names else f"{left.check}: {why}")
        if advice and advice not in (note.advice for note in notes[k + 1 :]):
            lines.append(f"To do: {advice}")
    return lines
