"""The 3D view of a repaired model: its surfaces, the changes, what is left, and the rims before it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from html import escape
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from graben.reports.check_view3d import check_scene, view_space
from graben.reports.check_words import seen
from graben.reports.scene import Group, Scene
from graben.reports.scenery import Scenery
from graben.reports.shapes import Shape, drawable
from graben.surface import Surface

if TYPE_CHECKING:
    from graben.cleaning.ledger import RepairAction
    from graben.finding import Finding

_CHANGED, _BEFORE = "#1F5FA8", "#C0392B"
#: Changes and vertices of rims that are drawn.
_MOST_PLACES, _MOST_RIM = 1_000, 30_000
#: Letters in a line of a hover text.
_LINE = 60


def repair_scene(
    scenery: Scenery,
    actions: Sequence[RepairAction],
    left: Mapping[int, Finding],
    before: Sequence[Surface],
) -> Scene | None:
    """Return the 3D view of a repaired model, or None where there is nothing to see.

    Parameters
    ----------
    scenery : Scenery
        The repaired model.
    actions : sequence of RepairAction
        The ledger.
    left : mapping of int to Finding
        The findings that are left, by their numbers.
    before : sequence of Surface
        The faults that changed, as they were; usable triangles alone.
    """
    scene = check_scene(scenery, left)
    if scene is None:
        return None
    space = view_space(scenery)
    data, groups = list(scene.data), list(scene.groups)

    def add(kind: str, label: str, trace: dict[str, Any]) -> None:
        groups.append(Group(kind, label, (len(data),)))
        data.append(trace)

    by_repair: dict[str, list[tuple[int, RepairAction]]] = {}
    for number, action in enumerate(actions[:_MOST_PLACES], start=1):
        if action.place is not None and drawable(np.array(action.place)):
            by_repair.setdefault(action.action, []).append((number, action))
    for repair, own in by_repair.items():
        marker = {"size": 6, "symbol": "diamond", "color": _CHANGED, "line": {"color": "#FFFFFF", "width": 1}}
        where = f"%{{text}}<br>%{{x}}, %{{y}}, {space.frame.z_name} %{{z}}<extra></extra>"
        points = np.array([a.place for _, a in own])
        text = [_hover(n, a) for n, a in own]
        add("Changes", repair, space.points(repair, points, marker=marker, text=text, hovertemplate=where))
    rims = [line for surface in before if len(surface.triangles) for line in Shape.of(surface).rim]
    lengths = np.cumsum([len(line) for line in rims])
    rims = rims[: int(np.searchsorted(lengths, _MOST_RIM, side="right"))]
    if rims:
        style = {"color": _BEFORE, "width": 4}
        add("Before", "rims", space.lines("rim before the repair", rims, line=style))
    return replace(scene, data=data, groups=groups)


def _hover(number: int, action: RepairAction) -> str:
    words = seen(f"{number} {action.action}: {action.reason}")
    return "<br>".join(escape(line) for line in wrap(words, _LINE, max_lines=6, placeholder=" …"))
