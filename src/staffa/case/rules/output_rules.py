"""Rules on the fields that are written: each once, and those that pictures are drawn from."""

from staffa.case.schema.case import Case
from staffa.case.schema.material_keys import is_isotropic
from staffa.case.schema.toml_text import inline
from staffa.case.values.subdomains import subdomains_of
from staffa.errors import InputError
from staffa.evolution.output_fields import FIELDS, NEEDED


def output_fields_are_possible(case: Case) -> None:
    """Every field is listed once, and the rock has it; damage and temperature are among them."""
    names = case.output.fields
    for number, name in enumerate(names):
        if name in names[:number]:
            raise InputError(f"output.fields: {inline(name)} is there twice; leave one out")
    missing = [name for name in NEEDED if name not in names]
    if missing:
        raise InputError(
            f"output.fields = {inline(names)} lacks {inline(missing[0])}, from which pictures and "
            f"crack networks are drawn; add it"
        )
    anisotropic = [rock for rock in subdomains_of(case) if not is_isotropic(rock.keys)]
    for name in names:
        if anisotropic and FIELDS[name].isotropic:
            raise InputError(
                f"output.fields: {inline(name)} is a number of isotropic rock, and this rock has "
                f"others along its axes; leave it out"
            )
