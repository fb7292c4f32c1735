"""What a command says of its progress: the stage, what is in work, the time that passed and is left."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TextIO

from graben.stages import Work

#: Less of a stage than this says too little of the rest, and seconds below this are not told.
_LEAST_SHARE, _LEAST_LEFT = 0.05, 1.0


class Course:
    """How far a command has come; called as a ``graben.stages.Progress``.

    Nothing is drawn and nothing is locked by a call, so that a copy of the process may make one.

    Parameters
    ----------
    plan : sequence of str
        The stages of the command in their order. A stage may be left out; what others say, such as the
        checks of a repair, is shown as work of the stage that was begun last.
    began : float
        When the command began, by ``clock``.
    lines : text stream, optional
        Where to write a line for each thing that is told.
    clock : callable
        Seconds.

    >>> course = Course(("read", "check"), 0.0, clock=lambda: 65.0)
    >>> course("check", "two faults")
    >>> course("trace", "Top A")
    >>> course.line()
    '[2/2] check: trace Top A, 1:05'
    """

    def __init__(
        self,
        plan: Sequence[str],
        began: float,
        lines: TextIO | None = None,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self._plan, self._began, self._lines, self._clock = tuple(plan), began, lines, clock
        self._number = 0
        self._what = self._last = ""
        self._stage_began = self._told_at = clock()
        self._share: float | None = None

    def __call__(self, stage: str, what: str) -> None:
        """Take down what is in work now."""
        self._told_at = self._clock()
        if stage in self._plan[self._number :]:
            number = self._plan.index(stage)
            if number != self._number:
                self._stage_began = self._told_at
            self._number, self._what = number, what
        else:
            self._what = f"{stage} {what}"
        self._share = what.share if isinstance(what, Work) else None
        if self._lines is not None and not (isinstance(what, Work) and what.passing):
            self._written(self._lines, self._words())

    def _written(self, lines: TextIO, words: str) -> None:
        """Write a line, unless it says what the last one said."""
        if words != self._last:
            lines.write(f"{self._told_at - self._began:8.1f} s  {words}\n")
            lines.flush()
        self._last = words

    def _words(self) -> str:
        what = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in self._what)
        stage = f"[{self._number + 1}/{len(self._plan)}] {self._plan[self._number]}"
        return f"{stage}: {what}" if what else stage

    def line(self) -> str:
        """Return all that is known now, in one line."""
        left = self.left()
        rest = "" if left is None else f", about {spell(left)} left of this stage"
        return f"{self._words()}, {spell(self._clock() - self._began)}{rest}"

    def left(self) -> float | None:
        """Return the seconds that the stage still takes if it goes on as it went; None where none can say."""
        share = self._share
        if share is None or share < _LEAST_SHARE:
            return None
        spent = self._told_at - self._stage_began
        left = spent * (1.0 - share) / share - (self._clock() - self._told_at)
        return left if left >= _LEAST_LEFT else None


def spell(seconds: float) -> str:
    """Return a time as minutes and seconds, with hours where there are some.

    >>> spell(7.9), spell(125.0), spell(3725.0)
    ('0:07', '2:05', '1:02:05')
    """
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
