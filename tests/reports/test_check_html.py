"""The page of `graben check`: verdict first, every finding in its place, names as text, no network."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from graben.cutgraph import CutGraph, NodeKind
from graben.finding import CheckResult, Element, Finding, Part, Profile, Status, Worst
from graben.model import Fault, Model
from graben.pipeline import Examination, examine
from graben.reports import check_html as page_module
from graben.reports import check_view3d, scene
from graben.reports.check_html import check_html
from graben.reports.check_parts import sized
from graben.reports.check_view3d import check_scene
from graben.reports.scenery import Scenery
from graben.surface import Surface
from graben.validators.registry import known_ids
from tests.reports import sample
from tests.reports.test_html import Page
from tests.zoo import shapes

EVIL = "</script><b>x & $y$"


def crossing(name: str) -> Fault:
    """A vertical fault across the sample's fault."""
    x, y = sample.ORIGIN
    place = lambda i, j: (x + 1000 + 400 * i, y + 3000 + 0 * i, -2400 + 200 * j)  # noqa: E731
    return Fault(shapes.sheet(10, 4, place, name), sample.GAMMA)


def model(first: str = "F1", second: str = "F2", *, depth: bool = False) -> Model:
    return Model(
        "two faults",
        (sample.input_horizon("Top A"),),
        (sample.fault(first), crossing(second)),
        z="depth" if depth else "elevation",
        crs="EPSG:23031",
    )


def graph(of: Model) -> CutGraph:
    y = sample.ORIGIN[1] + np.linspace(1000.0, 5000.0, 21)
    nodes = np.stack([sample.trace(y), y, sample.regional(y)], axis=1)
    kinds = [NodeKind.TIP, *[NodeKind.INTERIOR] * 19, NodeKind.LOOSE]
    edges = np.stack([np.arange(20), np.arange(1, 21)], axis=1)
    return CutGraph("Top A", nodes, [int(k) for k in kinds], edges, np.zeros(20))


def findings(of: Model) -> list[Finding]:
    """A fault alone, a pair with parts, a horizon with a fault, a cycle, one without a place; no finding."""
    first, second = of.faults[0].surface, of.faults[1].surface
    spot = first.vertices[first.triangles[:3]].mean(axis=1)
    x, y = sample.ORIGIN
    line = np.array([[x + 2800, y + 3000, -2300], [x + 3000, y + 3000, -2000], [x + 3200, y + 3000, -1700.0]])
    corners = np.array(
        [[x + 1000, y + 1000], [x + 2000, y + 1000], [x + 1500, y + 2000], [x + 1000, y + 1000]]
    )
    ring = np.c_[corners, np.full(4, -2000.0)]
    parts = (
        Part("proper crossing", 1, tuple(line[1]), 670.0, "m"),
        Part("touching in a point", 1, tuple(line[0])),
    )
    return [
        Finding(
            "degenerate",
            Status.FAIL,
            (first.name,),
            3,
            Worst(0.2, "degrees", *spot[0]),
            f"{first.name} has 3 triangles with an angle below 0.5 degrees.",
            "Remesh <the> surface.",
            repairable=True,
            elements=np.arange(3),
            element=Element.TRIANGLE,
            places=spot,
        ),
        Finding(
            "simplicial-complex",
            Status.WARN,
            (first.name, second.name),
            2,
            Worst(670.0, "m", *line[1]),
            "They cross.",
            "Split them.",
            paths=(line,),
            places=line[:2],
            parts=parts,
        ),
        Finding(
            "trace",
            Status.FAIL,
            ("Top A", first.name),
            1,
            Worst(40.0, "m", *graph(of).nodes[-1]),
            "It ends nowhere.",
            "Extend it.",
            places=graph(of).nodes[-1:],
        ),
        Finding("acyclic", Status.WARN, ("Top A",), 1, None, "A cycle.", "Open it.", paths=(ring,)),
        Finding("anchored", Status.FAIL, ("Top A",), 1, None, "Nothing holds it.", "Hold it."),
        Finding("finite", Status.PASS, message="Coordinates are finite."),
        Finding("junction", Status.SKIPPED, message=f"Not looked at: {first.name}; waits for trace."),
    ]


def examination(of: Model | None = None, said: list[Finding] | None = None) -> Examination:
    """The findings of above in the table's order, and a pass of every other check."""
    of = of or model()
    said = findings(of) if said is None else said
    silent = [Finding(check, Status.PASS) for check in known_ids() if all(f.check != check for f in said)]
    ordered = sorted([*said, *silent], key=lambda f: known_ids().index(f.check))
    result = CheckResult(Profile.EXTENDED, tuple(ordered), of.z_factor)
    return Examination(of, result, {"Top A": graph(of)} if of.horizons else {}, 1.25, 321.0)


@pytest.fixture(scope="module")
def text() -> str:
    return check_html(examination())


@pytest.fixture(scope="module")
def evil() -> str:
    return check_html(examination(replace(model(EVIL, "F2"), name=EVIL)))


def words(page: str) -> str:
    return re.sub(r"\s+", " ", "".join(Page(page).text))


def in_scene(page: str) -> dict:
    return json.loads(page.split('id="scene">')[1].split("</script>", maxsplit=1)[0])


def test_tags_are_closed_and_every_link_arrives(text, evil):
    for page in (text, evil):
        parsed = Page(page)
        assert parsed.open == []
        ids = [attrs["id"] for _, attrs in parsed.tags if "id" in attrs]
        assert len(ids) == len(set(ids))
        targets = [a["href"][1:] for a in parsed["a"] if a["href"].startswith("#")]
        targets += [b["data-finding"] for b in parsed["button"] if "data-finding" in b]
        assert set(targets) <= set(ids)
        assert {f"finding-{k}" for k in range(1, 6)} <= set(ids)


def test_verdict_is_the_first_line_and_every_check_is_named(text):
    body = words(text).split("Skip to the results")[1].strip()
    assert body.startswith("NOT PASSED: 3 checks fail (degenerate, trace, anchored), 2 checks warn")
    for check in known_ids():
        assert f" {check} " in body
    passed = check_html(examination(said=[]))
    assert words(passed).split("Skip to the results")[1].strip().startswith("PASSED")
    assert "Findings" not in words(passed)


def test_each_finding_says_what_where_why_and_what_to_do(text):
    body = words(text)
    for part in ("They cross.", "Split them.", "proper crossing", "670 m"):
        assert part in body
    assert "x 435000.0, y 6783000.0, elevation -2000.0" in body
    assert body.count("Why it matters") == 5
    assert "No single place." in body
    assert "Not looked at: F1; waits for trace." in body
    assert "least angle of a fault's triangle" in body


def test_triangles_are_told_with_their_lines_in_the_file(tmp_path):
    of = model()
    first = of.faults[0].surface
    lined = replace(first, lines=np.arange(len(first.triangles)) + 101, file=tmp_path / "f1.ts")
    of = replace(of, faults=(replace(of.faults[0], surface=lined), of.faults[1]))
    body = words(check_html(examination(of)))
    assert "3 triangles of f1.ts: 0 (line 101), 1 (line 102), 2 (line 103)" in body
    assert str(tmp_path) not in body


def test_depth_models_are_told_in_depth():
    body = words(check_html(examination(model(depth=True))))
    assert "x 435000.0, y 6783000.0, depth 2000.0" in body
    assert "elevation -" not in body


def test_page_asks_nothing_of_the_network(text):
    parsed = Page(text)
    addresses = [a[key] for _, a in parsed.tags for key in ("src", "href", "data", "action") if a.get(key)]
    assert addresses
    assert all(re.match("#|data:", address) for address in addresses)
    style = text.split("<style>")[1].split("</style>")[0]
    assert "url(" not in style
    assert "@import" not in style


def test_names_are_text_everywhere(evil):
    parsed = Page(evil)
    assert len(parsed["script"]) == 4  # plotly.js, the scene, the controls, printing
    assert EVIL in "".join(parsed.text)
    assert "<b>x" not in evil
    view = in_scene(evil)  # parses: the name does not end the script
    spoken = [t["name"] for t in view["data"]]
    spoken += [word for t in view["data"] for word in t.get("text", [])]
    assert any("&lt;b&gt;x" in word for word in spoken)
    assert not any("<b>x" in word for word in spoken)
    assert any(EVIL in p["alt"] for p in parsed["img"])


def test_every_finding_with_a_place_has_a_picture_with_words(text):
    pictures = Page(text)["img"]
    assert len(pictures) == 1 + 4  # the map, and all but the one without a place
    assert all(len(p["alt"]) > 30 and p["src"].startswith("data:image/") for p in pictures)
    for picture in pictures:
        kind, content = picture["src"].removeprefix("data:image/").split(";base64,")
        if kind == "svg+xml":
            assert b"http" not in re.sub(
                rb'xmlns(:\w+)?="[^"]*"|<metadata>.*?</metadata>|<!DOCTYPE[^>]*>',
                b"",
                base64.b64decode(content),
                flags=re.S,
            )


def test_button_names_the_place_in_the_coordinates_of_the_view(text):
    view = in_scene(text)
    # checks that fail come first, so the crossing, a warning, is the last but one
    button = next(b for b in Page(text)["button"] if b.get("data-finding") == "finding-4")
    place = np.array(button["data-place"].split(), dtype=float)
    titles = [view["layout"]["scene"][k]["title"]["text"] for k in ("xaxis", "yaxis")]
    offset = [float(title.split(" − ")[1].split(" ")[0]) for title in titles]
    np.testing.assert_allclose(place + np.array([*offset, 0.0]), [435000.0, 6783000.0, -2000.0], atol=1e-3)
    marker = view["data"][view["spot"]]
    assert marker["visible"] is False
    for k, axis in enumerate(("xaxis", "yaxis", "zaxis")):
        low, high = sorted(view["layout"]["scene"][axis]["range"])
        assert low <= place[k] <= high


def test_same_input_same_bytes_but_for_seconds_and_memory(text):
    assert check_html(examination()) == text
    other = check_html(replace(examination(), seconds=9.87, peak_memory_mb=654.0))
    assert other != text
    assert other.replace("9.87 s; peak memory 654", "1.25 s; peak memory 321") == text


def many(count: int) -> list[Finding]:
    last = findings(model())[4]
    return [replace(last, message=f"No. {k}.", objects=(f"H{k}",)) for k in range(count)]


def test_findings_beyond_the_limit_stand_in_the_table(monkeypatch):
    monkeypatch.setattr(page_module, "_MOST_PARTS", 3)
    page = check_html(examination(said=[*findings(model())[:2], *many(40)]))
    assert "3 of 42 findings have a part of their own" in words(page)
    assert len(Page(page)["article"]) == 3
    assert "No. 39." in words(page)
    assert 'id="finding-42"' in page
    # each check has its turn
    checks = re.findall(r'<section[^>]*aria-labelledby="(check-[\w-]+)"', page)
    assert len(set(re.findall(r'<h4 id="([\w-]+)"', page))) == 3 == len(set(checks)), checks


def test_page_keeps_its_size(monkeypatch, text):
    assert len(text.encode()) < 10_000_000
    bare = len(re.sub(r'src="data:[^"]*"', "", text))
    monkeypatch.setattr(page_module, "_PAGE", bare + page_module._MAP)
    small = check_html(examination())
    assert len(small) < bare + page_module._MAP + 20_000
    assert len(Page(small)["img"]) == 1


def test_texts_without_end_are_cut():
    long = "F" * 5000
    page = words(check_html(examination(said=[replace(findings(model())[4], message=long)])))
    assert "F" * 500 in page
    assert "F" * 700 not in page


def test_places_and_surfaces_that_cannot_be_drawn_are_left_out():
    of = model()
    first = of.faults[0].surface
    vertices = np.array(first.vertices)
    vertices[0], vertices[7] = np.nan, 1e30
    triangles = np.array(first.triangles)
    triangles[3] = [0, 1, 10**6]
    broken = Surface("F1", vertices, triangles)
    nowhere = Surface("F3", np.full((3, 3), np.nan), [[0, 1, 2]])
    collapsed = Surface("F4", np.zeros((3, 3)) + vertices[20], [[0, 1, 2]])
    empty = Surface("F5", np.zeros((0, 3)), np.zeros((0, 3)))
    faults = (Fault(broken), of.faults[1], *(Fault(s) for s in (nowhere, collapsed, empty)))
    place = np.array([[np.nan, 0.0, 0.0]])
    said = [
        Finding(
            "finite", Status.FAIL, (n,), 1, Worst(np.nan, "", np.nan, 0.0, 0.0), "Bad.", "Mend.", places=place
        )
        for n in ("F1", "F3", "F5")
    ]
    said.append(
        Finding(
            "degenerate",
            Status.FAIL,
            ("F4",),
            1,
            Worst(0.0, "degrees", *vertices[20]),
            "Flat.",
            "Mend.",
            elements=np.array([0, 3, -1, 10**7]),
            element=Element.TRIANGLE,
            places=vertices[20:21],
        )
    )
    said.append(replace(findings(of)[0], elements=np.array([0, 3, 5, -1, 10**7])))
    page = check_html(examination(replace(of, faults=faults), [*said, *findings(of)[1:]]))
    assert "NaN" not in page.split('id="scene">')[1].split("</script>", maxsplit=1)[0]
    assert words(page).count("Bad.") == 6


def test_model_without_surfaces_has_a_page():
    page = check_html(examination(Model("nothing"), [Finding("anchored", Status.FAIL, (), message="Empty.")]))
    assert "Empty." in words(page)
    assert "the model" in words(page)
    assert len(Page(page)["script"]) == 1


def test_view_shows_findings_check_by_check_and_switches_them():
    exam = examination()
    numbered = dict(enumerate((f for f in exam.result.findings if f.status in (Status.FAIL, Status.WARN)), 1))
    view = check_scene(Scenery.of(exam), numbered)
    assert [g.label for kind, groups in view.kinds if kind == "Findings" for g in groups] == [
        "degenerate",
        "simplicial-complex",
        "trace",
        "acyclic",
    ]
    covered = [k for g in view.groups for k in g.traces]
    assert covered == list(range(len(view.data) - 1))  # all but the spot
    hovers = [word for t in view.data for word in t.get("text", [])]
    assert any(word.startswith("2 simplicial-complex: They cross.") for word in hovers)


def test_large_models_are_thinned_and_say_so(monkeypatch):
    exam = examination()
    monkeypatch.setattr(check_view3d, "MOST_TRIANGLES", 3_000)
    monkeypatch.setattr(scene, "_SMALL", 100)
    view = check_scene(Scenery.of(exam), {})
    assert "Thinned for this view" in view.note
    monkeypatch.setattr(check_view3d, "MOST_TRIANGLES", 100)
    assert "left out" in check_scene(Scenery.of(exam), {}).note


def test_the_gate_itself_can_be_shown():
    page = check_html(
        examine(shapes.scene(shapes.moved_vertex(shapes.F60, shapes.MIDDLE, (120.0, 10.0, -90.0))))
    )
    assert words(page).split("Skip to the results")[1].strip().startswith(("PASSED", "NOT PASSED"))


def test_sizes_in_words():
    assert sized(0.5, "degrees") == "0.5 degrees"
    assert sized(2.5e6, "m²") == "2.5 km²"
    assert sized(None, "m") == ""


@pytest.mark.parametrize("objects", [("Top A",), ("Top A", "F1")])
def test_picks_are_shown_in_a_section(objects):
    of = model()
    horizon = of.horizons[0]
    points = horizon.surface.vertices
    of = replace(of, horizons=(replace(horizon, picks=points),))
    finding = Finding(
        "horizon",
        Status.WARN,
        objects,
        3,
        None,
        "On the wrong side.",
        "Move them.",
        elements=np.array([1830, 1831, 1832]),
        element=Element.PICK,
        places=points[1830:1833],
    )
    (picture,) = Page(check_html(examination(of, [finding])))["img"][1:]
    assert "section along the dots with the points nearby" in picture["alt"]
