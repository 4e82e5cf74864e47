"""Properties of liquid water, in round numbers or to some percent, for estimates before a run."""

# From 60 to 200 °C and 10 to 40 MPa, within a factor of 2.
EXPANSION = 1e-3  # 1/K, of its volume
COMPRESSIBILITY = 6e-10  # 1/Pa


def viscosity(T: float) -> float:
    """Return the viscosity (Pa s) of liquid water at a temperature (K), within 4 % up to 350 °C.

    Al-Shemmeri, Engineering Fluid Mechanics (2012): 2.414e-5 10^(247.8/(T - 140)) Pa s.
    """
    return float(2.414e-5 * 10 ** (247.8 / (T - 140)))
