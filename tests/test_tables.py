"""Tables of a run: as many rows as there is to tell, and the same figures as the values they come from."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd

from graben.finding_table import COLUMNS, findings_table
from graben.tables import (
    cutoffs_table,
    doubts_table,
    iterations_table,
    masked_table,
    misfit_table,
    throws_table,
)
from tests.reports import sample

RUN = sample.run_result(depth=True)


def test_cutoffs_come_in_pairs_with_elevations():
    table = cutoffs_table(RUN)
    (line,) = RUN.horizons[0].cutoffs
    assert len(table) == 2 * len(line.s)
    assert table["side"].tolist() == ["hanging", "foot"] * len(line.s)
    hanging, foot = table[table["side"] == "hanging"], table[table["side"] == "foot"]
    np.testing.assert_array_equal(hanging[["x", "y", "z"]], line.hanging)
    np.testing.assert_array_equal(foot[["x", "y", "z"]], line.foot)
    for column in ("s", "throw", "heave", "type", "node"):
        assert hanging[column].tolist() == foot[column].tolist()
    assert set(table["node"]) == {"tip", "interior"}
    assert set(table["type"]) == {"normal", "none"}
    assert table["dip"].between(60.0, 61.0).all()


def test_throws_and_iterations():
    (row,) = throws_table(RUN).to_dict("records")
    assert (row["horizon"], row["fault"], row["ends"], row["type"]) == ("Top A", "F1", "tip; tip", "normal")
    assert row["ratio"] == abs(row["throw"]) / row["length"]
    table = iterations_table(RUN)
    assert table["iteration"].tolist() == [1, 2, 3, 4]
    assert table["change"].tolist() == list(RUN.horizons[0].subdomains[0].history)


def test_misfit_and_input():
    assert misfit_table(RUN)["fault"].unique().tolist() == ["F1"]
    (row,) = masked_table(RUN).to_dict("records")
    assert row["what"] == "nodes"
    assert len(doubts_table(RUN)) == 0


def test_findings_keep_their_order_and_places():
    table = findings_table(RUN.after)
    assert tuple(table.columns) == COLUMNS
    assert table["check"].tolist() == [f.check for f in RUN.after.findings]
    worst = table.iloc[1]
    assert (worst["status"], worst["value"], worst["unit"]) == ("warn", 24.0, "degrees")
    assert worst["z"] == -2100.0
    assert np.isnan(table.loc[0, "x"])


def test_tables_without_rows_keep_their_columns():
    empty = type(RUN)(**{**vars(RUN), "horizons": ()})
    for table in (cutoffs_table, throws_table, doubts_table, misfit_table, masked_table, iterations_table):
        found = table(empty)
        assert len(found) == 0
        assert "horizon" in found.columns


def test_tables_go_through_csv_and_json_with_any_name(tmp_path):
    run = sample.run_result(sample.EVIL)
    table = cutoffs_table(run)
    table.to_csv(tmp_path / "a.csv", index=False)
    again = pd.read_csv(tmp_path / "a.csv")
    assert set(again["fault"]) == {sample.EVIL}
    np.testing.assert_allclose(again["throw"], table["throw"])
    assert json.loads(table.to_json(orient="records"))[0]["fault"] == sample.EVIL
