"""A linear algebra that tells of each system it factors, for a display of progress."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count
from typing import TYPE_CHECKING

from graben.modeling.algebra import Analysis, Backend, Factor

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scipy.sparse import csc_array


@dataclass(frozen=True, eq=False)
class Counted:
    """A backend that calls ``tell`` with the number of each matrix, from 1, before it is factored.

    Parameters
    ----------
    backend : Backend
        What does the work.
    tell : callable
        Called with the number. In a copy of the process it is called there.
    """

    backend: Backend
    tell: Callable[[int], None]
    _numbers: Iterator[int] = field(default_factory=lambda: count(1))

    def analyse(self, matrix: csc_array) -> Analysis:
        """Return the analysis of the backend, whose factors are counted."""
        return _Counted(self.backend.analyse(matrix), self)

    def factored(self) -> None:
        """Tell of one more matrix."""
        self.tell(next(self._numbers))


@dataclass(frozen=True, eq=False)
class _Counted:
    analysis: Analysis
    counter: Counted

    def factor(self, matrix: csc_array, *, probe: bool = True) -> Factor:
        """Return the factor of a matrix; see :class:`graben.modeling.algebra.Analysis`."""
        self.counter.factored()
        return self.analysis.factor(matrix, probe=probe)
