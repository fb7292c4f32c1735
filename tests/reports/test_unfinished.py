"""What the report of a run says of horizons that did not converge, and of figures: no more than is so."""

from __future__ import annotations

from dataclasses import replace

from graben.modeling.throws import fault_throws
from graben.pipeline import RunResult
from graben.reports.html import report_html
from graben.reports.plan_map import map_figure
from graben.reports.run_rows import key_figures, parameters, sizes, subdomain_rows
from graben.reports.run_words import run_summary
from graben.reports.style import Frame
from graben.settings import Parameters, meaning
from tests.reports import sample

FRAME = Frame("m", 1.0)


def figures(result: RunResult) -> dict[str, tuple[str, str]]:
    faults = [f.surface for f in result.repaired.faults]
    throws = [t for h in result.horizons if h.cutoffs for t in fault_throws(h, faults, 0.1)]
    return {label: (value, note) for label, value, note in key_figures(result, throws, [], FRAME)}


def test_only_what_converged_counts_as_modeled() -> None:
    assert figures(sample.run_result())["Horizons modeled"] == ("2 of 2", "1 cut by faults")
    said = figures(sample.failed_run())["Horizons modeled"]
    assert said == ("0 of 2", "1 cut by faults, 1 did not converge, 1 not modeled")


def test_the_largest_throw_is_that_of_a_horizon_that_converged() -> None:
    failed = sample.failed_run().horizons[0].subdomains[0].termination
    open_ = sample.cut_result("Top A", throw=138.0, termination=failed)
    final = sample.cut_result("Top B", throw=90.0)
    both = replace(sample.run_result(), horizons=(open_, final))
    assert figures(both)["Largest throw"] == ("90 m", "F1 on Top B")
    alone = replace(both, horizons=(open_,))
    assert figures(alone)["Largest throw"] == ("138 m", "F1 on Top A, not final")


def test_the_map_marks_where_it_did_not_converge() -> None:
    result = sample.failed_run().horizons[0]
    axes = map_figure(result, FRAME).axes[0]
    assert axes.get_title(loc="left").endswith("not converged (at the red cross)")
    (cross,) = [line for line in axes.lines if line.get_marker() == "P"]
    t = result.subdomains[0].termination
    assert (cross.get_xdata()[0], cross.get_ydata()[0]) == (t.x, t.y)
    calm = map_figure(sample.cut_result(), FRAME).axes[0]
    assert "converged" not in calm.get_title(loc="left")
    assert not [line for line in calm.lines if line.get_marker() == "P"]


def test_settings_tell_the_step_and_gamma_that_were_used() -> None:
    rows = dict(parameters(sample.run_result(), FRAME))
    assert rows["on Top A"] == "Step 100 m; rebuilt within 400 m around F1 (gamma)"
    assert rows["on Top B"] == "Step 100 m"
    assert rows["graben"]


def test_throws_that_are_not_final_are_marked_in_the_table_of_faults() -> None:
    failed = sample.failed_run()
    row = '<td class="what">Top A (not final)</td>'
    assert row in report_html(failed, {})
    assert row not in report_html(sample.run_result(), {})


def test_what_to_do_is_promised_where_something_did_not_converge_alone() -> None:
    said = "What to do about these stands under To look at."
    assert said in report_html(sample.failed_run(), {})
    assert said not in report_html(sample.run_result(), {})


def test_faults_that_repair_made_are_counted_apart() -> None:
    result = sample.run_result()
    assert sizes(result) == "2 horizons, 1 fault"
    split = replace(
        result, repaired=replace(result.repaired, faults=(sample.fault(), sample.fault("F1 (2)")))
    )
    assert sizes(split) == "2 horizons, 1 fault (2 after repair)"
    assert "2 horizons, 1 fault (2 after repair), profile" in report_html(split, {})
    assert "Model two horizons: 2 horizons, 1 fault (2 after repair), profile" in run_summary(split)


def test_moves_far_below_the_tolerance_are_told_as_that() -> None:
    result = sample.run_result()
    first = replace(result.horizons[0].subdomains[0], mean_displacement=6.78e-5, mean_deviation=0.0148)
    horizon = replace(result.horizons[0], subdomains=(first,))
    changed = replace(result, horizons=(horizon, result.horizons[1]))
    row = subdomain_rows(changed, None, FRAME)["subdomains"][0]
    assert (row["displacement"], row["deviation"]) == ("< 0.0005", "0.0148")  # the tolerance is 0.085


def test_one_subdomain_is_not_many() -> None:
    assert figures(sample.run_result())["Converged"] == ("1 of 1", "subdomain, in at most 4 iterations")


def test_defaults_are_told_as_the_keys_tell_them() -> None:
    given = sample.run_result()
    p = given.model.parameters.model_copy(update={"gamma": None})
    rows = dict(parameters(replace(given, model=replace(given.model, parameters=p)), FRAME))
    assert rows["gamma"] == f"default: {meaning(Parameters, 'gamma')[1]}"
    assert rows["length"] == f"default: {meaning(Parameters, 'length')[1]}"
    assert dict(parameters(given, FRAME))["gamma"] == "400 m"
