"""Independent tasks worked side by side, in copies of the process.

CHOLMOD's wrapper holds the interpreter while it factors, so that threads gain nothing: two factorizations of
250,000 unknowns took 1.01 s in turn and 0.94 s in two threads.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

from graben.beside import beside

Result = TypeVar("Result")


def usable_cores() -> int:
    """Return how many processors this process may use; 1 where it cannot be copied safely."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else 1


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
    """
    own, *others = _shares(costs, workers, worth)
    later = [beside(partial(_done, function, share)) for share in others]
    done = _done(function, own)
    for value in later:
        done |= value()
    return [done[task] for task in range(len(costs))]


def _done(function: Callable[[int], Result], tasks: list[int]) -> dict[int, Result]:
    return {task: function(task) for task in tasks}


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
