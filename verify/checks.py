"""What is verified, by name; each in a module of its own."""

from arrays import array, doubling
from columns import columns
from conduction import cracks, heat, slab
from energies import energies
from far_side import far_side
from figures import Check
from grain import grain
from injection import injection
from layers import layers
from neighbors import neighbors
from onset import onset
from pairs import pairs
from quench import quench
from saddles import saddles
from second_order import second_order
from slabs import against_bahr, convergence, growth
from solid import bars, pulled_disc
from squeezed import squeezed
from surfing import on_a_side, surfing
from toughness_direction import toughness_direction

CHECKS = {
    "heat": Check(
        title="The heat equation",
        text="Errors from sqrt(kappa t) = 3 h on, over the drop; orders of the root mean square "
        "error with held, flux and film sides and a source; how much warmer a quenched corner gets "
        "than it was, which nothing should: capacities are lumped, and steps begin as short as "
        "their error asks. Some of Gmsh's tetrahedra are obtuse; of the ready cases, "
        "`cylinder-mantle` alone has them with heat.",
        measure=heat,
    ),
    "heat-cracks": Check(
        title="Heat and cracks",
        text="A crack is a layer of broken cells with AT1's profile beside it. What hinders heat "
        "is 1 - alpha^16 + residual: R k, the crack's resistance times the rock's conductivity, is "
        "h/residual to some percent. Across a plate whose crack heat goes around: mean jump "
        "between points 0.16 apart on both sides, flow through the plate. A crack full of fluid: "
        "heat taken up in intervals from sqrt(kappa t) = 2 ell to a quarter of the spacing, "
        "ell = 4 h; the worst of seven intervals.",
        measure=cracks,
    ),
    "heat-slab": Check(
        title="The paper's slab by the heat equation",
        text="The ready case `slab` from tau = 0.06 on, where sqrt(kappa t) is 3 h. At its own "
        "first time, tau = 0.02, sqrt(kappa t) is h and nucleation is not resolved: from there the "
        "two need not take the same way.",
        measure=slab,
    ),
    "quench": Check(
        title="Quenched alumina",
        text="A strip of 6 mm of `ceramic-strip`: cracks as deep as each depth, by their sharp "
        "tips, and the spacing at which an even array in a half-space doubles.",
        measure=quench,
        kept="quench.json",
    ),
    "injection": Check(
        title="Cracks that a fluid drives",
        text="A crack in a large plate, and a disc in a large block, filled by volume, "
        "on Gmsh's cells, fine where the crack runs.",
        measure=injection,
        kept="injection.json",
    ),
    "solid-bar": Check(
        title="A bar in three dimensions",
        text="The ready case `bar` with a square section, 0.3 x 0.3, and cells of 0.04; it is "
        "weaker by 0.5 % in the middle where it is to break. Half width: mean over the vertices "
        "of what their damage says by the exact profile.",
        measure=bars,
    ),
    "solid-disc": Check(
        title="A disc-shaped crack under a remote stress",
        text="A quarter of a large block whose two ends are pulled by a stress that grows by 2 % "
        "of the critical one a step, Gmsh's cells; the crack's radius is told by what it adds to "
        "the stored energy.",
        measure=pulled_disc,
        kept="solid.json",
    ),
    "second-order": Check(
        title="Uniqueness and stability",
        text="Eigenvalues on the space and on the cone, against closed forms. Tolerances are "
        "fractions of the reference.",
        measure=second_order,
    ),
    "saddles": Check(
        title="Uniform rock, without a seed",
        text="A slab and a block of rock that is the same everywhere, cooled evenly from one face "
        "(`verify/uniform-slab.toml`). Alternate minimization alone stays on the state that is "
        "even along the face, which is a saddle. The second-order test of each step finds that, "
        "leaves it, and keeps the lowest state beside it.",
        measure=saddles,
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
        "(`measure/tip.py`); nothing else does. Half height of the plate: 8 ell. "
        "A crack on a plane of symmetry breaks cells on both sides of it and costs more: "
        "cases with such cracks take their Gc from here. Cost: over Gc and the discrete toughness.",
        measure=lambda: [*surfing("AT1", (4, 8)), *surfing("AT2", (4,)), *on_a_side()],
    ),
    "toughness-direction": Check(
        title="A crack of rock that is tougher one way turns",
        text="A plate whose ends are held, and a cold front that moves up it from a straight "
        "notch; the crack follows. Steady, front and crack release the same energy in each unit "
        "of height wherever they are, and pay Gc sqrt(n . A n)/cos(theta) for it, "
        "n = (cos(theta), sin(theta)): least at tan(theta) = -A_xy/A_yy. As nothing depends on x, "
        "the force on the tip along x is zero, which is the same condition: the crack that grows "
        "finds this angle, whatever the stiffness. Rocks: toughness across the first axis and "
        "across the second, the angle of the first axis to x. Angles from y to the left, by a line "
        "through the vertices with alpha > 0.9; unstructured cells of ell/4, width of the plate "
        "20 ell. Two of the rocks are mirror images, on one mesh. In rock that is the same in all "
        "directions 2.5 degrees more cost 0.1 %, less than what uneven cells do to the toughness.",
        measure=toughness_direction,
    ),
    "array-fixed": Check(
        title="An even array of cracks, section held",
        text="The case `array` against sharp cracks, as far as the first doubling. Tolerance: the "
        "larger of ell = 0.013 and 3 %.",
        measure=lambda: array("fixed"),
    ),
    "array-free": Check(
        title="An even array of cracks, section free to stretch and bend",
        text='The same with `supports.section = "free"`.',
        measure=lambda: array("free"),
    ),
    "doubling": Check(
        title="Every other crack stops",
        text="`verify/two-cracks` (section held): cracks on two planes of symmetry. a: length at "
        "which the slower one stops, tau: when it got there. Then the same with both alike: "
        'alternate minimization alone lets them go on together, `solver.stability = "follow"` '
        "finds that this is no longer stable, and leaves along the mode; the default tests for a "
        "way down. `verify/four-cracks` goes "
        "on to the second doubling. Tolerances are fractions of the reference.",
        measure=doubling,
    ),
    "pairs": Check(
        title="Two cracks, one a little tougher: what their arrest depends on",
        text="Cracks on two planes of symmetry, as in `two-cracks`, with walls that leave only "
        "their ways to break; the tougher one stops. h = ell/4.15 but in one run. Half the step "
        "of tau, or a hundredth of the minimization's tolerances (not kept), changes the arrest "
        "by less than 1e-5; halving h by 0.7 %. The arrest comes early, by the same amount "
        "whatever the contrast: the loss of stability itself is early. What remains is of first "
        "order in ell; the value at ell = 0 is that of a parabola through three. The body is 0.3 "
        "deep, to be cheap, and sharp cracks in it stop 1.6 % short of those in one 1 deep "
        "(0.1347, tau 0.0997). The far side counts that much while the cold is far from it: in "
        "a body 0.22 deep sharp cracks stop at 0.1175, those of ell = 0.0022 at 0.1177 (not kept).",
        measure=pairs,
        kept="pairs.json",
    ),
    "energies": Check(
        title="Energy against tau, minimized in three ways",
        text="Two bodies: a slab cooled little beyond what starts damage, where the first crack "
        "jumps to a finite length, and two cracks of an array that are alike. Where a way first "
        "differs from alternate minimization alone, its energy must be lower.",
        measure=energies,
    ),
    "slab-growth": Check(
        title="The paper's slab, free ends: lengths at the measured spacing",
        text="Half of the slab (a plane of symmetry), ell = 0.013, cells of ell/4, seed 1: cracks "
        "that are deeper at the next step, their mean spacing and depth (of sharp tips). They are "
        "as long as those of an even array until four of them stop at tau = 0.17. From then on "
        "they are shorter, by 10 % at first and by 5 % at tau = 0.29: at first as long as in an "
        "even array of all eleven, later between that and one of those that grow, since the cracks "
        "that stopped still shield the others and do not count in the spacing.",
        measure=growth,
        kept="slabs",
    ),
    "slabs": Check(
        title="The paper's slab: regularization, meshes, rocks",
        text="Half slabs, section `stretch`, at tau = 0.30. Tolerance: one crack, or 15 %.",
        measure=convergence,
        kept="slabs",
    ),
    "bahr": Check(
        title="The paper's slab beside Bahr's",
        text="Section `stretch`, ell = 0.026, the one of the three whose cracks start as far apart "
        "as Bahr's. Tolerance: how far the paper's own run is from Bahr's number. With smaller "
        "ell cracks start closer, and the generations are others: the table of arrests under "
        "`slabs` holds each against sharp cracks of its own spacing.",
        measure=against_bahr,
        kept="slabs",
    ),
    "squeezed": Check(
        title="The paper's slab, squeezed",
        text="A piece of the slab of 1 x 1, rollers left and right, ell = 0.04 = 3 h, compressed "
        "along the face before it is cooled by s times the thermal stress of the face, E expansion "
        "dT. All three have the no-tension split, also s = 0, whose default would be none: so that "
        "they differ in s alone; for the same split, which is slow where many cracks are pressed "
        "shut, cracks keep 1e-5 of the stiffness. Depths are those of sharp tips; spacing: width "
        "over all cracks. Length: of all cracks, by energy, the damaged layer under the face "
        "included. What was expected, fewer and shorter cracks, holds at depth and early; cracks "
        "that are shorter at a given tau have not yet come to where every other one stops, and "
        "of the shallow ones there are then more. s = 0 and 0.25 were run by a version that ended "
        "displacements early between sweeps, which the audit noticed; a later one without it had "
        "the same energies, to six digits, up to tau = 0.1 of s = 0.25, and no remarks.",
        measure=squeezed,
        kept="squeezed.json",
    ),
    "grain": Check(
        title="The paper's slab, random toughness",
        text="A piece of the slab of 1.5 x 0.5 with free ends, ell = 0.04 = 3 h, at "
        "tau = 0.4 of its own depth (0.2 of the paper's); lognormal toughness of correlation "
        "length 2 ell, ten seeds for each coefficient of variation, with standard errors of the "
        "mean; without variation every seed gives the same rock, whose cracks start from the ends. "
        "The more the toughness varies, the farther apart and the deeper the cracks are. Depths "
        "of sharp tips. That one seed gives one rock "
        "on 1, 2 and 3 ranks is tested (`tests/fem/test_rock.py`).",
        measure=grain,
        kept="grain.json",
    ),
    "far-side": Check(
        title="Deep rock holds what is cooled",
        text="`verify/strip.toml`, a cut through the ready case `brick`, 20 times as long as it is "
        "deep: its far side clamped, in place of deeper rock, or free. Free, the strip is a bar "
        "between its ends, which one crack through it unloads. ell0 counts with the discrete "
        "toughness. Cracks at the least depths are those of nucleation.",
        measure=far_side,
    ),
    "columns": Check(
        title="Columns",
        text="The ready case `brick`, and the same twice as wide in both directions, several seeds "
        "each. Areas are means in which a cell at a roller "
        "counts half, and one in a corner a quarter; the diameter is that of the circle of this "
        "area, the spacing area over length of the cracks. Both are held against parallel cracks, "
        "at the depths at which cracks have arrived. Halves and quarters added up, a single block "
        "has one and a half to three whole cells there, a doubled one eight to fourteen: we take "
        "it that walls count for more in the narrow one, and hold the other against theory.",
        measure=columns,
        kept="columns.json",
    ),
    "layers": Check(
        title="Cracks that meet another layer",
        text="`verify/layered`: a slab of severity 12, ell = 0.04 = 3 h, at tau = 0.5; from y = "
        "0.28 on an upper layer whose E and Gc are these times those of the lower one, and below "
        "it, from y = 0.2 on, what may be a weak seam. A crack crosses if its sharp tip is more "
        "than 1.5 ell beyond the upper layer's face, turns if more than 4 ell of it lie along "
        "that and the seam, and otherwise stops there if its tip is within 1.5 ell of it: also in "
        "uniform rock, where it would stop there anyway.",
        measure=layers,
        kept="layers.json",
    ),
    "neighbors": Check(
        title="Two cracks under cooling",
        text="`verify/neighbors`: a body of 0.5 x 1 cooled from below, severity 6, ell = 0.03 = "
        "3 h. A crack from the cooled face that is alone; one beside another that is a little "
        "shorter; one below another that is not in line with it; one below another that is.",
        measure=neighbors,
        kept="neighbors.json",
    ),
}
