"""The second order of the energy against closed forms."""

from math import pi, sqrt

from verification.common.figures import Check, Figure


def second_order() -> list[Figure]:
    """The bar at onset, and the Rayleigh quotient in the space V and in the cone."""
    from fem.test_stability import onset, rayleigh

    variation = rayleigh(1000)
    space = variation.on_the_space()
    cone = variation.on_the_cone(space)
    variation.destroy()
    theory = "Leon Baldelli and Maurini 2021"
    rows = [
        ("length at which an AT1 bar loses uniqueness, over ell", pi * sqrt(2 / 3), onset(0), 0.02),
        ("length at which it loses stability, over ell", 3.42, onset(1), 0.02),
        ("Rayleigh quotient in the space V", 9.8696, space.value, 1e-3),
        ("Rayleigh quotient in the cone of admissible rates", 86.482, cone.value, 1e-3),
        (
            "length of its minimizer in the cone of admissible rates",
            0.33782,
            float((cone.b > 1e-6).mean()),
            5e-3,
        ),
    ]
    return [
        Figure(
            what=what,
            source="theory" if "AT1" in what or "loses" in what else theory,
            reference=reference,
            measured=measured,
            tolerance=tolerance,
            relative=True,
        )
        for what, reference, measured, tolerance in rows
    ]


CHECKS = {
    "second-order": Check(
        title="Uniqueness and stability",
        text=(
            "Eigenvalues in the space V and in the cone of admissible rates, compared with closed "
            "forms. Tolerances are fractions of the reference."
        ),
        measure=second_order,
    ),
}
