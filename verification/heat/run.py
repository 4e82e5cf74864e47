"""The heat equation against closed forms, manufactured solutions, a slit; the slab it cools."""

import numpy as np

from staffa.heat.thermal_body import Conduction, Dirichlet, Insulating
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ready_case
from verification.heat.slit import END, HEIGHT, START, Slit, slit

CLOSED_FORM, MADE_UP = "closed form", "manufactured solution"


def heat() -> Found:
    """Errors, orders, overshoot."""
    from fem import test_heat as tests

    figures = [
        _figure(f"{name}, {cells}: error over dT", CLOSED_FORM, 0.0, error, 0.005)
        for name in tests.CLOSED
        for cells in ("quadrilateral", "triangle", "unstructured")
        for error in [tests.worst_error(name, cells)]
    ]
    for k, cells, size, steps in tests.MADE_UP:
        errors = [tests.made_up(k, cells, size, h) for h in steps]
        turned = ", k turned by 30 degrees" if k[0][1] else ""
        order = float(tests.rates(errors, steps)[-1])
        what = f"order in h, {len(size)}-D, {cells}, orthotropic{turned}"
        figures.append(_figure(what, MADE_UP, 2.0, order, 0.15))
    figures.append(_figure("order in the time step", MADE_UP, 2.0, tests.time_rate(), 0.1))
    for cells, size in (
        *((cells, (0.2, 0.2)) for cells in ("quadrilateral", "triangle", "unstructured")),
        *((cells, (0.1, 0.1, 0.1)) for cells in ("hexahedron", "tetrahedron", "unstructured")),
    ):
        what = f"warmer than at the start after a quench, over dT, {len(size)}-D, {cells}"
        figures.append(_figure(what, "nothing is", 0.0, tests.warming(size, cells), 0.01))
    rows = [
        "Where the mesh does not resolve what is asked of it:",
        "",
        "| | over dT |",
        "| --- | --- |",
    ]
    for cells_long in (1, 2, 3):
        error = tests.worst_error("half-space", "quadrilateral", since=cells_long * 0.02)
        rows.append(
            f"| error of the half-space from sqrt(kappa t) = {cells_long} h on | {error:.2%} |"
        )
    for ratio in (4, 10):
        for cells in ("quadrilateral", "triangle"):
            warmer = tests.warming((0.2, 0.2), cells, 1.0, ratio)
            rows.append(
                f"| warmer after a quench, {cells}, conductivities 1 to {ratio} | {warmer:.2%} |"
            )
    return Found(figures=figures, text="\n".join(rows))


def _figure(what: str, source: str, expected: float, measured: float, tolerance: float) -> Figure:
    return Figure(
        what=what, source=source, reference=expected, measured=measured, tolerance=tolerance
    )


def smeared(ell: float, residual: float = 1e-5) -> Slit:
    """The plate with a crack in place of the slit, four cells an ell, in its steady state."""
    from support.heated import Heated, broken_layer, tensor

    n = round(4 / ell)
    n += 1 - n % 2  # the crack in the middle of a row of cells
    ends = (Dirichlet(side="bottom", T=lambda x, t: 0.0), Dirichlet(side="top", T=lambda x, t: 1.0))
    conduction = Conduction(
        k=tensor(1.0, 1.0),
        rho_c=1.0,
        initial=lambda x: x[1].copy(),
        sides=ends,
        cracks=Insulating(residual=residual),
    )
    body = Heated((1.0, 1.0), 1 / n, conduction)
    across = np.maximum(np.abs(body.x[1] - HEIGHT) - 0.5 / n, 0.0)
    beyond = np.maximum(np.maximum(START - body.x[0], body.x[0] - END), 0.0)
    body.alpha[:] = broken_layer(np.hypot(across, beyond), ell=ell, h=0.0)
    body.to(100.0)
    flow = body.to(101.0).entered["top"]
    return Slit(flow=flow, x=body.x[:2].T, T=body.T + body.x[1])


APART = 0.16  # of the points between which the jump is measured: beyond 2 ell of the largest ell


def cracks() -> Found:
    """Resistance of an insulating crack, jump across it, heat that a fluid-filled one takes up."""
    from fem import test_heat as tests

    figures, rows = [], ["| ell | h | residual | R k | h/residual |", "| --- " * 5 + "|"]
    for ell, cells in ((0.04, 2), (0.04, 4), (0.04, 8), (0.02, 4), (0.01, 4)):
        for residual in (1e-2, 1e-4, 1e-6):
            measured, expected = tests.resistance(ell, cells, residual)
            h = 1 / (round(cells / ell) + 1)
            rows.append(
                f"| {ell:g} | {h:.4g} | {residual:g} | {measured:.4g} | {h / residual:.4g} |"
            )
            figures.append(
                Figure(
                    what=f"R k, ell = {ell:g} = {cells} h, residual {residual:g}",
                    source="cells in series",
                    reference=expected,
                    measured=measured,
                    tolerance=2e-3,
                    relative=True,
                )
            )
    reference, before = slit(400), np.inf
    for ell in (0.08, 0.04, 0.02, 0.01):
        found = smeared(ell)
        jump, flow = found.jump(APART) / reference.jump(APART), found.flow / reference.flow
        source = "a real slit, h = 1/400; the error falls with ell"
        allowed = min(0.08, before)
        figures.append(_figure(f"jump over the slit's, ell = {ell:g}", source, 1.0, jump, allowed))
        figures.append(_figure(f"flow over the slit's, ell = {ell:g}", source, 1.0, flow, 0.02))
        before = abs(jump - 1)
    for film in (1e5, 300.0, 150.0, 30.0, 10.0):
        worst = max(tests.uptake(film), key=lambda ratio: abs(ratio - 1))
        what = (
            f"heat taken up by a fluid-filled crack, h ell/k = {film * 0.02 / tests.K:.3g}: worst"
        )
        figures.append(_figure(what, "two faces, closed form", 1.0, worst, 0.05))
    return Found(figures=figures, text="\n".join(rows))


# Both temperatures are those of the mesh from sqrt(kappa t) = 3 h on, so that the run starts there.
SLAB = (
    "time.tau={start=0.06,stop=0.36,steps=16}",
    "output.at=[0.1, 0.2, 0.36]",
)
BY_HEAT = (
    'temperature={profile="heat", face="bottom"}',
    "heat={initial=0.0, bottom={T=-54.0}}",
)


def slab() -> list[Figure]:
    """The paper's slab cooled by the heat equation and in closed form: energies, cracks, cost."""
    closed = ready_case("slab", "heat-slab-closed", 'temperature.profile="slab"', *SLAB)
    heated = ready_case("slab", "heat-slab", *BY_HEAT, *SLAB)
    pairs = list(zip(closed.steps, heated.steps, strict=True))
    worst = max(abs(b.energies.total / a.energies.total - 1) for a, b in pairs)
    figures = [_figure("total energies, largest difference", CLOSED_FORM, 0.0, worst, 0.005)]
    last = [run.steps[-1].measures for run in (closed, heated)]
    for one, other in zip(*(m.sections for m in last if m), strict=True):
        what = f"cracks crossing y = {one.height:g} at tau = 0.36"
        figures.append(_figure(what, CLOSED_FORM, one.cracks, other.cracks, 0.0))
    tips = [np.array([tip.position for tip in m.tips]) for m in last if m]
    nearest = np.linalg.norm(tips[0][:, None] - tips[1][None], axis=2).min(axis=1)
    shared, count = int((nearest <= heated.manifest.ell).sum()), len(tips[0])
    figures.append(_figure("tips", CLOSED_FORM, count, len(tips[1]), 0.0))
    what = "of these within ell of one of the other run"
    figures.append(_figure(what, CLOSED_FORM, count, shared, 0.1 * count))
    heats = [step.heat for step in heated.steps]
    share = sum(h.seconds for h in heats) / sum(step.seconds for step in heated.steps)
    figures.append(_figure("heat's part of the time", "asked for", 0.0, share, 0.1))
    balance = max(h.imbalance for h in heats)
    figures.append(_figure("heat entered against stored", "conserved", 0.0, balance, 1e-8))
    return figures


CHECKS = {
    "heat": Check(
        title="The heat equation",
        text=(
            "Three kinds of figures: errors over the drop from sqrt(kappa t) = 3 h on; orders of "
            "the root mean square error with Dirichlet, Neumann and Robin conditions and a source; "
            "warming of a quenched corner. Nothing should get warmer than it was: capacities are "
            "lumped, and substeps start as short as their error asks. Some of Gmsh's tetrahedra "
            "are obtuse; of the ready cases, `cylinder-mantle` alone has them with heat."
        ),
        measure=heat,
    ),
    "heat-cracks": Check(
        title="Heat and cracks",
        text=(
            "A crack is a layer of broken cells with AT1's profile beside it. An insulating crack "
            "multiplies the conductivity by 1 - alpha^16 + residual. R k, the crack's resistance "
            "times the rock's conductivity, is h/residual to some percent. Heat flows around the "
            "crack of a plate: mean jump between points 0.16 apart on both sides, and flow through "
            "the plate. A fluid-filled crack takes up heat: in intervals from sqrt(kappa t) = 2 "
            "ell to a quarter of the spacing, ell = 4 h; the worst of seven intervals."
        ),
        measure=cracks,
    ),
    "heat-slab": Check(
        title="The paper's slab by the heat equation",
        text=(
            "The ready case `slab` from tau = 0.06 on, where sqrt(kappa t) is 3 h. At the first "
            "time of the case, tau = 0.02, sqrt(kappa t) is h and nucleation is not resolved: from "
            "there the two runs may differ."
        ),
        measure=slab,
    ),
}
