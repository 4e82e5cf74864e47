"""Small cases in which water circulates along the wall of a fracture."""

from staffa.case.reading.read import parse_case
from staffa.case.schema.case import Case

WALL = """
[domain]
size = ["12 m", "6 m"]
h = "0.5 m"
[material]
plane = "stress"
E = "40 GPa"
nu = 0.25
Gc = "100 J/m^2"
expansion = "8e-6 1/K"
k = "2.5 W/(m K)"
rho = "2700 kg/m^3"
c = "850 J/(kg K)"
[damage]
law = "AT1"
ell = "1.5 m"
[toughness]
amplitude = 0.1
seed = 1
[temperature]
profile = "reservoir"
face = "bottom"
[supports]
left = "rollers"
right = "rollers"
top = "rollers"
[time]
t = ["1 d", "3 d", "6 d", "10 d"]
[measures]
depths = ["1 m"]
[output]
steps = "all"
[reservoir]
simulator = "darts"
temperature = "200 °C"
pressure = "20 MPa"
h = "1 m"
beyond = { top = "8 m" }
permeability = "1e-20 m^2"
porosity = 1e-3
water = { rho = "1000 kg/m^3", c = "4200 J/(kg K)", mu = "0.3 mPa s" }
fractures = [{ side = "bottom", opening = "0.2 mm", height = "0.2 m" }]
wells = [
  { name = "in", at = ["0 m", "0 m"], rate = "0.004 kg/s", T = "60 °C" },
  { name = "out", at = ["12 m", "0 m"], pressure = "20 MPa" },
]
"""
# Rock that nothing breaks.
STRONG = ('material.Gc="1e12 J/m^2"',)


def wall(*settings: str) -> Case:
    """Return the case, with settings put over it."""
    return parse_case(WALL, settings)
