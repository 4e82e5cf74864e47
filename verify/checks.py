"""What is verified, by name; each in a module of its own."""

from arrays import array, doubling
from figures import Check
from second_order import second_order
from surfing import surfing

CHECKS = {
    "second-order": Check(
        title="Uniqueness and stability",
        text="Eigenvalues on the space and on the cone, against closed forms. Tolerances are "
        "fractions of the reference.",
        measure=second_order,
    ),
    "surfing": Check(
        title="A crack that follows a tip",
        text="The whole edge of a plate is moved as by a sharp crack whose tip travels, loaded at "
        "Gc. Where this tip is beyond the damage calibrates the sharp tip of all other runs "
        "(`measure/tip.py`); nothing else does. Half height of the plate: 12 ell (AT1), 20 ell "
        "(AT2).",
        measure=lambda: surfing("AT1", 12) + surfing("AT2", 20),
    ),
    "array-fixed": Check(
        title="An even array of cracks, section held",
        text="The case `array`: the tip where alpha exceeds 0.8, against sharp cracks, as far as "
        "the first doubling; no correction for the smeared tip. Tolerance: the larger of "
        "ell = 0.013 and 3 %.",
        measure=lambda: array("fixed"),
    ),
    "array-free": Check(
        title="An even array of cracks, section free to stretch and bend",
        text='The same with `supports.section = "free"`.',
        measure=lambda: array("free"),
    ),
    "doubling": Check(
        title="Which of two cracks stops, and when",
        text="The case `two-cracks`: toughness 1 % apart, section held. a1: final depth of the "
        "slower crack; tau1: when it was within a cell of it. Tolerances are fractions of the "
        "reference.",
        measure=doubling,
    ),
}
