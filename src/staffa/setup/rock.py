"""Case -> the rock of the body and of its regions, as objects; what they hold is checked."""

from functools import partial

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from staffa.backend.parallel import any_over_ranks
from staffa.case.scales.case_scales import Numbers
from staffa.case.schema.case import Case
from staffa.case.schema.material_keys import RATIOS, is_isotropic
from staffa.case.schema.temperature_keys import law_of
from staffa.case.schema.toml_text import as_toml
from staffa.case.values.default_split import energy_split
from staffa.case.values.property_functions import point_property, varies
from staffa.case.values.stiffness import elasticity, structural_tensor, tensor
from staffa.case.values.subdomains import Subdomain, averages, subdomains_of
from staffa.errors import InputError
from staffa.evolution.coefficients import LAWFUL
from staffa.evolution.problem import Material, nowhere
from staffa.geometry.places import in_box
from staffa.model.block_parts import Part
from staffa.model.domain import Domain, middles
from staffa.physics.elasticity import Isotropic, PointFunction, Property, checked, values
from staffa.physics.split import EnergySplit
from staffa.physics.temperature import Law
from staffa.setup.toughness_and_cracks import cracked, flat_cracks, toughness_factor


def materials(
    case: Case,
    derived: Numbers,
    h: float,
    split: EnergySplit | None = None,
) -> tuple[Material, dict[str, Material]]:
    """Return the rock of a case, and that of each region by its name.

    Parameters
    ----------
    case : the case.
    derived : scales of the case.
    h : cell edge (m).
    split : the energy split; None for the split of the case.
    """
    blocks = not case.domain.has_simplices
    body, *regions = subdomains_of(case)
    common = partial(
        Material,
        ell=float(case.damage.ell),
        law=derived.law,
        state=derived.state,
        split=split or energy_split(case),
        residual_stiffness=case.damage.residual_stiffness,
        cracked=cracked(case, h) if blocks else nowhere,
        cracks=() if blocks else flat_cracks(case),
        given=flat_cracks(case) if blocks else (),
    )
    factor = toughness_factor(case)
    names = zip(case.regions, regions, strict=True)
    return _material(body, factor, common), {n: _material(p, factor, common) for n, p in names}


def _material(subdomain: Subdomain, factor: PointFunction, common: partial[Material]) -> Material:
    keys, mean = subdomain.keys, averages(subdomain)
    elastic = elasticity(keys, partial(point_property, dim=subdomain.dim))
    simple = isinstance(elastic, Isotropic)
    return common(
        E=elastic.E if isinstance(elastic, Isotropic) else mean.E,
        nu=elastic.nu if isinstance(elastic, Isotropic) else mean.nu,
        elasticity=None if simple else elastic,
        Gc=mean.Gc,
        toughness=_toughness(subdomain, mean.Gc, factor),
        roughness=structural_tensor(keys),
        expansion=_expansion(subdomain),
        rho=0.0 if keys.rho is None else point_property(keys.rho, subdomain.dim),
        laws=_laws(subdomain),
    )


def _laws(subdomain: Subdomain) -> dict[str, Law]:
    """Return the laws by which temperature changes its mechanical properties."""
    found = {name: law_of(getattr(subdomain.keys, name), subdomain.dim) for name in LAWFUL}
    return {name: law for name, law in found.items() if law is not None}


def _expansion(subdomain: Subdomain) -> Property | np.ndarray:
    given = subdomain.keys.expansion
    if isinstance(given, tuple):
        return tensor(subdomain.keys, given)
    return point_property(given, subdomain.dim)


def _toughness(subdomain: Subdomain, mean: float, factor: PointFunction) -> PointFunction:
    """Return the factor of [toughness], times the toughness over its mean where it varies."""
    given = subdomain.keys.Gc
    own = 1.0 if isinstance(given, tuple) else point_property(given, subdomain.dim)
    if not callable(own):
        return factor
    return lambda x: own(x) / mean * factor(x)


def region_boxes(case: Case) -> dict[str, Part]:
    """Return, for each region with a box, the function that finds its points in a block."""
    boxes = {name: (keys.lower, keys.upper) for name, keys in case.regions.items()}
    return {
        name: partial(in_box, lower, upper, h=case.outline.h)
        for name, (lower, upper) in boxes.items()
        if lower is not None and upper is not None
    }


def toughness_boxes(case: Case) -> dict[str, Part]:
    """Return, for each band of [toughness], the function that finds its points."""
    return {
        f"band {number}": partial(in_box, band.lower, band.upper, h=case.outline.h)
        for number, band in enumerate(case.toughness.bands)
    }


def check_rock(case: Case, domain: Domain) -> None:
    """Require possible values of all properties that vary, in the middles of cells. Collective.

    Raises
    ------
    InputError
        A region is not one of the mesh, or a property has a value that no rock has.
    """
    x = middles(domain.mesh)
    body, *regions = subdomains_of(case)
    rest = np.ones(x.shape[1], dtype=bool)
    for name, subdomain in zip(case.regions, regions, strict=True):
        cells = domain.cells(name)
        rest[cells] = False
        _check(domain, subdomain, x[:, cells])
    _check(domain, body, x[:, rest])


def _check(domain: Domain, subdomain: Subdomain, x: np.ndarray) -> None:
    varying = [item for item in subdomain.properties() if varies(item[-1])]
    for name, where, value in varying:
        found = values(point_property(value, subdomain.dim), x)
        least, most, rule = _range(name, subdomain)
        if any_over_ranks(domain.comm, not np.all((found > least) & (found < most))):
            raise InputError(
                f"{where} = {as_toml(value)}: it must be {rule} in the middle of every cell, and "
                f"is not; change it, take a smaller variation, or a file whose mesh covers the body"
            )
    if varying and not is_isotropic(subdomain.keys):
        _check_stiffness(domain, subdomain, x)


def _range(name: str, subdomain: Subdomain) -> tuple[float, float, str]:
    """Return the bounds of the values of a property, and their words for messages."""
    if name not in RATIOS:
        return 0.0, np.inf, "finite and larger than zero"
    if is_isotropic(subdomain.keys):
        return -1.0, 0.5, "between -1 and 0.5"
    return -np.inf, np.inf, "finite"  # the stiffness tells


def _check_stiffness(domain: Domain, subdomain: Subdomain, x: np.ndarray) -> None:
    said = ""
    try:
        checked(elasticity(subdomain.keys, partial(point_property, dim=subdomain.dim)).stiffness(x))
    except InputError as error:
        said = str(error)
    if any_over_ranks(domain.comm, bool(said)):
        there = [text for text in domain.comm.allgather(said) if text]
        raise InputError(f"{subdomain.where}: {there[0]}")
