"""Paper's table 1 with a line of the run: nucleation and arrests, beside the published numbers."""

from collections.abc import Sequence
from itertools import chain

from staffa.geometry.block import face_axis
from staffa.io.run_directory import Run
from staffa.measure.generations import Arrests, arrests
from staffa.records.manifest import Manifest
from staffa.results.published import BAHR, PAPER, SEVERITY, Published
from staffa.results.tables import ABSENT, Table, columns_of

# Beyond this difference in severity the published lengths and times are not comparable.
LIKENESS = 0.02


def table(run: Run) -> Table | None:
    """Return the comparison; None unless the body is 2-D and has about the paper's severity."""
    manifest = run.manifest
    severity = manifest.scales.get("severity")
    if len(manifest.size) != 2 or manifest.face is None or None in manifest.taus:
        return None
    if severity is None or abs(severity / SEVERITY - 1) > LIKENESS:
        return None
    found = run_arrests(run)
    assert found is not None
    most = max(3, len(found.generations))
    names = chain.from_iterable((f"a{k}", f"tau{k}") for k in range(most + 1))
    lines = (BAHR, PAPER, own_line(found, manifest))
    return Table(
        title="Nucleation and arrests, beside published numbers",
        columns=columns_of("", "p", *names),
        rows=tuple(_row(line, most) for line in lines),
        notes=(*definitions(manifest), *_remarks(run, found)),
    )


def run_arrests(run: Run) -> Arrests | None:
    """Return the generations of a run; None without a cooled face."""
    manifest = run.manifest
    if manifest.cooled_side is None:
        return None
    axis = face_axis(manifest.cooled_side, len(manifest.size))
    return arrests(run.steps, axis=axis, ell=manifest.ell, sharp=manifest.sharp)


def definitions(manifest: Manifest) -> tuple[str, ...]:
    """Return definitions of the columns, with the temperature for tau if the run has that."""
    profile = (
        ", so that T = -dT erfc(y/(tau L)) at depth y" if manifest.profile == "half-space" else ""
    )
    return (
        f"tau = 2 sqrt(kappa t)/L{profile}; lengths are over L = "
        f"{manifest.shown.length.text(manifest.L)}, the depth of the body below the "
        f"{manifest.surface}.",
        *GENERATIONS,
    )


GENERATIONS = (
    "p: mean spacing of all cracks of the last step. a0, tau0: median depth and tau of the first "
    "step with at least half of these cracks (and two).",
    "ak, tauk: median depth and tau of arrest of generation k, the shallower half of the cracks "
    "that generation k - 1 left (split at the largest ratio of depths that parts them no worse "
    "than one to two; all of them if the halves differ by less than ell).",
    "Arrest: the first step at which a tip was within ell/2 of its final depth, if a quarter of "
    "its mean speed would have carried it farther than ell/2 since; a generation counts if more "
    "than half of its cracks have stopped.",
)


def tip(manifest: Manifest) -> str:
    """Return a sentence on the point of a crack that counts as its tip."""
    if manifest.tip_reach is None:
        return "Depths are those of the last points above measures.threshold, as they are."
    return (
        f"Depths are those of sharp tips, {manifest.tip_reach / manifest.ell:.3g} ell beyond the "
        f"last points above measures.threshold, as measured on a known moving crack."
    )


def _remarks(run: Run, found: Arrests) -> list[str]:
    manifest, severity = run.manifest, run.manifest.scales.get("severity")
    own = "" if severity is None else f"; this run's is {severity:.3g}"
    remarks = [
        tip(manifest),
        f"p, a0 and tau0 depend on the regularization: here ell/L = "
        f"{manifest.ell / manifest.L:.3g}, h/L = {manifest.h / manifest.L:.3g}.",
        f"The published numbers are for a 5 x 1 slab of severity {SEVERITY:g}{own}. "
        f"Bahr's a2 is .35 in the paper's table and .335 in its text.",
    ]
    if found.left and found.depth is not None:
        remarks.append(
            f"At the last step {remaining(found)}, at a median depth of "
            f"{found.depth / manifest.L:.3g} L."
        )
    return remarks


def remaining(found: Arrests) -> str:
    """Return a phrase on the cracks outside the generations."""
    cracks = "1 crack was" if found.left == 1 else f"{found.left} cracks were"
    if found.growing == 0:
        return f"{cracks} left, and had stopped"
    if found.growing == found.left:
        return f"{cracks} left, still growing"
    return f"{cracks} left, {found.growing} of them still growing"


def own_line(found: Arrests, manifest: Manifest) -> Published:
    """Return a run's line of the table."""
    start, ends = found.nucleation, found.generations
    return Published(
        name="this run",
        spacing=start.spacing / manifest.L if start and start.spacing else None,
        depths=tuple(None if s is None else s.depth / manifest.L for s in (start, *ends)),
        taus=tuple(None if s is None else s.tau for s in (start, *ends)),
    )


def _row(line: Published, most: int) -> tuple[str, ...]:
    pairs = zip(_filled(line.depths, most + 1), _filled(line.taus, most + 1), strict=True)
    return (line.name, _number(line.spacing), *map(_number, chain.from_iterable(pairs)))


def _filled(values: Sequence[float | None], length: int) -> list[float | None]:
    return [*values, *[None] * (length - len(values))]


def _number(value: float | None) -> str:
    return ABSENT if value is None else f"{value:.3f}".rstrip("0")
