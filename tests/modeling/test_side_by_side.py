"""Tasks side by side: the same results in the same order, and no worker left behind."""

from __future__ import annotations

import os

import pytest

from graben.errors import GrabenError, ModelingError
from graben.modeling.side_by_side import worked

COSTS = [3.0, 1.0, 2.0, 5.0, 0.5]


@pytest.mark.parametrize("workers", [1, 2, 3, 8])
def test_results_do_not_depend_on_the_number_of_workers(workers: int) -> None:
    assert worked(lambda task: task**2, COSTS, workers, worth=0.0) == [0, 1, 4, 9, 16]


def test_work_is_shared_and_what_is_not_worth_a_process_stays_here() -> None:
    here = os.getpid()
    places = worked(lambda _: os.getpid(), COSTS, 2, worth=1.0)
    assert places[3] == here
    assert len(set(places)) == 2
    assert worked(lambda _: os.getpid(), COSTS, 2, worth=100.0) == [here] * 5
    assert worked(lambda _: os.getpid(), [], 2, worth=0.0) == []


def test_an_error_of_a_helper_is_that_of_the_caller() -> None:
    here = os.getpid()

    def failing(task: int) -> int:
        if os.getpid() != here:
            raise ModelingError(f"task {task} cannot be done")
        return task

    with pytest.raises(ModelingError, match="cannot be done"):
        worked(failing, COSTS, 2, worth=0.0)


def test_a_helper_that_dies_is_told_of() -> None:
    here = os.getpid()

    def dying(task: int) -> int:
        if os.getpid() != here:
            os._exit(9)
        return task

    with pytest.raises(GrabenError, match="ended before its work"):
        worked(dying, COSTS, 2, worth=0.0)
