"""Style of the pictures, and their output as files."""

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.legend import Legend
from matplotlib.ticker import MaxNLocator

from staffa.io.own_files import write_aside

WIDTH = 7.0  # inches: with DPI 1400 pixels, twice the width of a README's column
DPI = 200

# Okabe and Ito's colors, which differ for every kind of color blindness.
BLACK, BLUE, ORANGE, GREEN, PURPLE = "#1a1a1a", "#0072B2", "#D55E00", "#009E73", "#CC79A7"
SKY, AMBER = "#56B4E9", "#E69F00"
ALARM = "#b3261e"  # of what is wrong, as on pages
GENERATIONS = (BLUE, ORANGE, GREEN, PURPLE, SKY, AMBER)

RC: Any = {
    "font.family": ["DejaVu Sans"],
    "font.size": 8.5,
    "axes.titlesize": 9,
    "axes.labelsize": 8.5,
    "axes.linewidth": 0.7,
    "axes.edgecolor": "#555555",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "xtick.labelcolor": BLACK,
    "ytick.labelcolor": BLACK,
    "text.color": BLACK,
    "text.parse_math": False,  # names of faces and of runs may have dollars in them
    "axes.labelcolor": BLACK,
}


def count_axis(axes: Axes, *, ticks: int = 9) -> None:
    """Let an axis of counts start at 0 with ticks at whole numbers, also if all are 0."""
    axes.set_ylim(0, max(1.0, axes.get_ylim()[1]))
    axes.yaxis.set_major_locator(MaxNLocator(ticks, integer=True))


def new_figure(height: float, *, gap: float = 0.04, width: float = WIDTH) -> Figure:
    """Return an empty white figure.

    Parameters
    ----------
    height : height (inches).
    gap : space above and below each panel (inches).
    width : width (inches).
    """
    layout = ConstrainedLayoutEngine(h_pad=gap)
    return Figure(figsize=(width, height), dpi=DPI, layout=layout, facecolor="white")


def legend_above(axes: Axes, columns: int, handles: Sequence[Artist] | None = None) -> Legend:
    """Put the legend above the axes, where it hides no data.

    Parameters
    ----------
    axes : the panel.
    columns : number of columns of the legend.
    handles : lines of the legend; None for those of the axes.
    """
    return axes.legend(
        handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns,
        borderaxespad=0.2, handlelength=1.6, columnspacing=1.4,
    )  # fmt: skip


def write_picture(path: Path, draw: Callable[[], Figure]) -> Figure:
    """Draw a figure, write it as a PNG, atomically, and return it."""
    with matplotlib.rc_context(RC):
        figure = draw()
        write_aside(path, picture_bytes(figure, "png"))
    return figure


def picture_bytes(figure: Figure, form: str, *, dpi: int | None = None, **settings: Any) -> bytes:
    """Return a figure as the content of a file.

    Parameters
    ----------
    figure : the figure.
    form : "png" or "webp".
    dpi : pixels per inch; None for `DPI`.
    settings : of Pillow, which writes it.
    """
    picture = io.BytesIO()
    FigureCanvasAgg(figure)
    figure.savefig(picture, format=form, dpi=dpi or DPI, pil_kwargs=settings)
    return picture.getvalue()
