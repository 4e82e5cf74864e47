"""Energy splits: what they are made of, the strengths that they give, and closed cracks."""

from itertools import product

from staffa.backend.stack import MPI

import numpy as np
import pytest
import ufl
from dolfinx import fem
from scipy.optimize import minimize, minimize_scalar

from staffa.backend.jit import form
from staffa.evolution.march import march
from staffa.evolution.system import build
from staffa.minimize.alternate import support_reactions
from staffa.model.domain import block
from staffa.model.initial_cracks import FlatCrack
from staffa.model.strain import principal_strains
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.damage import LAWS, slope
from staffa.physics.material import lame
from staffa.physics.split import SPLITS, driven_share, is_linear_in_g, is_quadratic_in_strain
from staffa.physics.strained import of_principal
from staffa.records.step import Stop
from support.bodies import body, rock

E, NU = 2.0, 0.3
SIGNS = [np.array(s) for s in product([-1.0, -0.25, 0.4, 0.9], repeat=3)]
ORDERED = sorted({tuple(-np.sort(-s)) for s in SIGNS})
# Splits that take all of the energy of a strain in which nothing is pressed.
OPEN_CRACKS = ("none", "volumetric-deviatoric", "star-convex", "spectral", "no-tension", "contact")
# Splits under which some pressure drives damage in rock without cracks.
UNSAFE = ("none", "volumetric-deviatoric", "star-convex", "spectral")


def density(name: str, principal, g: float) -> float:
    return float(SPLITS[name].density(of_principal(tuple(principal), E=E, nu=NU), g))


def psi(principal) -> float:
    """Undamaged, from its definition."""
    lambda_, mu = lame(E, NU, "solid")
    return lambda_ / 2 * sum(principal) ** 2 + mu * sum(x**2 for x in principal)


@pytest.mark.parametrize("name", SPLITS)
def test_undamaged(name: str) -> None:
    """With all of the stiffness left a split changes nothing."""
    for principal in ORDERED:
        assert density(name, principal, 1.0) == pytest.approx(psi(principal), rel=1e-12)


@pytest.mark.parametrize("name", OPEN_CRACKS)
def test_damage_takes_no_more_than_all_of_the_energy(name: str) -> None:
    """At least g psi is left of each strain; strength-surface adds compliance instead."""
    for principal in ORDERED:
        assert density(name, principal, 0.2) >= 0.2 * psi(principal) * (1 - 1e-12), principal


@pytest.mark.parametrize("name", OPEN_CRACKS)
def test_pulled_apart(name: str) -> None:
    """If nothing is pressed, all of the energy goes with the stiffness."""
    pulled = (0.9, 0.5, 0.1)
    assert density(name, pulled, 0.2) == pytest.approx(0.2 * psi(pulled), rel=1e-12)


@pytest.mark.parametrize("name", SPLITS)
def test_convex(name: str) -> None:
    """The energy between two strains lies below the chord."""
    chosen = np.random.default_rng(3).normal(size=(400, 2, 3))
    for one, other in -np.sort(-chosen, axis=2):
        ends = density(name, one, 0.1) + density(name, other, 0.1)
        assert density(name, (one + other) / 2, 0.1) <= ends / 2 * (1 + 1e-12)


@pytest.mark.parametrize("name", ["none", "volumetric-deviatoric", "star-convex", "spectral"])
def test_plane_stress(name: str) -> None:
    """The strain across the plane is the one that leaves no stress on it while g = 1."""
    for a, b in {(a, b) for a, b, _ in ORDERED}:
        found = minimize_scalar(lambda z, a=a, b=b: psi((a, b, z)), bracket=(-1.0, 1.0), tol=1e-12)
        assert density("none", (a, b), 1.0) == pytest.approx(found.fun, rel=1e-12)
        whole = density(name, -np.sort([-a, -b, -found.x]), 0.1)
        assert density(name, (a, b), 0.1) == pytest.approx(whole, rel=1e-6)


@pytest.mark.parametrize("plane", [True, False])
def test_no_tension_is_the_least_energy_that_cracks_leave(plane: bool) -> None:
    """psi_-(e) = min psi(e - p) over strains p >= 0, by a minimizer with bounds."""
    for whole in ORDERED:
        principal = whole[:2] if plane else whole

        def left(p: np.ndarray, principal=principal) -> float:
            # A strain less an opening need not keep the order of its principal values.
            return density("none", -np.sort(p - np.array(principal)), 1.0)

        bounds = [(0.0, None)] * len(principal)
        found = minimize(left, np.full(len(principal), 0.5), bounds=bounds, tol=1e-14)
        kept = density("no-tension", principal, 0.0)
        assert kept == pytest.approx(found.fun, rel=1e-6, abs=1e-9)


def largest_bend(function, order: int) -> float:
    """Largest difference of this order of a function of an array, over its largest value."""
    values = function(np.linspace(0.05, 0.95, 19))
    return float(np.abs(np.diff(values, order)).max() / np.abs(values).max())


@pytest.mark.parametrize("plane", [True, False])
@pytest.mark.parametrize("name", SPLITS)
def test_the_solvers_are_told_the_truth(name: str, plane: bool) -> None:
    """The energy is linear in g, or quadratic along strains, exactly if they are told so."""
    ends = np.random.default_rng(5).normal(size=(20, 2, 2 if plane else 3))

    def along(ends: np.ndarray, x: np.ndarray) -> np.ndarray:
        strains = -np.sort(-(ends[0] + np.outer(x, ends[1])), axis=1)
        return SPLITS[name].density(of_principal(tuple(strains.T), E=E, nu=NU), 0.3)

    def at(strain: np.ndarray, g: np.ndarray) -> np.ndarray:
        return SPLITS[name].density(of_principal(tuple(-np.sort(-strain)), E=E, nu=NU), g)

    bent = max(largest_bend(lambda g, s=pair[0]: at(s, g), 2) for pair in ends)
    assert is_linear_in_g(SPLITS[name], plane_stress=plane) == (bent < 1e-10)
    bent = max(largest_bend(lambda x, p=pair: along(p, x), 3) for pair in ends)
    assert is_quadratic_in_strain(SPLITS[name], plane_stress=plane) == (bent < 1e-10)


def test_without_a_split_alone_the_energy_is_quadratic_in_the_strain() -> None:
    for plane in (True, False):
        known = {name: SPLITS[name] for name in OPEN_CRACKS}
        assert all(is_linear_in_g(split, plane_stress=plane) for split in known.values())
        linear = {n for n, s in known.items() if is_quadratic_in_strain(s, plane_stress=plane)}
        assert linear == {"none"}


def test_a_law_that_is_even_is_not_yet_quadratic() -> None:
    """The parallelogram law tells."""

    class Even:
        name, isotropic = "even", True

        def density(self, e, g):
            return g * (abs(e.principal.strains[0]) + abs(e.principal.strains[-1])) ** 2

    assert not is_quadratic_in_strain(Even(), plane_stress=True)


@pytest.mark.parametrize(
    ("name", "principal", "share"),
    [
        ("none", (1.0, -NU), 1.0),
        ("volumetric-deviatoric", (1.0, -NU, -NU), 1.0),
        ("spectral", (1.0, -NU, -NU), (1 - NU) * (1 + 2 * NU) / (1 + NU)),
        ("no-tension", (1.0, -NU), 1 - NU**2),
        ("no-tension", (1.0, -NU, -NU), 1 - 2 * NU**2 / (1 - NU)),
    ],
)
def test_what_drives_damage_in_a_pulled_bar(name: str, principal, share: float) -> None:
    """The share of its energy, against closed forms."""
    assert driven_share(SPLITS[name], principal, NU) == pytest.approx(share, rel=1e-9)


# Principal strains of intact rock under pressure alone, by its state of stress.
PRESSED = {
    "uniaxial": ((NU, -1.0), (NU, NU, -1.0)),
    "equal biaxial": ((-1.0, -1.0), (2 * NU / (1 - NU), -1.0, -1.0)),
    "confined": ((0.0, -1.0), (0.0, 0.0, -1.0)),
    "all around": ((-1.0, -1.0), (-1.0, -1.0, -1.0)),
}


@pytest.mark.parametrize("pressed", PRESSED)
@pytest.mark.parametrize("solid", [False, True])
def test_pressure_alone_drives_no_damage_under_the_safe_split(pressed: str, solid: bool) -> None:
    """no-tension, in plane stress and in 3-D; without a split all of the energy drives."""
    strains = PRESSED[pressed][solid]
    assert driven_share(SPLITS["no-tension"], strains, NU) == pytest.approx(0.0, abs=1e-9)
    assert driven_share(SPLITS["none"], strains, NU) == pytest.approx(1.0)


@pytest.mark.parametrize("name", UNSAFE)
def test_no_other_split_is_safe(name: str) -> None:
    """Each lets some pressure drive damage; contact is no-tension where rock is whole."""
    shares = [driven_share(SPLITS[name], strains[1], NU) for strains in PRESSED.values()]
    assert max(shares) > 0.05


TENSORS = {
    "any": np.array([[0.3, 0.2, -0.1], [0.2, -0.4, 0.25], [-0.1, 0.25, 0.7]]),
    "a bar": np.diag([-1.0, 0.3, 0.3]),
    "a bar pulled": np.diag([-0.3, -0.3, 1.0]),
    "all alike": 0.4 * np.eye(3),
    "sheared": np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
    "none": np.zeros((3, 3)),
}


@pytest.mark.parametrize("tensor", TENSORS)
@pytest.mark.parametrize("state", ["plane stress", "plane strain", "solid"])
def test_principal_strains(tensor: str, state: str) -> None:
    """As LAPACK has them, where two are equal too; sums of squares have the right derivative."""
    values = TENSORS[tensor].copy()
    if state != "solid":
        values[:2, 2] = values[2, :2] = 0.0
    if state == "plane stress":
        values = values[:2, :2]
    mesh = block(MPI.COMM_SELF, size=(1.0, 1.0, 1.0), h=1.0, cells="hexahedron").mesh
    space = fem.functionspace(mesh, ("Discontinuous Lagrange", 0, values.shape))
    e = fem.Function(space)
    e.x.array[:] = values.ravel()
    found = principal_strains(ufl.sym(e), state)
    exact = np.linalg.eigvalsh(values)[::-1]
    numbers = [fem.assemble_scalar(form(x * ufl.dx(mesh), mesh.comm)) for x in found]
    assert numbers == pytest.approx(exact, abs=1e-3)  # two alike are told apart by sqrt(1e-7)
    squares = sum(x**2 for x in found)
    # Their sum is e : e, whose derivatives are 2 e and 2.
    way, other = ufl.TestFunction(space), ufl.TrialFunction(space)
    slope_of = ufl.derivative(squares * ufl.dx(mesh), e, way)
    slopes = fem.assemble_vector(form(slope_of, mesh.comm)).array
    assert slopes == pytest.approx(2 * values.ravel(), abs=2e-6)
    H = fem.assemble_matrix(form(ufl.derivative(slope_of, e, other), mesh.comm)).to_dense()
    seeded = np.random.default_rng(1)
    for _ in range(5):
        d = seeded.normal(size=values.shape)
        if state == "plane strain":
            d[:2, 2] = d[2, :2] = 0.0
        d = (d + d.T).ravel()
        assert d @ H @ d == pytest.approx(2 * d @ d, rel=1e-3)


# Splits under which rock without cracks bears any pressure.
INTACT = ("no-tension", "contact")


# A bar under sigma in plane stress, g of its stiffness left: strain over sigma/E, derived for each
# split from W(e_x, e_y, g) with dW/de_y = 0.
def compliance(name: str, pulled: bool, g):
    lambda_, mu = lame(E, NU, "solid")
    share, over = (1 - 2 * NU) / (1 - NU), NU / (1 - NU)  # of e_x + e_y: volume, and -e_z
    if name == "none" or (pulled and "convex" in name) or (pulled and "volumetric" in name):
        return 1 / g
    if name in INTACT:  # W = E/2 e_y^2 + g E/(2 (1 - nu^2)) (e_x + nu e_y)^2, or undamaged
        return (1 - NU**2) / g + NU**2 if pulled else 1 + 0 * g
    if name == "spectral":  # W = A/2 (e_x + e_y)^2 + mu (g e_x^2 + e_y^2), or g with e_y
        if pulled:
            A = g * lambda_ * share**2 + 2 * mu * over**2
            return E * (1 + A / (2 * mu)) / (A + g * (2 * mu + A))
        A = lambda_ * share**2 + 2 * mu * g * over**2
        return E * (1 + A / (2 * mu * g)) / (A + 2 * mu + A / g)
    # W = g psi + (1 - g) (1 + gamma) K/2 (share (e_x + e_y))^2: Sherman and Morrison.
    k = (1 - g) * (1 + SPLITS[name].gamma) * E / (3 * (1 - 2 * NU)) * share**2
    return 1 / g - k / g**2 * (1 - NU) ** 2 / E / (1 + 2 * k / g * (1 - NU) / E)


def curve(name: str, law: str, pulled: bool) -> tuple[np.ndarray, np.ndarray]:
    """Strains and stresses of homogeneous damage, up to the largest stress or alpha = .6:
    w' Gc/(4 c_w ell) = sigma^2/(2 E) dcompliance/dalpha, Gc = ell = 1."""
    damage, alpha = LAWS[law], np.linspace(0.0, 0.6, 6001)[1 if law == "AT2" else 0 :]
    rate = slope(lambda x: compliance(name, pulled, damage.a(x)), alpha)
    stress = np.sqrt(2 * E * slope(damage.w, alpha) / (4 * damage.c_w) / rate)
    end = int(stress.argmax()) + 1
    return (stress * compliance(name, pulled, damage.a(alpha)) / E)[:end], stress[:end]


def bar(name: str, law: str, strains, *, state: str = "plane stress") -> list[float]:
    """Stress of a bar too short for its damage to localize, at each strain."""
    size, cells = ((1.0, 0.5), "triangle") if state != "solid" else ((1.0, 0.5, 0.5), "hexahedron")
    sides = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: lambda x, t: float(strains[round(t) - 1])}),
    )
    material = rock(
        E=E, nu=NU, ell=1.0, law=LAWS[law], state=state, split=SPLITS[name], residual_stiffness=1e-9
    )
    times = tuple(1.0 + k for k in range(len(strains)))
    stop = Stop(change=1e-7, residual=1e-6)
    problem = body(size, 0.5, cells=cells, sides=sides, times=times, material=material, stop=stop)
    system = build(problem)
    stresses = []
    for record in march(problem, system):
        assert not record.audit.violations
        forces = support_reactions(system.alternation)
        moving = np.abs(system.supports.values(1.0)) > 0
        stresses.append(abs(forces[moving].sum()) / float(np.prod(size[1:])))
    system.destroy()
    return stresses


BARS = [
    pytest.param(name, law, pulled, marks=[pytest.mark.long] if law == "AT2" else [])
    for name, law, pulled in product(OPEN_CRACKS, ("AT1", "AT2"), (True, False))
    if pulled or name not in INTACT
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "law", "pulled"), BARS)
def test_bar(name: str, law: str, pulled: bool) -> None:
    """Stresses up to the strength within 1 % of the closed form, and no more beyond it."""
    strains, stresses = curve(name, law, pulled)
    onset = np.sqrt(2 * E * 3 / 8 / slope(lambda x: compliance(name, pulled, (1 - x) ** 2), 0.0))
    if law == "AT1":
        assert stresses[0] == pytest.approx(onset, rel=1e-9)
    if name == "volumetric-deviatoric" and law == "AT1" and not pulled:
        assert onset == pytest.approx(np.sqrt(9 * E / (16 * (1 + NU))), rel=1e-9)
    # At the strength itself a bar breaks.
    below = (1 - 1e-6) * np.linspace(strains[0], strains[-1], 8)
    at = np.concatenate([[strains[0] / 2], below, [1.03 * strains[-1]]])
    found = bar(name, law, at if pulled else -at)
    expected = np.interp(at[1:-1], strains, stresses)
    assert found[1:-1] == pytest.approx(expected, rel=0.01)
    assert found[0] == pytest.approx(E * at[0], rel=2e-9 if law == "AT1" else 0.2)
    if len(strains) < 6000:  # it has a strength
        assert found[-1] < stresses[-1]


def test_solid_bar() -> None:
    """The strength in compression of the volumetric-deviatoric split in 3-D."""
    expected = np.sqrt(9 * E / (16 * (1 + NU)))
    found = bar(
        "volumetric-deviatoric", "AT1", -expected / E * np.arange(0.97, 1.04, 0.01), state="solid"
    )
    assert max(found) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("state", ["plane stress", pytest.param("solid", marks=pytest.mark.long)])
def test_no_tension_never_fails_in_compression(state: str) -> None:
    """Twenty times the strength in tension, and no damage."""
    sigma = 20 * np.sqrt(3 * E / 8)
    stresses = bar("no-tension", "AT1", -sigma / E * np.array([0.5, 1.0]), state=state)
    assert stresses[-1] == pytest.approx(sigma, rel=1e-6)


def carried(name: str, ell: float) -> float:
    """Load of a block between walls, cut through at mid-height and pressed by 1 %, over that of a
    whole one."""
    sides = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: no_displacement}),
        SideSupport(side="bottom", components={1: no_displacement}),
        SideSupport(side="top", components={1: lambda x, t: -0.01 * t}),
    )
    h = ell / 3
    cut = FlatCrack(center=(0.5, 0.5 + h / 10, 0.0), normal=(0.0, 1.0, 0.0), radius=np.inf)
    material = rock(E=E, nu=NU, ell=ell, split=SPLITS[name], cracks=(cut,))
    problem = body((0.4, 1.0), h, sides=sides, material=material)
    system = build(problem)
    (step,) = march(problem, system)
    stress = abs(support_reactions(system.alternation)[system.supports.values(1.0) < 0].sum()) / 0.4
    system.destroy()
    assert not step.audit.violations
    return stress / (E / (1 - NU**2) * 0.01)


def test_closed_crack_without_a_split() -> None:
    """The faces pass through one another."""
    assert carried("none", 0.1) < 0.01


def test_closed_crack_without_tension() -> None:
    """It carries what whole rock does."""
    assert carried("no-tension", 0.1) == pytest.approx(1.0, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["volumetric-deviatoric", "star-convex", "spectral"])
def test_closed_crack(name: str) -> None:
    """It carries load through a layer of another stiffness: the difference vanishes as ell."""
    lacks = [1 / carried(name, ell) - 1 for ell in (0.1, 0.05)]
    assert lacks[0] / lacks[1] == pytest.approx(2.0, rel=1e-3)
