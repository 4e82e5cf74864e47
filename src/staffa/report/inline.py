"""Pictures of a run with their captions, drawn in memory, which a notebook shows as HTML."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from html import escape

import matplotlib
from matplotlib.figure import Figure

from staffa.errors import InputError, StaffaError, choices
from staffa.io.run_directory import Run
from staffa.plot.style import RC, WIDTH, picture_bytes
from staffa.report.captions import caption
from staffa.report.chosen_figures import run_figures
from staffa.report.embedding import embedded_image
from staffa.results.crack_network import networks

DPI = 150  # of a picture in a notebook; twice the pixels of most screens
PIXELS_PER_INCH = 96  # of a page


@dataclass(frozen=True, kw_only=True)
class Pictures:
    """Pictures of a run by name; a notebook shows all of them.

    Attributes
    ----------
    figures : Matplotlib figure of each.
    captions : caption of each.
    skipped : a sentence on each picture, or part of one, that could not be drawn.
    """

    figures: dict[str, Figure]
    captions: dict[str, str]
    skipped: tuple[str, ...]

    def __getitem__(self, name: str) -> Figure:
        """Return one figure, as in `run.plot()["cracks"].savefig("cracks.pdf")`."""
        if name not in self.figures:
            raise InputError(_unknown(name, self.figures))
        return self.figures[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return iter(self.figures)

    def __len__(self) -> int:
        """Return the number of pictures."""
        return len(self.figures)

    def __repr__(self) -> str:
        """Return their names, for a session without pictures."""
        return f"pictures: {', '.join(self.figures) or 'none'}"

    def _repr_html_(self) -> str:
        """Return the pictures with captions, for a notebook."""
        parts = [_shown(figure, self.captions[name]) for name, figure in self.figures.items()]
        parts += [f"<p>not drawn: {escape(reason)}</p>" for reason in self.skipped]
        return "\n".join(parts)


def pictures_of(run: Run, *names: str) -> Pictures:
    """Draw the standard pictures of a run: damage, energies, crack lengths and others.

    Parameters
    ----------
    run : the run, which need not be finished.
    names : names of pictures, like "cracks"; without any, all that the run has numbers for.

    Raises
    ------
    InputError
        The run has no picture of such a name.
    """
    found, unread = networks(run)
    draw, skipped = run_figures(run, found)
    for name in names:
        if name not in draw:
            raise InputError(_unknown(name, draw))
    reasons, figures = [] if names else [*skipped, *unread], {}
    for name in names or draw:
        try:
            with matplotlib.rc_context(RC):
                figures[name] = draw[name]()
        except StaffaError as error:
            reasons.append(f"{name}: {error}")
    captions = {name: caption(name, run.manifest, run.steps) for name in figures}
    return Pictures(figures=figures, captions=captions, skipped=tuple(dict.fromkeys(reasons)))


def _unknown(name: str, known: Iterable[str]) -> str:
    return f"the run has no picture '{name}'; {choices(name, known)}"


def _shown(figure: Figure, text: str) -> str:
    """Return a figure with its caption in HTML."""
    with matplotlib.rc_context(RC):
        address = embedded_image("png", picture_bytes(figure, "png", dpi=DPI))
    width = round(WIDTH * PIXELS_PER_INCH)
    return (
        f'<figure style="margin:0 0 1.2em"><img src="{address}" '
        f'alt="{escape(text)}" style="width:{width}px;max-width:100%;background:white">'
        f"<figcaption>{escape(text)}</figcaption></figure>"
    )
