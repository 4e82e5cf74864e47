"""Saturation pressure of water, below which it boils."""

import numpy as np

CRITICAL_T = 647.096  # K
CRITICAL_P = 22.064e6  # Pa
# Factors and powers of 1 - T/CRITICAL_T: Wagner and Pruss, J. Phys. Chem. Ref. Data 31 (2002),
# equation 2.5, within 0.1 % from the triple point to the critical point.
FACTORS = (-7.85951783, 1.84408259, -11.7866497, 22.6807411, -15.9618719, 1.80122502)
POWERS = (1.0, 1.5, 3.0, 3.5, 4.0, 7.5)


def saturation_pressure(T: np.ndarray) -> np.ndarray:
    """Return the pressure (Pa) below which water of these temperatures (K) boils, same shape.

    ln(p/p_c) = T_c/T sum a_i (1 - T/T_c)^n_i. Beyond the critical point it is the critical
    pressure.
    """
    T = np.minimum(np.asarray(T, dtype=float), CRITICAL_T)
    away = 1 - T / CRITICAL_T
    total = sum(a * away**n for a, n in zip(FACTORS, POWERS, strict=True))
    return np.asarray(CRITICAL_P * np.exp(CRITICAL_T / T * total))
