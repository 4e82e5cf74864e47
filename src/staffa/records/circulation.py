"""Records of the water that circulates in a step."""

from dataclasses import dataclass, field

from staffa.records.crack_flow import CrackFlow


@dataclass(frozen=True, kw_only=True)
class WellAccount:
    """Water of one well in a step.

    Attributes
    ----------
    mass
        Mass that the well brought into the rock (kg); negative where it took water out.
    heat
        Enthalpy that came with it (J).
    T
        Temperature of the water in the well at the end of the step (K).
    pressure
        Pressure in the well at the end of the step (Pa).
    """

    mass: float
    heat: float
    T: float
    pressure: float

    def then(self, later: "WellAccount") -> "WellAccount":
        """Return the account of this step and of the next one."""
        return WellAccount(
            mass=self.mass + later.mass,
            heat=self.heat + later.heat,
            T=later.T,
            pressure=later.pressure,
        )


@dataclass(frozen=True, kw_only=True)
class Circulation:
    """Account of a reservoir simulator in a step.

    Attributes
    ----------
    duration
        Length of the step (s).
    wells
        Account of each well, by its name.
    mass_stored
        Mass of water that the reservoir gained (kg).
    heat_stored
        Heat that the reservoir gained, beyond the rock's body too (J).
    cracks
        Cracks that the water flowed in; None where cracks do not change the flow.
    """

    duration: float
    wells: dict[str, WellAccount] = field(default_factory=dict)
    mass_stored: float = 0.0
    heat_stored: float = 0.0
    cracks: CrackFlow | None = None

    def then(self, later: "Circulation") -> "Circulation":
        """Return the account of this step and of the next one, of the same wells."""
        return Circulation(
            duration=self.duration + later.duration,
            wells={name: well.then(later.wells[name]) for name, well in self.wells.items()},
            mass_stored=self.mass_stored + later.mass_stored,
            heat_stored=self.heat_stored + later.heat_stored,
            cracks=later.cracks,
        )

    @property
    def imbalance(self) -> float:
        """Difference of the heat that wells brought and that was stored, over the larger one."""
        brought = sum(well.heat for well in self.wells.values())
        scale = max(abs(brought), abs(self.heat_stored))
        return abs(brought - self.heat_stored) / scale if scale else 0.0
