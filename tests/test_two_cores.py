"""A share given to a copy of the process changes nothing: the same values, findings and bytes come."""

from __future__ import annotations

import json
import os
import re
from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest

from graben import beside as copies
from graben.arrays import floats
from graben.beside import shared
from graben.finding import Profile
from graben.modeling import misfit, problems, zone
from graben.modeling.misfit import misfit_of
from graben.modeling.tracing import cut_graph
from graben.modeling.triangulation import triangulated
from graben.pipeline import build
from graben.refinement import refined
from graben.reports import images, run_figures, writing
from graben.reports.figures import throw_figure
from graben.reports.images import Prints
from graben.reports.style import Frame
from graben.reports.writing import write_run
from graben.stages import examined, quiet
from graben.validators import course
from graben.validators.context import Anchoring, Evidence
from graben.validators.runner import run_checks
from tests.models import grid_horizon, model_of, plane_fault
from tests.reports import sample
from tests.zoo import FAILING, said
from tests.zoo.shapes import F60, STEP, Fakes, L, N, T, faults, graph, joined, level

HERE = os.getpid()


def fails():
    raise ZeroDivisionError


def end_of_a_copy():
    if os.getpid() != HERE:
        os._exit(1)
    return "done"


def test_shared_tasks_give_their_values_in_order():
    assert shared([partial(pow, 2, k) for k in range(20)]) == [2**k for k in range(20)]
    assert shared([partial(pow, 2, 3)]) == [8]
    assert shared([]) == []


def test_shared_tasks_take_both_processes():
    if not copies._may_copy():
        pytest.skip("one core, or no copy of a process here")
    source, target = os.pipe()
    # each waits until the other has begun, so that neither process can take both
    first = partial(os.read, source, 1)

    def second():
        os.write(target, b"x")
        return os.getpid()

    assert shared([lambda: (first(), os.getpid())[1], second]).count(HERE) == 1


@pytest.mark.parametrize("tasks", [[fails, int], [int, fails]], ids=["first", "last"])
def test_an_error_of_a_shared_task_is_that_of_the_task(tasks):
    with pytest.raises(ZeroDivisionError):
        shared(tasks)


def test_shared_tasks_of_a_copy_that_was_ended_are_done_again():
    assert shared([end_of_a_copy] * 5) == ["done"] * 5


@pytest.mark.parametrize("case", FAILING, ids=[f"{c.check}: {c.name}" for c in FAILING])
def test_checks_say_the_same(monkeypatch, case):
    monkeypatch.setattr(course, "_LARGE", -1)
    result, evidence, _ = examined(case.model, Profile.EXTENDED, quiet)
    plain, seen = said(case, Profile.EXTENDED)
    assert result.as_dict() == plain.as_dict()
    assert told(evidence) == told(seen)


@pytest.mark.parametrize("anchors", [{}, {"H": "no room."}], ids=["anchored", "not prepared"])
def test_nothing_is_left_of_what_was_prepared_for_a_horizon_that_is_then_blocked(monkeypatch, anchors):
    nodes = [(1, 4), (2, 4), (3, 4), (4, 4), (5, 4)]
    net = graph(nodes, [T, N, N, N, L], [(0, 1), (1, 2), (2, 3), (3, 4)], [0] * 4)
    model, given = faults(F60, horizons=[level()]), Fakes(graphs={"H": net}, anchors=anchors)
    plain, seen = run_checks(model, Profile.EXTENDED, given)
    monkeypatch.setattr(course, "_LARGE", -1)
    result, evidence = run_checks(model, Profile.EXTENDED, given)
    assert [f.check for f in evidence.blocked("H")] == ["trace"]
    assert result.as_dict() == plain.as_dict()
    assert told(evidence) == told(seen)
    assert not evidence.anchors
    assert not evidence.errors


class Failing(Fakes):
    """What traces of an unfit horizon may come to."""

    def graph(self, model, horizon, complex):
        raise IndexError


def test_a_horizon_may_be_anything_where_checks_beside_block_it(monkeypatch):
    given = level()
    doubled = replace(given, surface=joined(given.surface, given.surface.moved(floats([0, 0, STEP]))))
    model = faults(F60, horizons=[doubled])
    plain, seen = run_checks(model, Profile.EXTENDED, Failing())
    assert [f.check for f in seen.blocked("H")]
    monkeypatch.setattr(course, "_LARGE", -1)
    result, evidence = run_checks(model, Profile.EXTENDED, Failing())
    assert result.as_dict() == plain.as_dict()
    assert told(evidence) == told(seen)
    with pytest.raises(IndexError):
        run_checks(faults(F60, horizons=[level()]), Profile.EXTENDED, Failing())


def test_the_misfit_is_the_same(monkeypatch):
    given = sample.cut_result(), sample.model()
    plain = misfit_of(*given)()
    monkeypatch.setattr(misfit, "_WORTH", 0)
    made = misfit_of(*given)()
    assert repr(made.bins) == repr(plain.bins)
    assert made.masked == plain.masked


def told(evidence: Evidence) -> dict[str, object]:
    """What a look saw, as plain values."""
    blocking = [(f.check, f.objects, f.message) for f in evidence.blocking]
    anchors = {name: [anchor_told(a) for a in own] for name, own in evidence.anchors.items()}
    return {
        "blocking": blocking,
        "anchors": anchors,
        "errors": dict(evidence.errors),
        "graphs": list(evidence.graphs),
    }


def anchor_told(anchor: Anchoring) -> tuple[object, ...]:
    return anchor.subdomain, anchor.faults, anchor.fixed, anchor.spread, *anchor.place.tolist()


def test_a_horizon_is_triangulated_the_same(monkeypatch):
    horizon = grid_horizon(lambda x, y: 0.02 * x)
    fault = plane_fault((0.0, -800.0), (200.0, 900.0))
    cut = cut_graph(model_of(horizon, fault), horizon, refined([fault.surface]))
    assert len(cut.edges)
    given = horizon.surface, cut, horizon.step, np.array([400.0])
    plain = triangulated(*given)
    monkeypatch.setattr(zone, "_WORTH", 0)
    made = triangulated(*given)
    np.testing.assert_array_equal(made.points, plain.points)
    np.testing.assert_array_equal(made.triangles, plain.triangles)


def test_a_horizon_is_rebuilt_the_same(monkeypatch):
    model = model_of(grid_horizon(lambda x, y: 0.02 * x), plane_fault((0.0, -800.0), (200.0, 900.0)))
    (plain,) = build(model, mend=False).horizons
    monkeypatch.setattr(problems, "_WORTH", 0)
    (made,) = build(model, mend=False).horizons
    np.testing.assert_array_equal(made.surface.vertices, plain.surface.vertices)
    np.testing.assert_array_equal(made.surface.triangles, plain.surface.triangles)
    assert len(made.cutoffs) == 1


def test_the_folder_of_a_run_holds_the_same_bytes(monkeypatch, tmp_path):
    result = sample.run_result()
    write_run(result, tmp_path / "plain")
    monkeypatch.setattr(writing, "_WORTH", 0)
    monkeypatch.setattr(run_figures, "MOST_DRAWN", 0)
    write_run(result, tmp_path / "shared")
    files = [f.relative_to(tmp_path / "plain") for f in (tmp_path / "plain").rglob("*") if f.is_file()]
    timed = {"report.html", "report.json"}
    for file in (f for f in files if str(f) not in timed):
        assert (tmp_path / "shared" / file).read_bytes() == (tmp_path / "plain" / file).read_bytes(), file
    assert pictures(tmp_path / "shared") == pictures(tmp_path / "plain") != []
    reports = [json.loads((tmp_path / name / "report.json").read_text()) for name in ("plain", "shared")]
    for report in reports:
        del report["timings"]
    assert reports[0] == reports[1]


def pictures(folder) -> list[str]:
    """The pictures of a report, as their addresses."""
    return re.findall('src="data:image[^"]+"', (folder / "report.html").read_text(encoding="utf-8"))


@cache
def at_every_resolution() -> list[str]:
    draw = partial(throw_figure, sample.cut_result(), Frame("m", 1.0))
    return [Prints(draw)._at(dpi) for dpi in images._RESOLUTIONS]


@pytest.mark.parametrize("most", [3_000, 12_000, 30_000, 300_000])
def test_a_resolution_passed_over_would_not_have_fitted(most):
    prints = Prints(partial(throw_figure, sample.cut_result(), Frame("m", 1.0)))
    taken = prints.address(most, drawing=False)
    every = at_every_resolution()
    assert taken == next((text for text in every if len(text) <= most), every[-1])


def test_a_print_that_is_known_is_not_drawn_again():
    first = Prints(partial(throw_figure, sample.cut_result(), Frame("m", 1.0)))
    taken = first.address(300_000)
    assert Prints(fails, first.known).address(300_000) == taken
