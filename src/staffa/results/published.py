"""Published numbers of the paper's slab (5 x 1, severity 54, one side cooled), with sources."""

from dataclasses import dataclass

SEVERITY = 54.0


@dataclass(frozen=True, kw_only=True)
class Published:
    """One line of the paper's table 1, lengths over L; None for a number that it does not give.

    Attributes
    ----------
    name : source of the numbers.
    spacing : p.
    depths : depths of nucleation (a0), then of the arrests.
    taus : times of nucleation (tau0), then of the arrests.
    """

    name: str
    spacing: float | None
    depths: tuple[float | None, ...]
    taus: tuple[float | None, ...]


# Bahr et al. 1988, case III, as table 1 of the paper quotes it; the paper's text has a2 = .335.
BAHR = Published(
    name="Bahr et al. 1988, case III",
    spacing=0.13,
    depths=(0.06, 0.14, 0.35, 0.45),
    taus=(None, 0.09, 0.23, 0.3),
)
# Bourdin, Knepley, Maurini, "Numerical simulation of reservoir stimulation - a variational
# approach", table 1.
PAPER = Published(
    name="Bourdin, Knepley, Maurini",
    spacing=0.15,
    depths=(0.02, 0.08, 0.33, 0.48),
    taus=(0.02, 0.05, 0.16, 0.25),
)
