"""Names of faults and throws on a structure map: none over another, the longest fault first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray, floats
from graben.cutgraph import NodeKind
from graben.modeling.results import Cutoff, HorizonResult
from graben.reports.along_strike import fitted_name
from graben.reports.map_parts import Window, scale_bar_box
from graben.reports.text_boxes import half_box, is_free
from graben.words import plural

#: Width of the figure, inches, what stands beside the map and what above and below, and limits of its height.
_WIDTH, _BESIDE, _AROUND, _LOWEST, _HIGHEST = 7.2, 1.3, 1.2, 2.2, 9.0
#: Empty space around what is shown, as a share of its larger side.
MARGIN = 0.03
#: A throw below this share of the largest is not written and bears no ticks.
SMALL_THROW = 0.08
#: Letters, points: of names and of throws. Throws stand this share of the larger side apart.
NAME, THROW, _SPACING = 8.5, 7.0, 0.16
_POINTS = 72.0  # to the inch
#: What is kept free around a text, points.
_PADDING = 1.0
#: Half the size of the sign of a tip, exit or junction, points, and the distance of a text from a line.
_SIGN, _OFF = 3.5, 4.0
#: The arrow of north: west, south, east and north as shares of the axes.
_ARROW = (0.92, 0.87, 0.98, 0.98)
#: Where a name is tried along its fault, and a throw further along, as shares of its length.
_ALONG, _FURTHER = (0.5, 0.25, 0.75, 0.1, 0.9), (0.0, -0.04, 0.04)
_SIGNS = (NodeKind.TIP, NodeKind.EXIT, NodeKind.JUNCTION, NodeKind.LOOSE)


@dataclass(frozen=True)
class Written:
    """A text, the place of its middle (x, y), and whether it is the name of a fault."""

    text: str
    place: tuple[float, float]
    name: bool


@dataclass(frozen=True, eq=False)
class Lettering:
    """What is written on a map, the boxes (k, 4) that it takes, and how many names and throws found no room.

    A box is west, south, east and north, model units.
    """

    written: tuple[Written, ...]
    boxes: FloatArray
    names: int
    throws: int

    def words(self) -> str:
        """Return what a caption says of what is left out; empty where nothing is."""
        left = [plural(n, noun) for n, noun in ((self.names, "name"), (self.throws, "throw")) if n]
        if not left:
            return ""
        where = "; in the 3D view a fault is named where the pointer rests on it" if self.names else ""
        return f" Left out for want of room: {', '.join(left)}{where}."


def paper_size(window: Window) -> tuple[float, float]:
    """Return width and height of the figure that shows a window, inches."""
    west, east, south, north = window
    height = float(np.clip((_WIDTH - _BESIDE) * (north - south) / (east - west), _LOWEST, _HIGHEST))
    return _WIDTH, height + _AROUND


def lettering(result: HorizonResult, window: Window) -> Lettering:
    """Return where the names of faults and the throws stand on a map of a window.

    Names come first, that of the longest fault before the others; then the largest throw of each fault, then
    the throws at equal distances from it. Each takes of its positions the free one that hides least of lines.

    Parameters
    ----------
    result : HorizonResult
        The horizon.
    window : (west, east, south, north)
        Part that is shown, model units.
    """
    board = _Board.of(result, window)
    longest: dict[str, Cutoff] = {}
    for cutoff in sorted(result.cutoffs, key=lambda c: -c.s[-1]):
        longest.setdefault(cutoff.fault, cutoff)
    written = []
    for cutoff in longest.values():
        name = fitted_name(cutoff.fault)
        written.append(board.write(name, NAME, _beside(cutoff, board), name=True))
    throws = [(k, *rest) for c in result.cutoffs for k, rest in enumerate(_throws(c, board, result))]
    # the first of every fault before the second of any
    for _, text, places in sorted(throws, key=lambda t: t[0]):
        written.append(board.write(text, THROW, places, name=False))
    names = sum(w is None for w in written[: len(longest)])
    kept = tuple(w for w in written if w is not None)
    return Lettering(kept, board.boxes[board.signs :], names, len(written) - len(kept) - names)


@dataclass(frozen=True, eq=False)
class Way:
    """A cutoff followed in plan: places (k, 2), unit vectors to the right (k, 2), throw and heave (k,)."""

    places: FloatArray
    right: FloatArray
    throw: FloatArray
    heave: FloatArray

    @staticmethod
    def along(cutoff: Cutoff, line: FloatArray, at: FloatArray, reach: float) -> Way:
        """Follow ``line`` (n, 2) to the distances ``at``; directions are of chords of twice ``reach``."""
        way = distances(line)

        def place(distance: FloatArray) -> FloatArray:
            return np.stack([np.interp(distance, way, line[:, k]) for k in (0, 1)], axis=1)

        chord = place(at + reach) - place(at - reach)
        size = np.hypot(*chord.T)[:, None]
        right = chord[:, ::-1] * [1.0, -1.0] / np.where(size > 0, size, 1.0)
        return Way(place(at), right, np.interp(at, way, cutoff.throw), np.interp(at, way, cutoff.heave))


def distances(line: FloatArray) -> FloatArray:
    """Return how far along a polyline (n, 2) each of its points lies."""
    return np.append(0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T)))


@dataclass(frozen=True)
class _Position:
    """A text may stand off ``anchor`` in the unit direction ``way``, with ``gap`` between, model units."""

    anchor: FloatArray
    way: FloatArray
    gap: float


def _frame(window: Window) -> tuple[Window, float, float]:
    """Return a window with its margin, its larger side, and a point on paper in model units."""
    west, east, south, north = window
    extent = max(east - west, north - south)
    margin = MARGIN * extent
    width, height = paper_size(window)
    # both sides have one scale: the tighter of the two
    across, up = (
        (east - west + 2 * margin) / (width - _BESIDE),
        (north - south + 2 * margin) / (height - _AROUND),
    )
    frame = (west - margin, east + margin, south - margin, north + margin)
    return frame, extent, max(across, up) / _POINTS


class _Board:
    """What is taken on a map so far: ``boxes`` (k, 4), the first ``signs`` of them by signs.

    ``frame`` is the window with its margin, ``extent`` its larger side, ``unit`` a point on paper in model
    units, ``lines`` (n, 2) are points of the lines that are drawn.
    """

    def __init__(self, window: Window, boxes: FloatArray, lines: FloatArray) -> None:
        self.frame, self.extent, self.unit = _frame(window)
        self.boxes, self.signs, self.lines = boxes, len(boxes), lines

    @staticmethod
    def of(result: HorizonResult, window: Window) -> _Board:
        """Return the board of a horizon with its signs, the scale bar and the arrow of north."""
        (west, east, south, north), extent, unit = _frame(window)
        kinds, nodes = result.graph.kinds, result.graph.nodes[:, :2]
        ends = (s.termination for s in result.subdomains)
        signs = [(t.x, t.y) for t in ends if t.x is not None and t.y is not None]
        half = _SIGN * unit
        boxes = [
            [x - half, y - half, x + half, y + half] for x, y in [*nodes[np.isin(kinds, _SIGNS)], *signs]
        ]
        boxes.append([*scale_bar_box(window, extent)])
        shares = np.array(_ARROW).reshape(2, 2)
        boxes.append((shares * [east - west, north - south] + [west, south]).ravel().tolist())
        lips = [line[:, :2] for c in result.cutoffs for line in (c.hanging, c.foot)]
        lines = np.concatenate([nodes, *lips])
        return _Board(window, floats(boxes, -1, 4), floats(lines, -1, 2))

    def write(self, text: str, size: float, places: Sequence[_Position], *, name: bool) -> Written | None:
        """Take the free position that hides the fewest points of lines; None where all are taken."""
        half = half_box(text, size, _PADDING) * self.unit
        west, east, south, north = self.frame
        free = []
        for order, p in enumerate(places):
            middle = p.anchor + p.way * (p.gap + _OFF * self.unit + float(np.abs(p.way) @ half))
            box = np.concatenate([middle - half, middle + half])
            if not is_free(box, self.boxes, floats([west, south, east, north])):
                continue
            inside = (self.lines > box[:2]).all(axis=1) & (self.lines < box[2:]).all(axis=1)
            free.append((int(inside.sum()), order, middle, box))
        if not free:
            return None
        _, _, middle, box = min(free, key=lambda f: f[:2])
        self.boxes = np.append(self.boxes, box[None], axis=0)
        return Written(text, (float(middle[0]), float(middle[1])), name)


def _beside(cutoff: Cutoff, board: _Board) -> list[_Position]:
    """Return where the name of a fault may stand: beyond its ends, else beside it."""
    line = _middle(cutoff)
    ahead = line[-1] - line[0]
    ahead /= np.hypot(*ahead) or 1.0
    found = [_Position(line[-1], ahead, _SIGN * board.unit), _Position(line[0], -ahead, _SIGN * board.unit)]
    for share in _ALONG:
        at = np.array([share * distances(line)[-1]])
        way = Way.along(cutoff, line, at, _SPACING * board.extent / 4)
        off = abs(float(way.heave[0])) / 2
        found += [_Position(way.places[0], side * way.right[0], off) for side in (1.0, -1.0)]
    return found


def _throws(cutoff: Cutoff, board: _Board, result: HorizonResult) -> Iterator[tuple[str, list[_Position]]]:
    """Yield the throws that are to be written, the largest first, and where each may stand."""
    line, spacing, largest = _middle(cutoff), _SPACING * board.extent, result.largest_throw
    if largest <= 0:
        return
    total, decimals = distances(line)[-1], max(1 - int(np.floor(np.log10(largest))), 0)
    top = distances(line)[np.argmax(np.abs(cutoff.throw))]
    steps = np.arange(-np.floor(top / spacing), np.floor((total - top) / spacing) + 1)
    for at in top + spacing * steps[np.argsort(np.abs(steps), kind="stable")]:
        x, y = Way.along(cutoff, line, np.array([at]), spacing / 4).places[0]
        west, east, south, north = board.frame
        value = float(np.interp(at, distances(line), cutoff.throw))
        if abs(value) > SMALL_THROW * largest and west <= x <= east and south <= y <= north:
            yield f"{value:.{decimals}f}", _aside(cutoff, line, float(at), board)


def _aside(cutoff: Cutoff, line: FloatArray, at: float, board: _Board) -> list[_Position]:
    """Return where a throw may stand: beside the foot wall, or beyond the hanging wall."""
    places = at + np.array(_FURTHER) * _SPACING * board.extent
    way = Way.along(cutoff, line, places, _SPACING * board.extent / 4)
    return [
        _Position(place, side * right, abs(heave) / 2)
        for side in (-1.0, 1.0)
        for place, right, heave in zip(way.places, way.right, way.heave.tolist(), strict=True)
    ]


def _middle(cutoff: Cutoff) -> FloatArray:
    """Return the middle between both lips in plan, (n, 2)."""
    return floats((cutoff.hanging[:, :2] + cutoff.foot[:, :2]) / 2)
