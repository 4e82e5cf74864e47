"""Quantities: what is read, to what number, and what is kept of how it was written."""

import pickle

import pytest

from staffa.errors import InputError
from staffa.units import EXAMPLES, SI_UNITS, Quantity, Temperature, parse

READ = [
    ("5 mm", "length", 5e-3),
    ("5mm", "length", 5e-3),
    (" -5.0e1 um ", "length", -5e-5),
    ("2 in", "length", 0.0508),
    ("70 GPa", "stress", 70e9),
    ("+.5 MPa", "stress", 5e5),
    ("42.47 J/m^2", "toughness", 42.47),
    ("10 N/m", "toughness", 10.0),
    ("1 MPa mm", "toughness", 1000.0),
    ("120 K", "temperature difference", 120.0),
    ("120 delta_degC", "temperature difference", 120.0),
    ("9e-6 1/K", "thermal expansion", 9e-6),
    ("9e-6/K", "thermal expansion", 9e-6),
    ("9 K^-1", "thermal expansion", 9.0),
    ("2 min", "time", 120.0),
    ("1 h", "time", 3600.0),
    ("0.5 mm^2/s", "diffusivity", 5e-7),
    ("0.5 mm²/s", "diffusivity", 5e-7),
    ("0.5 mm**2/s", "diffusivity", 5e-7),
    ("0 m", "length", 0.0),
    ("20 °C", "temperature", 293.15),
    ("20 degC", "temperature", 293.15),
    ("-5.5degC", "temperature", 267.65),
    ("0 °C", "temperature", 273.15),
    ("293 K", "temperature", 293.0),
    ("68 degF", "temperature", 293.15),
    ("-1 K/m", "temperature gradient", -1.0),
    ("30 °C/km", "temperature gradient", 0.03),
    ("2 W/(m °C)", "conductivity", 2.0),
    ("9e-6 1/°C", "thermal expansion", 9e-6),
    ("2.5 W/(m K)", "conductivity", 2.5),
    ("2.5 W/m/K", "conductivity", 2.5),
    ("2.5 W m^-1 K^-1", "conductivity", 2.5),
    ("2.7 g/cm^3", "density", 2700.0),
    ("0.8 kJ/(kg K)", "heat capacity", 800.0),
    ("60 mW/m^2", "heat flux", 0.06),
    ("-60 mW/m²", "heat flux", -0.06),
    ("500 W/(m^2 K)", "film coefficient", 500.0),
    ("2 uW/m^3", "heat source", 2e-6),
    ("-30 K/km", "temperature gradient", -0.03),
]
# Each is something else than it seems, or than pint alone would make of it.
REFUSED = [
    ("10^-6/K", "thermal expansion", "is no unit"),
    ("1,5 mm", "length", "is no unit"),
    ("1_000 mm", "length", "is no unit"),
    ("5 m 3", "length", "is no unit"),
    ("5 m + 3 m", "length", "is no unit"),
    ("5 mm^99999999", "length", "is no unit"),
    ("9**9**9**9 m", "length", "is no unit"),
    ("5 " + "m " * 10_000 + "!", "length", "too long for a length"),
    ("5 MM", "length", "does not measure a length"),
    ("5 %", "length", "does not measure a length"),
    ("5 dB", "length", "does not measure a length"),
    ("20 degC", "temperature difference", "has its own zero"),
    ("68 degF", "temperature difference", "has its own zero"),
    ("20 delta_degC", "temperature", "measures a difference"),
    ("-300 °C", "temperature", "below absolute zero"),
    ("-1 K", "temperature", "below absolute zero"),
    ("20 C", "temperature", "does not measure a temperature"),
    ("20 m", "temperature", "does not measure a temperature"),
    ("20", "temperature", "needs a unit"),
    ("2 W/(m^2 K)", "conductivity", "does not measure a conductivity"),
    ("mm", "length", "begins with a number"),
    ("inf m", "length", "begins with a number"),
    ("", "length", "begins with a number"),
    ("5", "length", "needs a unit"),
    ("1e400 m", "length", "a finite number"),
    ("1e99 m", "length", "check its unit"),
    (1e-99, "length", "check its unit"),
    (float("nan"), "length", "a finite number"),
    (True, "length", "is a number, or a text"),
    (None, "length", "is a number, or a text"),
    ([5], "length", "is a number, or a text"),
]


@pytest.mark.parametrize(("text", "dimension", "value"), READ)
def test_a_text_is_read_in_si(text, dimension, value):
    read = parse(text, dimension)
    assert read == pytest.approx(value, rel=1e-14), f"{text} was read as {float(read)}"
    assert read.has_units and read.given == text


@pytest.mark.parametrize(("value", "dimension", "reason"), REFUSED, ids=lambda v: str(v)[:20])
def test_a_text_that_could_be_misread_is_refused(value, dimension, reason):
    with pytest.raises(InputError, match=reason):
        parse(value, dimension)


@pytest.mark.parametrize("dimension", SI_UNITS)
def test_the_example_of_every_dimension_is_read(dimension):
    assert parse(EXAMPLES[dimension], dimension) > 0


@pytest.mark.parametrize("number", [5, 0.25, -3.0, 0, 1e30, -1e-30])
def test_a_bare_number_is_itself_and_has_no_unit(number):
    read = parse(number, "length")
    assert read == number and not read.has_units and isinstance(read.given, float)


def test_a_quantity_survives_the_way_to_another_rank():
    there = pickle.loads(pickle.dumps(parse("5 mm", "length")))
    assert there == 5e-3 and there.given == "5 mm" and there.has_units


def test_a_quantity_that_was_read_is_not_read_again():
    read = parse("5 mm", "length")
    assert parse(read, "length") is read and isinstance(read, Quantity)


def test_only_a_temperature_has_a_zero_of_its_own():
    read = {dimension: parse(0.0, dimension) for dimension in SI_UNITS}
    assert [d for d, q in read.items() if isinstance(q, Temperature)] == ["temperature"]
    there = pickle.loads(pickle.dumps(parse("20 °C", "temperature")))
    assert isinstance(there, Temperature) and there == 293.15 and there.given == "20 °C"
