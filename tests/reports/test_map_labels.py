"""Names and throws on maps: none over another, and what is left out is counted in the caption."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from matplotlib.text import Text

from graben.finding import Finding, Status, Worst
from graben.model import Model
from graben.modeling.results import Cutoff, HorizonResult
from graben.reports import thinning
from graben.reports.check_map import overview
from graben.reports.map_labels import MARGIN, lettering
from graben.reports.map_parts import bounds
from graben.reports.plan_map import map_figure
from graben.reports.run_figures import RunFigures
from graben.reports.scenery import Scenery
from graben.reports.style import Frame
from tests.models import plane_fault
from tests.reports import sample
from tests.reports.check_models import made

METRES = Frame("m", 1.0)


def crowded(count: int, apart: float, name: str = "Fault") -> HorizonResult:
    """A horizon with faults side by side, each of them a little shorter than the one to its west."""
    result = sample.cut_result()
    (line,) = result.cutoffs
    cutoffs = []
    for k in range(count):
        some, off = slice(k // 2, len(line.s) - k // 2), np.array([apart * (k - count / 2), 0.0, 0.0])
        hanging, foot = line.hanging[some] + off, line.foot[some] + off
        s = line.s[some] - line.s[some][0]
        cutoffs.append(Cutoff(f"{name} {k + 1}", s, hanging, foot, line.throw[some], line.heave[some]))
    object.__setattr__(result, "cutoffs", tuple(cutoffs))
    return result


@pytest.mark.parametrize(("count", "apart"), [(1, 0.0), (6, 500.0), (20, 60.0)])
def test_names_and_throws_keep_apart(count: int, apart: float) -> None:
    result = crowded(count, apart)
    window = bounds(result.surface.vertices[:, :2])
    placed = lettering(result, window)
    names = [w.text for w in placed.written if w.name]
    assert len(names) + placed.names == count
    assert names == [f"Fault {k}" for k in range(1, count + 1) if f"Fault {k}" in names]  # the longest first
    assert names[0] == "Fault 1"
    for a, b in combinations(placed.boxes, 2):
        assert (a[:2] >= b[2:]).any() or (b[:2] >= a[2:]).any()
    margin = MARGIN * max(window[1] - window[0], window[3] - window[2])
    assert (placed.boxes >= np.array(window)[[0, 2, 0, 2]] - margin).all()
    assert (placed.boxes <= np.array(window)[[1, 3, 1, 3]] + margin).all()
    # and so they do with the letters as they are drawn
    figure = map_figure(result, METRES)
    figure.draw_without_rendering()
    drawn = [t for t in figure.axes[0].texts if t.get_text() in {w.text for w in placed.written}]
    assert len(drawn) >= len(placed.written)
    shown = [Text.get_window_extent(t) for t in drawn if t.get_visible()]
    assert not any(a.overlaps(b) for a, b in combinations(shown, 2))


def test_the_largest_throw_of_each_fault_comes_before_others() -> None:
    result = crowded(5, 800.0)
    placed = lettering(result, bounds(result.surface.vertices[:, :2]))
    throws = [w.text for w in placed.written if not w.name]
    assert throws[:5] == ["138"] * 5
    assert "138" not in throws[5:] and len(throws) > 5


def captions(result: HorizonResult) -> list[str]:
    run = replace(sample.run_result(), horizons=(result,))
    figures = RunFigures(run, METRES, {}, (), 10**7)
    return [sketch.caption for sketch in figures._maps(result)]


def test_a_caption_counts_what_is_left_out() -> None:
    result = crowded(30, 40.0, "Fault of a long name")
    placed = lettering(result, bounds(result.surface.vertices[:, :2]))
    assert placed.names > 1 and placed.throws > 1
    first = captions(result)[0]
    assert f"Left out for want of room: {placed.names} names, {placed.throws} throws; in the 3D view" in first
    assert "Numbers along the faults: throw, m." in first
    assert all("Left out" not in caption for caption in captions(crowded(1, 0.0)))


def test_a_caption_says_that_a_map_is_thinned(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "Thinned" not in captions(sample.cut_result())[0]
    monkeypatch.setattr(thinning, "MOST_DRAWN", 2000)
    monkeypatch.setattr(thinning, "_APART", 0.1)
    assert "Thinned for this picture to nodes about 600 m apart" in captions(sample.cut_result())[0]


def test_the_map_of_a_check_leaves_out_what_all_names_share_and_counts_the_rest() -> None:
    names = [f"SAFS-SGPR-{chr(65 + k)} of a long name" for k in range(24)]
    faults = [plane_fault((10.0 * k, -900), (10.0 * k, 900 - 20 * k), name=n) for k, n in enumerate(names)]
    found = Finding("min-dip", Status.WARN, (names[0],), 1, Worst(3.0, "degrees", 0.0, 0.0, -10.0))
    examination = made((found,), Model("cfm", (), tuple(faults)))
    drawn = overview(Scenery.of(examination), {1: found}, {1})
    assert drawn is not None
    texts = [t.get_text() for t in drawn.figure.axes[0].texts]
    written = [t for t in texts if t.endswith("of a long name")]
    assert "A of a long name" in written  # the longest
    assert drawn.names == len(names) - len(written) > 0
    assert drawn.numbers == 0
    assert drawn.words() == (
        " All names begin with SAFS-SGPR-, which is left out. Left out for want of room: "
        f"{drawn.names} names. In the 3D view a fault is named where the pointer rests on it."
    )
