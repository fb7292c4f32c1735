"""Figures as data addresses that stand inside a page, with the same bytes each time."""

from __future__ import annotations

import base64
import io
import warnings
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from graben.reports.style import styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

#: Resolutions tried for pictures that are too large as drawings, dots per inch.
_RESOLUTIONS = (140, 105, 80, 50)
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
    if drawing and most >= _LEAST_DRAWING:
        text = _address("image/svg+xml", svg_bytes(figure))
        if len(text) <= most:
            return text
    area = float(figure.get_figwidth() * figure.get_figheight())
    for dpi in [r for r in _RESOLUTIONS if area * r**2 * _LEAST_DOT <= most] or _RESOLUTIONS[-1:]:
        text = _address("image/png", png_bytes(figure, dpi))
        if len(text) <= most:
            break
    return text


def _address(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def _saved(figure: Figure, kind: str, **options: Any) -> bytes:
    buffer = io.BytesIO()
    with warnings.catch_warnings():
        # Names may hold letters that the font lacks; they then stand as boxes.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        if figure.get_layout_engine() is not None:
            figure.draw_without_rendering()
            figure.set_layout_engine("none")  # laid out once, not again for each resolution
            # The box around it as well: savefig would draw the figure once more to find it.
            _BOXES[figure] = figure.get_tightbbox().padded(_PADDING)
        # What places its axes itself is saved as it stands.
        figure.savefig(buffer, format=kind, bbox_inches=_BOXES.get(figure), **options)
    return buffer.getvalue()
