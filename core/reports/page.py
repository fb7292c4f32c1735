"""One-file pages: what stands in the script and style of each, and what a page shows as a picture."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING

from graben.reports.images import Prints, data_address
from graben.reports.scene import Scene

if TYPE_CHECKING:
    import jinja2
    from matplotlib.figure import Figure

LARGEST_FIGURE = 300_000


@dataclass(frozen=True)
class Picture:
    """A figure in a page: its ``data:`` address, what it shows in words, and its caption."""

    source: str
    alt: str
    caption: str


def picture(figure: Figure, alt: str, caption: str, budget: int, drawing: bool = True) -> Picture:
    """Return a figure as a picture of about ``budget`` bytes; ``drawing`` as of :func:`data_address`."""
    return Picture(data_address(figure, min(budget, LARGEST_FIGURE), drawing), alt, caption)


class Room:
    """What pictures may still take of a page: what one spares, the next may take.

    Parameters
    ----------
    most : int
        Bytes of all pictures.
    count : int
        How many are to come.
    """

    #: A picture may take so many times its even share of what is left.
    GENEROUS = 1.5

    def __init__(self, most: int, count: int) -> None:
        self.left, self.count, self.refused = max(most, 0), count, 0

    def share(self, weight: int = 1) -> int:
        """Return the bytes that the next picture may take, of so many shares."""
        return min(int(self.GENEROUS * weight * self.left / max(self.count, weight)), LARGEST_FIGURE)

    def picture(
        self, prints: Prints, alt: str, caption: str, drawing: bool = True, weight: int = 1
    ) -> Picture | None:
        """Return a figure as a picture, or None where there is no figure or no room for it.

        ``weight`` is the number of shares that it may take; other parameters as of :func:`picture`.
        """
        if prints.known.area is None:
            return None
        source = prints.address(self.share(weight), drawing) or ""
        self.count -= weight
        if len(source) > self.left:
            self.refused += 1
            return None
        self.left -= len(source)
        return Picture(source, alt, caption)


def rendered(template: str, scene: Scene | None, **values: object) -> str:
    """Return a page made of a template and plain values, with the style and the scripts inside.

    Parameters
    ----------
    template : str
        Name of the template.
    scene : Scene or None
        The 3D view; without one the page has no plotly.js.
    **values
        What the template shows; texts are escaped there.
    """
    from markupsafe import Markup
    from plotly.offline import get_plotlyjs

    environment = _environment()
    source = environment.loader.get_source if environment.loader else None
    assert source is not None
    page = environment.get_template(template).render(
        **values,
        version=version("graben"),
        scene=scene,
        colourings=[(k, c["label"]) for k, c in scene.colourings.items()] if scene else [],
        css=Markup(source(environment, "report.css")[0]),
        javascript=Markup(source(environment, "view3d.js")[0]),
        page_script=Markup(source(environment, "page.js")[0]),
        plotly=Markup(get_plotlyjs()),
    )
    return page + "\n"


@cache
def _environment() -> jinja2.Environment:
    """Return what knows the templates; it keeps those that it has compiled."""
    import jinja2

    return jinja2.Environment(
        loader=jinja2.PackageLoader("graben.reports"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
