"""Models for the outputs of a check: they pass, fail, and have names made to break a format."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.demo import build
from graben.finding import CheckResult, Finding, Profile, Status
from graben.model import Model
from graben.pipeline import Examination
from graben.surface import Surface
from tests.models import model_of_demo
from tests.zoo import FAILING
from tests.zoo.shapes import F60, MIDDLE, dipping, faults, level, moved_vertex

EVIL = (
    "<b>x",
    "a\"b'c & d",
    "\U0001f469\u200d\U0001f52c fault",
    "n" * 300,
    "[bold]",
    "[/red] :smile:",
    "esc\x1b[31m\x07",
    "two\nlines\ttab",
    "[here](https://example.org)",
    "{0} %s \\",
    "\u202eedoc",
    "-->]]>",
)
ONE_OF_EACH = tuple({case.check: case for case in FAILING}.values())


def with_sliver(surface: Surface, name: str) -> Surface:
    """The surface under another name with a vertex so near the next that triangles are slivers."""
    vertices = surface.vertices
    return replace(
        moved_vertex(surface, MIDDLE, 0.999 * vertices[MIDDLE + 1] + 0.001 * vertices[MIDDLE]), name=name
    )


def evil_model() -> Model:
    """Faults side by side, each with slivers, with a name that some format could trip over."""
    spread = [with_sliver(F60, name).moved(np.array([0.0, 900.0 * k, 0.0])) for k, name in enumerate(EVIL)]
    return replace(faults(*spread, horizons=[level("[H] <i>")]), name="<m> [bold]&")


MODELS = {
    "passing": lambda: model_of_demo(build("single", step=200.0)),
    "evil": evil_model,
    "depth": lambda: replace(evil_model(), z="depth", unit="ft", crs="EPSG:23031"),
    "no horizon": lambda: faults(dipping(60.0)),
    **{f"zoo {case.check}": lambda case=case: case.model for case in ONE_OF_EACH},
}


def made(result: tuple[Finding, ...], model: Model | None = None) -> Examination:
    """An examination with these findings."""
    return Examination(model or faults(F60), CheckResult(Profile.EXTENDED, result), {}, 1.0, 100.0)


def all_but_pass(examination: Examination) -> list[Finding]:
    return [f for f in examination.result.findings if f.status in (Status.FAIL, Status.WARN)]
