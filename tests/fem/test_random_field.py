"""Random fields with the mean, variation, lengths and directions asked for; fields of files."""

import re
from math import pi

import gstools
import numpy as np
import pytest
import pyvista
from scipy.stats import norm, weibull_min

from staffa.case.reading.read import parse_case
from staffa.errors import InputError
from staffa.properties.mesh_field import read_field
from staffa.properties.random_field import (
    DISTRIBUTIONS,
    marginal,
    random_factor,
    weibull_modulus,
)
from staffa.setup.toughness_and_cracks import toughness_factor

SEEDS = range(10)
# Of 10 fields of 1000 waves each, whose strengths are random: the variance of the score is known to
# 1/sqrt(1000 * 10) = 1 %.
WAVES = 0.01
# Error of a correlation from 10 times 400 or more pairs of points, and that of the waves.
PAIRS = 0.02


def field(distribution="normal", variation=0.2, lengths=(0.1, 0.1), axes=None, seed=0):
    axes = np.eye(len(lengths)) if axes is None else axes
    return random_factor(distribution, variation, lengths=lengths, axes=axes, seed=seed)


def apart(n: int, gap: float, dim: int = 2) -> np.ndarray:
    """A grid of n points along x, y, each this far from the next; shape (3, n^dim)."""
    grid = np.meshgrid(*[gap * np.arange(n)] * dim)
    return np.vstack([*[g.ravel() for g in grid], np.zeros((3 - dim, n**dim))])


@pytest.mark.parametrize("variation", [0.01, 0.1, 0.3, 1.0])
@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_values_have_the_mean_and_the_variation(distribution: str, variation: float) -> None:
    """By quadrature over a million equally likely normal scores."""
    likely = (np.arange(1_000_000) + 0.5) / 1_000_000
    values = marginal(distribution, variation, norm.ppf(likely))
    assert values.mean() == pytest.approx(1, abs=1e-5)
    # the far tails of a skewed marginal are cut by the quadrature
    assert values.std() == pytest.approx(variation, rel=2e-3)
    assert np.all(np.diff(values) > 0), "values must grow with the score"


def test_the_weibull_marginal_is_scipys() -> None:
    m = weibull_modulus(0.25)
    frozen = weibull_min(m, scale=1 / weibull_min(m).mean())
    z = np.linspace(-4.0, 6.0, 25)  # below, 1 - Phi(z) has lost too many digits in SciPy
    assert marginal("weibull", 0.25, z) == pytest.approx(frozen.isf(norm.sf(z)), rel=1e-9)
    assert frozen.std() == pytest.approx(0.25, rel=1e-9)


@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_a_field_has_the_mean_and_the_variation_over_many_lengths(distribution: str) -> None:
    x = apart(50, 0.3)  # 3 lengths apart, at a correlation of exp(-9 pi/4) = 1e-3
    found = np.array([field(distribution, seed=seed)(x) for seed in SEEDS])
    error = 0.2 / np.sqrt(found.size)
    assert abs(found.mean() - 1) < 5 * error, f"{found.mean()} +- {error}"
    # half the error of the variance; a lognormal or Weibull value adds at most as much again
    assert found.std() == pytest.approx(0.2, rel=4 * WAVES), f"{found.std()}"


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0])
def test_the_correlation_falls_with_the_lengths_along_their_directions(angle: float) -> None:
    """exp(-pi/4 (r/l)^2): 0.456 at r = l."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    axes, lengths = np.array([[c, s], [-s, c]]), (0.4, 0.1)
    x = apart(20, 1.1)
    fields = [field(lengths=lengths, axes=axes, seed=seed) for seed in SEEDS]
    here = np.array([f(x) for f in fields])
    for along, length in zip(axes, lengths, strict=True):
        for lag in (length, 2 * length):
            step = np.append(lag * along, 0.0)[:, None]
            there = np.array([f(x + step) for f in fields])
            found = np.corrcoef(here.ravel(), there.ravel())[0, 1]
            expected = np.exp(-pi / 4 * (lag / length) ** 2)
            assert found == pytest.approx(expected, abs=5 * PAIRS), f"lag {lag} along {along}"


def test_in_3d_the_lengths_lie_along_the_axes() -> None:
    axes = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    lengths, x = (0.4, 0.2, 0.1), apart(13, 1.1, dim=3)
    fields = [field(lengths=lengths, axes=axes, seed=seed) for seed in SEEDS[:2]]
    here = np.array([f(x) for f in fields])
    for along, length in zip(axes, lengths, strict=True):
        there = np.array([f(x + length * along[:, None]) for f in fields])
        found = np.corrcoef(here.ravel(), there.ravel())[0, 1]
        assert found == pytest.approx(np.exp(-pi / 4), abs=5 * PAIRS), f"along {along}"


def test_a_field_is_a_function_of_position_alone() -> None:
    x, f = apart(20, 0.07), field(lengths=(0.3, 0.1))
    order = np.random.default_rng(0).permutation(x.shape[1])
    one_by_one = np.concatenate([f(x[:, n : n + 1]) for n in order])
    assert one_by_one == pytest.approx(f(x)[order], rel=1e-12)
    assert f(np.zeros((3, 0))).shape == (0,)


def test_the_same_seed_gives_the_same_field_and_another_another() -> None:
    x = apart(5, 0.2)
    assert np.array_equal(field(seed=3)(x), field(seed=3)(x))
    assert np.abs(field(seed=3)(x) - field(seed=4)(x)).max() > 0.05


def test_random_toughness_is_the_lognormal_field_that_it_was() -> None:
    """Values of the table [toughness], one by one: exp(s z - s^2/2) of GSTools' field."""
    case = parse_case(
        "domain = {size=[1.0,1.0], h=0.1}\ndamage = {ell=0.3}\ntemperature = {dT=1.0}\n"
        "time = {t=[0.1]}\ntoughness = {amplitude=0.2, correlation_length=0.4, seed=5}"
    )
    x, variance = apart(10, 0.1), np.log1p(0.2**2)
    model = gstools.Gaussian(dim=2, var=1.0, len_scale=0.4)
    z = gstools.SRF(model, seed=5)((x[0], x[1]))
    expected = np.exp(np.sqrt(variance) * z - variance / 2)
    assert np.array_equal(toughness_factor(case)(x), expected)


def written(folder, *, per_cell: bool = False):
    """Two triangles over the unit square with a field E = 1 + x + 2 y, or one number a cell."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    mesh = pyvista.UnstructuredGrid(
        np.array([3, 0, 1, 2, 3, 0, 2, 3]), np.array([5, 5], dtype=np.uint8), points
    )
    if per_cell:
        mesh.cell_data["E"] = np.array([1.0, 2.0])
    else:
        mesh.point_data["E"] = 1 + points[:, 0] + 2 * points[:, 1]
    mesh.point_data["u"] = points
    mesh.point_data["lost"] = np.array([0.0, np.nan, 0.0, 0.0])
    mesh.save(folder / "field.vtu")
    return folder / "field.vtu"


def test_a_linear_field_of_a_file_is_met_exactly_and_beyond_its_mesh_is_no_number(tmp_path):
    found = read_field(written(tmp_path), "E")
    x = np.random.default_rng(0).uniform(size=(3, 50)) * [[1.0], [1.0], [0.0]]
    assert found(x) == pytest.approx(1 + x[0] + 2 * x[1], rel=1e-12)
    assert np.isnan(found(np.array([[1.5], [0.5], [0.0]]))).all()
    assert found(np.zeros((3, 0))).shape == (0,)


def test_values_of_a_field_are_those_of_pyvista_to_the_bit(tmp_path):
    """So do runs with fields in files stay what they were before PyVista was left out."""
    mesh = pyvista.ImageData(dimensions=(4, 5, 6)).to_tetrahedra(12)
    mesh.point_data["E"] = np.random.default_rng(0).uniform(size=mesh.n_points)
    mesh.save(tmp_path / "E.vtu")
    places = np.random.default_rng(1).uniform(-0.5, 5.5, size=(500, 3))
    found = pyvista.PolyData(places).sample(mesh)
    inside = found["vtkValidPointMask"].astype(bool)
    values = read_field(tmp_path / "E.vtu", "E")(places.T)
    assert 100 < inside.sum() < 400
    assert np.array_equal(values, np.where(inside, found["E"], np.nan), equal_nan=True)


def test_a_field_of_cells_is_that_of_the_cell_around(tmp_path):
    found = read_field(written(tmp_path, per_cell=True), "E")
    assert list(found(np.array([[0.7, 0.3], [0.2, 0.8], [0.0, 0.0]]))) == [1.0, 2.0]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("e", "the file has no field 'e'; it has E, lost, u. Did you mean 'E'?"),
        ("u", "'u' is not one number at each place"),
        ("lost", "'lost' is not finite everywhere"),
    ],
)
def test_a_field_that_cannot_be_used_is_refused(tmp_path, name, said):
    with pytest.raises(InputError, match=said.replace("?", r"\?")):
        read_field(written(tmp_path), name)


def test_a_cell_whose_corner_is_no_point_of_the_mesh_is_refused(tmp_path):
    """VTK reads it, and would look for the point anywhere in memory."""
    file = written(tmp_path)
    pyvista.read(file).save(file, binary=False)
    text = re.sub(r'(Name="connectivity"[^>]*>\s*)\d+', r"\g<1>999999", file.read_text())
    file.write_text(text)
    with pytest.raises(InputError, match=r"field.vtu holds no mesh that can be read"):
        read_field(file, "E")


def test_a_file_that_is_no_mesh_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"there is no file .*none.vtu"):
        read_field(tmp_path / "none.vtu", "E")
    (tmp_path / "bad.vtu").write_text("no mesh")
    with pytest.raises(InputError, match=r"bad.vtu holds no mesh that can be read"):
        read_field(tmp_path / "bad.vtu", "E")
