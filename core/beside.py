"""Work done beside the rest of a run, in a copy of the process on a second core."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import NoReturn, TypeVar

Value = TypeVar("Value")

#: Bytes of the number of a task.
_NUMBER = 2


def beside(work: Callable[[], Value]) -> Callable[[], Value]:
    """Begin some work in a forked copy of this process, and return what waits for its value.

    Where the process cannot or should not be copied (one core, another system than Linux, other threads)
    the work is done when the value is asked for; and again where the copy failed, so that an error is the
    same as without one. The value is the same in any case.

    Parameters
    ----------
    work : callable
        Without arguments; its value can be pickled. What it changes in memory is lost, files that it
        writes are not.

    >>> later = beside(lambda: sum(range(5)))
    >>> later()
    10
    """
    if not _may_copy():
        return work
    source, target = os.pipe()
    sys.stdout.flush()
    sys.stderr.flush()
    copy = os.fork()
    if copy == 0:
        os.close(source)
        _serve(work, target)
    os.close(target)

    def value() -> Value:
        with os.fdopen(source, "rb") as pipe:
            content = pipe.read()
        os.waitpid(copy, 0)
        try:
            told: Value = pickle.loads(content)
        except (EOFError, pickle.UnpicklingError):
            return work()
        return told

    return value


def shared(tasks: Sequence[Callable[[], Value]]) -> list[Value]:
    """Return the values of some tasks, worked by this process and a copy of it.

    Each takes the next one that none has begun, so that both have work to the end: the longest should come
    first. What holds for :func:`beside` holds here.

    >>> shared([lambda: 1, lambda: 2])
    [1, 2]
    """
    return begun(tasks)()


def begun(tasks: Sequence[Callable[[], Value]]) -> Callable[[], list[Value]]:
    """Begin some tasks in a copy of this process, and return what takes its share of the rest.

    Parameters
    ----------
    tasks : sequence of callables
        As of :func:`beside`, independent of each other; some thousands at most.

    Returns
    -------
    callable
        Works on the tasks that none has begun and returns the values of all. Where one fails here, the copy
        ends its own and begins no other.
    """
    if len(tasks) < 2:
        later = [beside(task) for task in tasks]
        return lambda: [value() for value in later]
    if not _may_copy():
        return lambda: [task() for task in tasks]
    # what a pipe holds can be taken once, by either process
    source, target = os.pipe()
    os.write(target, b"".join(k.to_bytes(_NUMBER, "little") for k in range(len(tasks))))
    os.close(target)

    def taken() -> Iterator[int]:
        while number := os.read(source, _NUMBER):
            yield int.from_bytes(number, "little")

    def done() -> dict[int, Value]:
        return {k: tasks[k]() for k in taken()}

    copied = beside(done)

    def values() -> list[Value]:
        try:
            found = done()
        except BaseException:
            list(taken())
            copied()
            raise
        found |= copied()
        os.close(source)
        return [found[k] if k in found else tasks[k]() for k in range(len(tasks))]

    return values


def _may_copy() -> bool:
    """Return whether a copy of this process is safe and of use.

    The thread of the progress display holds nothing that the work asks for.
    """
    if sys.platform != "linux" or len(os.sched_getaffinity(0)) < 2:
        return False
    others = [t for t in threading.enumerate() if t is not threading.main_thread()]
    return all(type(t).__module__.startswith("rich.") for t in others)


def _serve(work: Callable[[], object], target: int) -> NoReturn:
    """Write the value of some work, nothing where it fails, and end without what else ends a process."""
    try:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        content = pickle.dumps(work(), protocol=pickle.HIGHEST_PROTOCOL)
        with os.fdopen(target, "wb") as pipe:
            pipe.write(content)
    finally:
        os._exit(0)
