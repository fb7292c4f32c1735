"""Figures as data addresses that stand inside a page, with the same bytes each time."""

from __future__ import annotations

import base64
import io
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from graben.reports.style import styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

#: Resolutions tried for pictures that are too large as drawings, dots per inch.
_RESOLUTIONS = (140, 105, 80, 50)
#: Stands for a drawing among them.
_DRAWING = 0
_COLOURS = 256
#: Bytes below which few drawings fit: not worth the time.
_LEAST_DRAWING = 150_000
#: Around a figure, inches.
_PADDING = 0.06
#: The box around each figure that was laid out here, inches.
_BOXES: WeakKeyDictionary[Figure, Bbox] = WeakKeyDictionary()
#: Bytes of a dot of a picture at the very least: spares resolutions that cannot fit.
_LEAST_DOT = 0.04


@styled
def svg_bytes(figure: Figure) -> bytes:
    """Return a figure as SVG without a date."""
    return _saved(figure, "svg", metadata={"Date": None})


@styled
def png_bytes(figure: Figure, dpi: int = _RESOLUTIONS[0]) -> bytes:
    """Return a figure as PNG with a palette: a third of the size, and no visible loss on such drawings."""
    from PIL import Image

    picture = Image.open(io.BytesIO(_saved(figure, "png", dpi=dpi, metadata={"Software": None})))
    buffer = io.BytesIO()
    picture.convert("RGB").quantize(_COLOURS, dither=Image.Dither.NONE).save(buffer, "png")
    return buffer.getvalue()


def data_address(figure: Figure, most: int, drawing: bool = True) -> str:
    """Return a figure as a ``data:`` address of about ``most`` bytes.

    Parameters
    ----------
    figure : Figure
        The figure.
    most : int
        Bytes it should not exceed; the coarsest picture is taken even where it does.
    drawing : bool
        Try a drawing (SVG) first, where ``most`` leaves room for one.
    """
    return Prints(lambda: figure).address(most, drawing) or ""


@dataclass
class Printed:
    """What is known of a figure: its area, square inches, None for none, and its addresses by resolution.

    Resolutions are dots per inch, 0 of a drawing.
    """

    area: float | None
    addresses: dict[int, str] = field(default_factory=dict)


class Prints:
    """A figure as ``data:`` addresses, drawn when one is asked for, and each of them once.

    Parameters
    ----------
    draw : callable
        Returns the figure, or None where there is none.
    known : Printed, optional
        What another one of the same figure has come to: it is not drawn for that again.
    """

    def __init__(self, draw: Callable[[], Figure | None], known: Printed | None = None) -> None:
        self._draw, self._figure = draw, None if known else draw()
        self.known = known or Printed(_area(self._figure))

    def address(self, most: int, drawing: bool = True) -> str | None:
        """Return the address of about ``most`` bytes, or None without a figure; as :func:`data_address`."""
        if self.known.area is None:
            return None
        if drawing and most >= _LEAST_DRAWING:
            text = self._at(_DRAWING)
            if len(text) <= most:
                return text
        # of each square dot at least: one of a coarser picture holds no less
        least = self.known.area * _LEAST_DOT
        for dpi in _RESOLUTIONS:
            if least * dpi**2 > most and dpi > _RESOLUTIONS[-1]:
                continue
            text = self._at(dpi)
            if len(text) <= most:
                break
            least = len(text) / dpi**2
        return text

    def _at(self, dpi: int) -> str:
        """Return the address at a resolution."""
        if dpi not in self.known.addresses:
            figure = self._figure = self._figure or self._draw()
            assert figure is not None
            drawn = svg_bytes(figure) if dpi == _DRAWING else png_bytes(figure, dpi)
            kind = "image/svg+xml" if dpi == _DRAWING else "image/png"
            self.known.addresses[dpi] = _address(kind, drawn)
        return self.known.addresses[dpi]


def _area(figure: Figure | None) -> float | None:
    return None if figure is None else float(figure.get_figwidth() * figure.get_figheight())


def _address(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def _saved(figure: Figure, kind: str, **options: Any) -> bytes:
    buffer = io.BytesIO()
    with warnings.catch_warnings():
        # Names may hold letters that the font lacks; they then stand as boxes.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        layout = figure.get_layout_engine()
        if layout is not None:
            layout.execute(figure)
            figure.set_layout_engine("none")  # laid out once, not again for each resolution
            # The box around it as well: savefig would draw the figure once more to find it.
            _BOXES[figure] = figure.get_tightbbox().padded(_PADDING)
        # What places its axes itself is saved as it stands.
        figure.savefig(buffer, format=kind, bbox_inches=_BOXES.get(figure), **options)
    return buffer.getvalue()
