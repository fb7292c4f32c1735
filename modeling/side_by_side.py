"""Independent tasks worked side by side, in processes.

CHOLMOD's wrapper holds the interpreter while it factors, so that threads gain nothing: two factorizations of
250,000 unknowns took 1.01 s in turn and 0.94 s in two threads. A forked process shares the memory of the one
that made the tasks, and only results travel.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any, TypeVar

from graben.errors import GrabenError

Result = TypeVar("Result")


def usable_cores() -> int:
    """Return how many processors this process may use; 1 where processes cannot be forked safely."""
    forks = sys.platform == "linux" and not multiprocessing.current_process().daemon
    return len(os.sched_getaffinity(0)) if forks else 1


def worked(
    function: Callable[[int], Result], costs: Sequence[float], workers: int, worth: float
) -> list[Result]:
    """Return ``[function(0), function(1), ...]``, one for each cost, worked by several processes.

    The result does not depend on their number. This process takes a share itself.

    Parameters
    ----------
    function : callable
        From the number of a task to its result, which must be picklable.
    costs : sequence of float
        How much work each task is, in any unit.
    workers : int
        Most processes, this one included.
    worth : float
        Least cost, in the same unit, for which another process is started.

    Raises
    ------
    GrabenError
        When a process ends before its work, as for want of memory.
    """
    shares = _shares(costs, workers, worth)
    helpers = [_started(function, share) for share in shares[1:]]
    try:
        done = {task: function(task) for task in shares[0]}
        for _, receiver in helpers:
            done |= _received(receiver)
    finally:
        for process, receiver in helpers:
            receiver.close()
            process.terminate()
            process.join()
    return [done[task] for task in range(len(costs))]


def _shares(costs: Sequence[float], workers: int, worth: float) -> list[list[int]]:
    """Return the tasks of each process, the largest given out first, each to the one with the least to do.

    >>> _shares([5.0, 1.0, 4.0, 3.0], 2, 2.0)
    [[0, 1], [2, 3]]
    >>> _shares([5.0, 1.0], 2, 2.0)
    [[0, 1]]
    """
    shares: list[list[int]] = [[] for _ in range(max(workers, 1))]
    loads = [0.0] * len(shares)
    for task in sorted(range(len(costs)), key=lambda t: (-costs[t], t)):
        least = loads.index(min(loads))
        shares[least].append(task)
        loads[least] += costs[task]
    small = [k for k, load in enumerate(loads) if k > 0 and load < worth]
    own = sorted(shares[0] + [task for k in small for task in shares[k]])
    return [own, *(sorted(share) for k, share in enumerate(shares) if k > 0 and k not in small)]


def _started(function: Callable[[int], Result], tasks: list[int]) -> tuple[BaseProcess, Connection]:
    """Return a process that has begun with some tasks, and where its results will arrive."""
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(function, tasks, sender), daemon=True)
    process.start()
    # This process must not hold the sending end, or it would wait for a helper that is gone.
    sender.close()
    return process, receiver


def _work(function: Callable[[int], Result], tasks: list[int], sender: Connection) -> None:
    # An interrupt is for the process that waits, which then ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        sender.send({task: function(task) for task in tasks})
    except Exception as error:
        sender.send(error)


def _received(receiver: Connection) -> dict[int, Any]:
    try:
        answer = receiver.recv()
    except EOFError:
        raise GrabenError(
            "A process that solved part of the model ended before its work, as happens for want of memory: "
            "give it more, or use one worker."
        ) from None
    if isinstance(answer, Exception):
        raise answer
    return dict(answer)
