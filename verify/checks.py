"""What is verified, by name; each in a module of its own."""

from arrays import array, doubling
from figures import Check
from onset import onset
from second_order import second_order
from surfing import surfing

CHECKS = {
    "second-order": Check(
        title="Uniqueness and stability",
        text="Eigenvalues on the space and on the cone, against closed forms. Tolerances are "
        "fractions of the reference.",
        measure=second_order,
    ),
    "onset": Check(
        title="The first cracks of a cold face, with AT1",
        text="When a layer of damage under the face stops being the only one, and into which "
        "wavelength it breaks: by the smallest eigenvalue of cells half a wavelength wide, and by "
        "the bands that grow from 0.1 % of noise in the toughness, mean of two seeds. Bands are "
        "not cracks yet: these follow later, out of most of them. The theory gives a range for "
        "all dT/dT_c from 3 on; the reference is its middle, and the tolerance 15 % of that. The "
        "layer of the same dT/dT_c, wave by wave, is a reference of its own. Tolerances are "
        "fractions of the reference.",
        measure=onset,
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
