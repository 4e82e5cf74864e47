"""Properties of water, as open-DARTS asks for them.

The simulator's own Python runs this file; nothing of staffa is imported.
"""

from typing import Any

from darts.physics.base.property_container import PropertyContainer
from darts.physics.properties.basic import ConstFunc, PhaseRelPerm

BAR = 1e5  # Pa
KILO = 1e3
MOLAR = 18.015  # kg/kmol
COMPRESSIBILITY = 1e-12  # 1/Pa, of constant water, so that a closed reservoir has a pressure


def iapws() -> Any:
    """Return water and steam after IAPWS-95."""
    from darts.physics.properties.eos_properties import EoSDensity, EoSEnthalpy
    from darts.physics.properties.viscosity import MaoDuan2009
    from dartsflash.mixtures import IAPWS, CompData, DARTSFlash, EoS

    components, phases = ["H2O"], ["V", "L"]
    of = CompData(components=components, setprops=True)
    made = PropertyContainer(phases_name=phases, components_name=components, Mw=of.Mw, eps_z=1e-12)
    flash = IAPWS(iapws_ideal=True, ice_phase=False)
    flash.init_flash(flash_type=DARTSFlash.FlashType.PTFlash)
    roots = {"V": EoS.RootFlag.MAX, "L": EoS.RootFlag.MIN}
    law = {"eos": flash.eos["IAPWS"]}
    made.flash_ev = flash
    made.density_ev = {name: EoSDensity(root_flag=root, **law) for name, root in roots.items()}
    made.enthalpy_ev = {name: EoSEnthalpy(root_flag=root, **law) for name, root in roots.items()}
    made.viscosity_ev = {"V": ConstFunc(0.02), "L": MaoDuan2009(components)}
    made.rel_perm_ev = {"V": PhaseRelPerm("gas", swc=0.0), "L": PhaseRelPerm("oil", swc=0.0)}
    # The conductivity of a cell is that of its rock with its water.
    made.conductivity_ev = {name: ConstFunc(0.0) for name in phases}
    return made


def constant(rho: float, c: float, mu: float, p: float) -> Any:
    """Return a liquid of constant properties.

    Parameters
    ----------
    rho : density (kg/m^3).
    c : specific heat (J/(kg K)).
    mu : viscosity (Pa s).
    p : pressure (Pa) at which the density is exact.
    """
    made = PropertyContainer(
        phases_name=["L"], components_name=["H2O"], Mw=[MOLAR], eps_z=1e-12, rock_comp=0.0
    )
    made.flash_ev = _OneLiquid()
    made.density_ev = {"L": _Law(lambda bar, T: rho * (1 + COMPRESSIBILITY * (BAR * bar - p)))}
    # In kJ/kmol. The term of pressure makes the internal energy c T alone.
    made.enthalpy_ev = {
        "L": _Law(lambda bar, T: MOLAR * (c / KILO * (T - 273.15) + BAR / KILO * bar / rho))
    }
    made.viscosity_ev = {"L": ConstFunc(mu * KILO)}
    made.rel_perm_ev = {"L": ConstFunc(1.0)}
    made.conductivity_ev = {"L": ConstFunc(0.0)}
    return made


class _Law:
    """A property as open-DARTS asks for it."""

    def __init__(self, law: Any) -> None:
        self.law = law

    def evaluate(self, p: float, T: float = 0.0, x: Any = None) -> float:
        return float(self.law(p, T))


class _OneLiquid:
    """One component in one liquid phase."""

    nu, X, temperature = (1.0,), (1.0,), 0.0

    def evaluate(self, p: float, T: float, z: Any, evaluate_PT: bool = False) -> int:
        self.nu, self.X, self.temperature = [1.0], [1.0], T  # type: ignore[assignment]
        return 0

    def get_flash_results(self, *_: Any, **__: Any) -> "_OneLiquid":
        return self
