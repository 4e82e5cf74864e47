"""Objects of a script in place of a case's are tried, and asked for when its run goes on."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import staffa
from staffa.errors import InputError, StoppedError
from staffa.io.run_directory import MANIFEST
from staffa.physics.damage import AT1, LAWS
from staffa.physics.split import SPLITS, StarConvex
from staffa.physics.trial import try_law, try_split
from staffa.results.slab_table import table
from staffa.results.summary import summary
from staffa.runs.run import Watcher
from staffa.setup.object_identity import object_identity
from staffa.setup.user_objects import Given, unrecorded

SLAB = [
    *("domain.h=0.1", "domain.size=[1.0, 0.5]", "damage.ell=0.2", "time.tau=[0.3, 0.6]"),
    *("output.at=[]", "toughness={}", "measures.depths=[0.1]"),
]


def slab(*settings: str) -> "staffa.Case":
    """The paper's slab, so small that it costs nothing."""
    return staffa.ready_case("slab", [*SLAB, *settings])


class Zero:
    """A body at rest."""

    def temperature(self, x, t):
        """Nothing anywhere."""
        return np.zeros(x.shape[1])


@dataclass(frozen=True)
class Cold:
    """Even cold."""

    drop: float

    def temperature(self, x, t):
        """Alike everywhere."""
        return np.full(x.shape[1], -self.drop * t)


class Law:
    """AT1 by hand."""

    name, c_w = "mine", 2 / 3

    def a(self, alpha):
        """See `DamageLaw`."""
        return (1 - alpha) ** 2

    def w(self, alpha):
        """See `DamageLaw`."""
        return alpha


def law(**members) -> object:
    """AT1 by hand, with other members."""
    functions = {k: (lambda self, x, f=v: f(x)) if callable(v) else v for k, v in members.items()}
    return type("Mine", (Law,), functions)()


def split(density, **members) -> object:
    """A split with this density of e and g."""
    own = {"name": "mine", "isotropic": True, "density": lambda self, e, g: density(e, g)}
    return type("Mine", (), own | members)()


def load(temperature) -> object:
    return type("Mine", (), {"temperature": lambda self, x, t: temperature(x, t)})()


def refusal(call) -> str:
    with pytest.raises(InputError) as caught:
        call()
    said = str(caught.value)
    assert "\n" not in said and "; " in said and " at 0x" not in said, f"no way out in: {said}"
    return said


# --- laws ---


class NoName:
    """As in the faults: a law that has no name."""

    c_w = 2 / 3
    a, w = Law.a, Law.w


@pytest.mark.parametrize("known", LAWS.values(), ids=LAWS)
def test_the_laws_of_staffa_are_laws(known) -> None:
    try_law(known)


def test_laws_of_papers_are_laws() -> None:
    """Laws of cohesive cracks (Lorentz 2011, Wu 2017), of late softening (Borden 2016)."""
    try_law(law(w=lambda x: 2 * x - x**2, c_w=np.pi / 4))
    try_law(law(a=lambda x: (1 - x) ** 2 / (1 + (x + 0.5 * x**2) * 3)))
    try_law(law(a=lambda x: (1 - x) ** 2 * (1 + x)))
    try_law(law(a=lambda x: (1 - 1e-6) * (1 - x) ** 2 + 1e-6), residual=1e-6)
    try_law(law(c_w=0.66667))


LAWS_THAT_ARE_NONE = [
    (NoName(), "has no name", "give an object with name, c_w, a(), w()"),
    (law(name="wrong", c_w=1.0), "'wrong': c_w = 1, and the integral", "write c_w = 0.666667"),
    (law(name="rising", a=lambda x: 1 + x), "'rising': a(1) = 2", "scale it"),
    (law(a=lambda x: 2 * (1 - x)), "a(0) = 2", "scale it"),
    (law(a=lambda x: (1 - x) ** 2 * (1 + 4 * x)), "a rises at alpha = ", "fix a"),
    (law(w=lambda x: 1 + x), "w(0) = 1", "scale it"),
    (law(w=lambda x: 2 * x), "w(1) = 2", "scale it"),
    (law(w=lambda x: 3 * x - 2 * x**2, c_w=1.0), "w falls at alpha = ", "fix w"),
    (law(w=lambda x: np.nan * x), "w(alpha) is not finite", "fix it"),
    (law(w=lambda x: "a text"), "w(alpha) cannot be computed", "arithmetic alone"),
    (law(a=lambda x: np.exp(-x)), "a(1) = 0.367879", "scale it"),
    (law(c_w="2/3"), "c_w = '2/3' is a str", "give a number"),
    (law(name=3), "name = 3", "give it one"),
    (law(name="AT1"), "another one whose name is 'AT1'", "give it another name"),
    ("AT1", "damage = 'AT1' has no name, c_w, a, w", "give an object with"),
    (lambda alpha: (1 - alpha) ** 2, "has no name, c_w, a, w", "give an object with"),
    (AT1, "AT1 is a class", "like AT1()"),
    (type("Attribute", (Law,), {"w": 1.0})(), "w is no method", "give an object with"),
]


@pytest.mark.parametrize(
    ("own", "names", "way_out"),
    LAWS_THAT_ARE_NONE,
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_no_law_is_refused_before_anything_is_built(own, names, way_out) -> None:
    said = refusal(lambda: staffa.problem(slab(), damage=own))
    assert names in said and way_out in said, said


def test_a_law_that_ufl_cannot_write_is_refused() -> None:
    late = law(a=lambda x: 1 - np.sin(np.pi / 2 * x))
    said = refusal(lambda: staffa.problem(slab(), damage=late))
    assert "a(alpha) cannot be written in UFL" in said, said


# --- splits ---


@pytest.mark.parametrize("plane_stress", [True, False])
@pytest.mark.parametrize("known", SPLITS.values(), ids=SPLITS)
def test_the_splits_of_staffa_are_splits(known, plane_stress: bool) -> None:
    for nu in (0.0, 0.2, 0.45):
        try_split(known, plane_stress=plane_stress, nu=nu)


SPLITS_THAT_ARE_NONE = [
    (split(lambda e, g: 2 * g * e.psi), "at g = 1 is", "fix density"),
    (split(lambda e, g: g * e.psi + (1 - g)), "where there is no strain", "fix density"),
    (split(lambda e, g: e.psi), "nothing could break", "fix density"),
    (split(lambda e, g: (2 * g - 1) * e.psi), "must not be negative", "fix density"),
    # Stiff only as long as the volume grows: a step at the turn.
    (split(lambda e, g: e.psi * (g + (1 - g) * (e.volume > 0))), "not convex", "fix density"),
    # What is left depends on the shape of the strain, as in some splits by stress.
    (
        split(lambda e, g: g * e.psi + (1 - g) * (e.psi * (e.volume < 0))),
        *("not convex in the strain", "fix density"),
    ),
    (split(lambda e, g: g * e.psi, isotropic="no"), "isotropic = 'no' is a str", "True or False"),
    (
        split(lambda e, g: g * e.principal.E * e.psi, isotropic=False),
        *("density(e, g) cannot be computed", "arithmetic alone"),
    ),
    ("no-tension", "split = 'no-tension' has no name, isotropic, density", "give an object with"),
    (StarConvex, "StarConvex is a class", "like StarConvex()"),
    (split(lambda e, g: g * e.psi, name="none"), "whose name is 'none'", "give it another name"),
]


@pytest.mark.parametrize(
    ("own", "names", "way_out"),
    SPLITS_THAT_ARE_NONE,
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_no_split_is_refused_before_anything_is_built(own, names, way_out) -> None:
    said = refusal(lambda: staffa.problem(slab(), split=own))
    assert names in said and way_out in said, said


# --- loads ---

LOADS_THAT_ARE_NONE = [
    (load(lambda x, t: -1.0), "gives a float for points of shape (3, ", "np.full(x.shape[1]"),
    (load(lambda x, t: x.T), "gives an array of shape (", "give one number a point"),
    (load(lambda x, t: x[0] + 1j), "type complex128", "give one number a point"),
    (load(lambda x, t: np.where(x[0] > 0.5, np.nan, 0.0)), "not finite at t = ", "fix it"),
    (load(lambda x, t: x[0] / 0 if t > 0.01 else x[3]), "IndexError", "fix it"),
    (load(lambda x, t: np.random.default_rng().normal(size=x.shape[1])), "another", "fix it"),
    (lambda x, t: -x[0], "has no temperature", "give an object with temperature()"),
    (-1.0, "temperature = -1.0 has no temperature", "give an object with temperature()"),
    (Zero, "Zero is a class", "like Zero()"),
]


@pytest.mark.parametrize(
    ("own", "names", "way_out"),
    LOADS_THAT_ARE_NONE,
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_no_load_is_refused_before_anything_is_written(
    own, names, way_out, tmp_path: Path
) -> None:
    said = refusal(lambda: staffa.run(slab(), tmp_path / "run", temperature=own))
    assert names in said and way_out in said, said
    assert not (tmp_path / "run").exists()


# --- cases that a load completes ---


@pytest.mark.parametrize(
    "missing",
    [
        ('temperature={profile="none"}', "time={t=[0.1]}", "measures={}"),
        ("temperature={}",),
        ("temperature={}", "time={t=[0.0, 0.1]}"),
    ],
    ids=["nothing loads", "no drop", "from the start"],
)
def test_a_case_that_a_load_completes_is_run(missing, tmp_path: Path) -> None:
    case = slab(*missing)
    assert "loads nothing" in (said := refusal(lambda: staffa.problem(case))) or "given" in said
    steps = staffa.run(case, tmp_path / "run", temperature=Cold(1.0))
    assert steps[-1].status == "converged" and staffa.open_run(tmp_path / "run").finished
    assert refusal(lambda: staffa.run(case, tmp_path / "other")) == said


# --- identity ---


@dataclass(frozen=True)
class Spot:
    """A load with many parameters."""

    places: tuple[float, ...]
    table: object
    inner: object = None

    def temperature(self, x, t):
        """Nothing."""
        return np.zeros(x.shape[1])


def test_an_object_is_known_by_its_name_and_parameters() -> None:
    assert object_identity(Zero()) == "Zero()"
    assert object_identity(Cold(2.0)) == object_identity(Cold(np.float64(2.0))) == "Cold(drop=2.0)"
    one = Spot((1.0, 2.0), np.arange(3.0), Cold(1.0))
    assert object_identity(one) == object_identity(Spot((1.0, 2.0), np.arange(3.0), Cold(1.0)))
    for other in (
        replace(one, places=(1.0, 2.5)),
        replace(one, table=np.array([0.0, 1.0, 3.0])),
        replace(one, inner=Cold(2.0)),
        replace(one, places=tuple(range(1000))),
    ):
        assert object_identity(other) != object_identity(one)
    assert len(object_identity(replace(one, places=tuple(range(1000))))) <= 300
    assert (
        object_identity(type("Said", (), {"identity": "hot spot, 2nd try"})())
        == "hot spot, 2nd try"
    )
    plain = Zero()
    plain.drop, plain._asked = 3.0, 17  # type: ignore[attr-defined]
    assert object_identity(plain) == "Zero(drop=3.0)"


def cut(directory: Path, **own) -> None:
    """A run that was asked to stop after its first step."""
    seen: list[object] = []
    watcher = Watcher(stepped=seen.append, stop=lambda: "enough" if seen else None)
    with pytest.raises(StoppedError):
        staffa.run(slab(), directory, watcher=watcher, **own)


def test_a_run_with_a_load_of_its_own_goes_on_with_the_same_one_alone(tmp_path: Path) -> None:
    """As in the faults: it went on with the case's own cooling, and no violation."""
    run = tmp_path / "run"
    cut(run, temperature=Cold(0.5))
    said = refusal(lambda: staffa.resume(run))
    assert "with the load Cold(drop=0.5) of a script" in said and "temperature=..." in said
    assert "not Cold(drop=0.6)" in refusal(lambda: staffa.resume(run, temperature=Cold(0.6)))
    assert "not Zero()" in refusal(lambda: staffa.resume(run, temperature=Zero()))
    renamed = type("Cold", (), {"identity": "Cold(drop=0.5)", "temperature": Zero.temperature})()
    said = refusal(lambda: staffa.resume(run, temperature=renamed))
    assert "another load of the same name, Cold(drop=0.5)" in said
    assert "case's own law" in refusal(
        lambda: staffa.resume(run, damage=Law(), temperature=Cold(0.5))
    )
    found = staffa.resume(str(run), temperature=Cold(0.5))
    whole = staffa.run(slab(), str(tmp_path / "whole"), temperature=Cold(0.5))
    assert [s.energies for s in found] == [s.energies for s in whole]
    assert found[-1].energies.elastic > 0, "cold rock between rollers is strained"


def test_a_run_with_a_law_and_a_split_of_its_own_goes_on_with_these_alone(tmp_path: Path) -> None:
    run, own = tmp_path / "run", {"damage": Law(), "split": split(lambda e, g: g * e.psi)}
    cut(run, **own)
    assert "with the " in refusal(lambda: staffa.resume(run))
    assert "with the split Mine() of a script" in refusal(
        lambda: staffa.resume(run, damage=own["damage"])
    )
    other = type("Law", (Law,), {"a": lambda self, x: (1 - x) ** 2 * (1 + x)})()
    said = refusal(lambda: staffa.resume(run, **own | {"damage": other}))
    assert "another law of the same name, Law()" in said
    assert len(staffa.resume(run, **own)) == 2


def test_a_run_of_before_identities_were_kept_goes_on(tmp_path: Path) -> None:
    run = tmp_path / "run"
    cut(run, temperature=Zero())
    record = json.loads((run / MANIFEST).read_text())
    assert record["own"]["temperature"]["identity"] == "Zero()"
    del record["own"]
    (run / MANIFEST).write_text(json.dumps(record))
    assert len(staffa.resume(run, temperature=Zero())) == 2


def test_the_manifest_shows_nothing_that_does_not_hold_for_a_load_of_its_own(
    tmp_path: Path,
) -> None:
    """As in the faults: a severity of 54 and the paper's table for a body at rest."""
    staffa.run(slab(), tmp_path / "own", temperature=Zero(), damage=Law())
    staffa.run(slab(), tmp_path / "cooled")
    own, cooled = (staffa.open_run(tmp_path / name) for name in ("own", "cooled"))
    assert cooled.manifest.scales["severity"] == pytest.approx(54) and table(cooled) is not None
    assert own.manifest.scales == {} and own.manifest.law == "mine" and table(own) is None
    assert own.manifest.own_load is not None and own.manifest.own_load.identity == "Zero()"
    said = {fact.name: fact.text for fact in summary(own)}
    assert "severity" not in said["damage"] and "cooled" not in said["body"]
    assert said["load"] == "Zero(), of a script"
    assert "load" not in {fact.name for fact in summary(cooled)}


def test_scales_of_a_law_of_its_own_are_that_laws(tmp_path: Path) -> None:
    """Its strength, not that of the law which the case names."""
    case = slab("damage.law=AT2")
    staffa.run(case, tmp_path / "run", damage=Law())
    found = staffa.open_run(tmp_path / "run").manifest.scales
    staffa.run(slab(), tmp_path / "at1")
    assert found == staffa.open_run(tmp_path / "at1").manifest.scales


# --- steps, paths and wrong types ---


def test_steps_from_python_have_measures_those_of_a_run(tmp_path: Path) -> None:
    case = slab("domain.h=0.05")
    problem = staffa.problem(case)
    found = list(staffa.march(problem, staffa.build(problem)))
    ran = staffa.run(case, tmp_path / "run")
    assert all(step.measures is not None for step in found)
    assert [step.measures for step in found] == [step.measures for step in ran]
    assert found[-1].measures.length_surface > 0.1 and found[-1].measures.sections


def test_paths_are_texts_or_paths(tmp_path: Path) -> None:
    from staffa.case.reading.ready_cases import text

    (tmp_path / "my.toml").write_text(text("slab"))
    path = str(tmp_path / "my.toml")
    assert staffa.read_case(path, SLAB) == staffa.read_case(Path(path), SLAB)
    run = str(tmp_path / "run")
    staffa.run(staffa.read_case(path, SLAB), run, temperature=Zero())
    assert staffa.open_run(run).finished and len(staffa.resume(run, temperature=Zero())) == 2


PROBLEM = "give a Problem, as staffa.problem(case) makes one"
WRONG = {
    "read_case(3)": "path = 3 is an int; give a path",
    "read_case('a.toml', 'domain.h=1')": "settings = 'domain.h=1' is one text; give a list",
    "ready_case('slab', [1])": "a setting = 1 is an int; give a list of texts",
    "ready_case('slab', 3)": "settings = 3 is an int; give a list of texts",
    "ready_case(3)": "name = 3 is an int; give the name of a ready case",
    "parse_case(None)": "text = None is a NoneType; give the text of a case file",
    "problem('slab')": "case = 'slab' is a str; give a Case",
    "run('slab', 'there')": "case = 'slab' is a str; give a Case",
    "run(staffa.ready_case('slab'), 3)": "directory = 3 is an int; give a path",
    "run(staffa.ready_case('slab'), 'there', watcher=print)": "watcher = ",
    "run(staffa.ready_case('slab'), 'there', comm=2)": "comm = 2 is an int; give a communicator",
    "resume(None)": "directory = None is a NoneType; give a path",
    "build(staffa.ready_case('slab'))": PROBLEM,
    "march(staffa.ready_case('slab'), None)": PROBLEM,
    "open_run(3)": "path = 3 is an int; give a path",
}


@pytest.mark.parametrize("call", WRONG)
def test_wrong_types_get_a_sentence(call: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    said = refusal(lambda: list(eval(f"staffa.{call}", {"staffa": staffa})))
    assert WRONG[call] in said, said
    assert not any(tmp_path.iterdir())


def test_an_old_run_that_goes_on_says_what_was_not_recorded() -> None:
    """Its manifest does not tell whether a script gave it a load, so that it cannot be refused."""
    said = unrecorded(None, Given())
    assert said is not None and "did not record" in said and "from Python" in said
    assert unrecorded({}, Given()) is None
    assert unrecorded(None, Given(temperature=Zero())) is None
