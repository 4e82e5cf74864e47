"""A reservoir of open-DARTS 2.0 made of cells and faces, in SI units.

The simulator's own Python runs this file; nothing of staffa is imported. The units of open-DARTS
(bar, day, kJ, kmol) stay in here. FlowCells and faces come from staffa, so no axis is special.
"""

# This import comes before every other one: the wheel brings its own libstdc++, which is found
# only as long as no other one has been loaded, by NumPy for instance.
import darts.engines as engines  # isort: skip

from typing import Any

import numpy as np
from darts.models.darts_model import DartsModel
from darts.nonlinear_solvers import NewtonSolver, OBLBoundsSpec
from darts.physics.base.physics import PhysicsBase
from darts.reservoirs.reservoir_base import ReservoirBase
from darts_water import BAR, KILO, constant, iapws

DAY = 86400.0  # s
FLOW = DAY * BAR / 1e-3  # m^3 of k A/d to m^3 cP/(day bar)
HEAT = DAY / KILO  # W/K to kJ/(day K)
# Newton's tolerance, over what the cells hold. A smaller one is not always reached.
TOLERANCE = 1e-6
TABLE = (2.0, 2.0)  # distance of supporting points of the properties, bar and K
LIMITS = {  # bar and K, in which Newton's method stays
    "iapws": ([1.0, 274.0], [2000.0, 640.0]),
    "constant": ([-1e6, 1.0], [1e6, 5000.0]),
}


class BalancedNewton(NewtonSolver):  # type: ignore[misc]
    """Newton's method that takes one more step once its tolerance is met.

    The tolerance is relative to what the cells hold, which may be a million times what wells bring
    in a step. The step more brings their balance from 1e-4 to 1e-11 in a doublet.
    """

    met = 0

    def run_timestep(self, dt: float, t: float, verbose: int | None = None) -> bool:
        """Take a time step of dt days at t days; `verbose` is as in open-DARTS."""
        self.met = 0
        return bool(super().run_timestep(dt, t, verbose))

    def compute_reservoir_residual(self) -> float:
        """Return the residual, or a little more than the tolerance when it is met first."""
        residual = float(super().compute_reservoir_residual())
        self.met += residual < TOLERANCE
        return 1.1 * TOLERANCE if self.met == 1 and residual < TOLERANCE else residual


class FlowCells(ReservoirBase):  # type: ignore[misc]
    """Mesh of cells, faces and wells.

    Parameters
    ----------
    timer : that of the model.
    arrays : arrays by name, as `staffa.reservoir.darts` lists them.
    """

    def __init__(self, timer: Any, arrays: dict[str, np.ndarray]) -> None:
        super().__init__(timer)
        self.arrays = arrays

    def discretize(self, verbose: bool = False) -> Any:
        """Return the mesh without wells."""
        a, mesh = self.arrays, engines.conn_mesh()
        mesh.init(
            engines.index_vector(a["lower"].astype(np.int32)),
            engines.index_vector(a["upper"].astype(np.int32)),
            engines.value_vector(a["flow"] * FLOW),
            engines.value_vector(a["conduction"] * HEAT),
        )
        view(mesh.volume)[:] = a["volume"]
        porosity = np.minimum(a["porosity"], 1 - 1e-6)  # rock that is not there conducts no heat
        view(mesh.poro)[:] = porosity
        # The conductance is that of the whole face; the engine multiplies it by this, and 1 - phi.
        view(mesh.rock_cond)[:] = 1 / (1 - porosity)
        view(mesh.heat_capacity)[:] = a["rho_c"] / KILO
        view(mesh.depth)[:] = a["depth"]
        view(mesh.op_num)[:] = 0
        return mesh

    def add_perforation(self, well_name: str, res_cell_idx: int) -> None:
        """Open a well to a cell, with an index that `set_flow` sets later."""
        well = self.get_well(well_name)
        depth = float(view(self.mesh.depth)[res_cell_idx])
        if not well.perforations:
            well.well_head_depth = well.well_body_depth = depth
            well.segment_depth_increment = 0.0
        well.well_head_depth = well.well_body_depth = min(well.well_head_depth, depth)
        well.perforations = [*well.perforations, (0, res_cell_idx, 1.0, 0.0)]

    def set_boundary_volume(self, boundary_volumes: dict[str, Any]) -> None:
        """Do nothing: no cell is larger than it is."""

    def find_cell_index(self, coord: Any) -> int:
        """Return nothing of use: cells are known by their index."""
        raise NotImplementedError

    def init_vtk(self, output_directory: str, export_grid_data: bool = True) -> None:
        """Write nothing."""

    def output_to_vtk(self, *_: Any, **__: Any) -> None:
        """Write nothing."""


class Reservoir(DartsModel):  # type: ignore[misc]
    """Rock, water and wells, with their state at one time.

    Parameters
    ----------
    head : water and wells.
    arrays : arrays by name.
    """

    def __init__(self, head: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
        super().__init__()
        engines.set_num_threads(1)
        self.verbose = 0
        self.head, self.arrays = head, arrays
        self.n_cells = len(arrays["volume"])
        self.reservoir = FlowCells(self.timer, arrays)
        water = head["water"]
        self.limits = LIMITS["constant" if water else "iapws"]
        self.properties = constant(**water) if water else iapws()
        self.physics = PhysicsBase(
            self.properties.components_name, self.properties.phases_name, self.timer,
            state_spec=PhysicsBase.StateSpecification.PT,
            axes_step=list(TABLE), axes_origin=[1.0, 273.15], epsilon_z=1e-12,
        )  # fmt: skip
        self.physics.add_property_region(self.properties)
        self.init(verbose=0)
        self._find_wells()
        self.set_flow(arrays["flow"], arrays["index"])
        self._evaluate()

    # Hooks that open-DARTS calls, in its own words.

    def set_solver(self) -> None:
        """Choose Newton's method with bounds.

        Outside of them properties are not numbers, and one such value stays in the table.
        """
        if getattr(self, "nonlinear_solver", None) is None:
            low, high = self.limits
            bounds = OBLBoundsSpec(mode="obl_axes", axis_min=low, axis_max=high)
            self.nonlinear_solver = BalancedNewton(
                tolerance=TOLERANCE, max_iterations=20, obl_bounds=bounds
            )
        super().set_solver()
        self.linear_solver.spec.tolerance = 1e-2 * TOLERANCE

    def set_wells(self, verbose: Any = None) -> None:
        """Make the wells."""
        for well in self.head["wells"]:
            self.reservoir.add_well(well["name"], well_diameter=2 * well["radius"])
            for cell in well["cells"]:
                self.reservoir.add_perforation(well["name"], cell)
            made = self.reservoir.get_well(well["name"])
            made.segment_volume *= well["length"]

    def set_initial_conditions(self) -> None:
        """Set pressure and temperature of the cells."""
        start = {"pressure": self.arrays["p"] / BAR, "temperature": self.arrays["T"]}
        self.physics.set_initial_conditions_from_array(self.reservoir.mesh, start)

    def set_well_controls(self) -> None:
        """Set what is given of each well: mass rate or pressure."""
        for well, told in zip(self.reservoir.wells, self.head["wells"], strict=True):
            injects = told["T"] is not None
            water = {"inj_composition": [], "inj_temp": told["T"]} if injects else {}
            kind, value = engines.well_control_iface.BHP, told["pressure"]
            if told["rate"] is not None:
                kind, value = engines.well_control_iface.MASS_RATE, abs(told["rate"]) * DAY
                water["phase_name"] = "L"
            else:
                value = value / BAR
            self.physics.set_well_controls(well.control, kind, injects, value, **water)

    # What the server calls, in SI units.

    def set_flow(self, flow: np.ndarray, index: np.ndarray) -> None:
        """Set the permeability, as flow through faces and well indices.

        Parameters
        ----------
        flow : k A/d of each face (m^3), shape (n_faces,).
        index : index of each opening of each well (m^3), in the order of the wells.
        """
        mesh = self.reservoir.mesh
        conduction = self.arrays["conduction"] * HEAT
        mesh.set_res_tran(engines.value_vector(flow * FLOW), engines.value_vector(conduction))
        both = view(mesh.tran)
        for number, connections in enumerate(self.openings):
            both[connections] = index[number] * FLOW

    def state(self) -> np.ndarray:
        """Return all that the next step depends on: unknowns and properties of all blocks."""
        engine = self.physics.engine
        return np.concatenate([np.array(engine.X), np.array(engine.op_vals_arr)])

    def put(self, state: np.ndarray) -> None:
        """Set the state."""
        engine = self.physics.engine
        n = len(view(engine.X))
        for name in ("X", "Xn"):
            view(getattr(engine, name))[:] = state[:n]
        for name in ("op_vals_arr", "op_vals_arr_n"):
            view(getattr(engine, name))[:] = state[n:]

    def step(self, duration: float) -> bool:
        """Take one implicit step and return whether it converged.

        Parameters
        ----------
        duration : its length (s).
        """
        self.physics.engine.t = 0.0
        done = bool(self.run_timestep(duration / DAY, 0.0, 0))
        return done and bool(np.isfinite(view(self.physics.engine.X)).all())

    def fields(self) -> tuple[np.ndarray, np.ndarray]:
        """Return pressure (Pa) and temperature (K) of the cells."""
        unknowns = np.array(self.physics.engine.X).reshape(-1, 2)[: self.n_cells]
        return unknowns[:, 0] * BAR, unknowns[:, 1].copy()

    def wells_now(self) -> list[dict[str, float]]:
        """Return mass (kg/s) and heat (W) into the rock, pressure (Pa) and T (K) of each well."""
        unknowns = view(self.physics.engine.X).reshape(-1, 2)
        found = []
        for well, of_well in zip(self.reservoir.wells, self.flows, strict=True):
            mass = heat = 0.0
            for connection, inside, cell in of_well:
                one = self._through(connection, inside, cell)
                mass, heat = mass + one[0], heat + one[1]
            p, T = unknowns[well.well_body_idx]
            found.append({"mass": mass, "heat": heat, "pressure": float(p) * BAR, "T": float(T)})
        return found

    def stored(self) -> tuple[float, float]:
        """Return the water (kg) and the heat (J) in the cells, wells left out."""
        n, of, mesh = self.n_cells, self.operators, self.reservoir.mesh
        values = self._values()[:n]
        volume, porosity, rho_c = (
            view(a)[:n] for a in (mesh.volume, mesh.poro, mesh.heat_capacity)
        )
        pores, rock = volume * porosity, volume * (1 - porosity) * rho_c
        mass = (pores * values[:, of.ACC_OP]).sum() * self.properties.Mw[0]
        heat = (pores * values[:, of.ACC_OP + 1] + rock * values[:, of.TEMP_OP]).sum() * KILO
        return float(mass), float(heat)

    def _through(self, connection: int, inside: int, cell: int) -> tuple[float, float]:
        """Return mass (kg/s) and heat (W) from a well's block into a cell."""
        values, of, mesh = self._values(), self.operators, self.reservoir.mesh
        unknowns = view(self.physics.engine.X).reshape(-1, 2)
        mass = heat = 0.0
        for phase in range(of.nph):
            weight = 0.5 * (values[inside, of.GRAV_OP + phase] + values[cell, of.GRAV_OP + phase])
            difference = unknowns[inside, 0] - unknowns[cell, 0]
            difference -= weight * view(mesh.grav_coef)[connection]
            up = values[inside if difference > 0 else cell]
            flow = view(mesh.tran)[connection] * difference * up[of.LAMBDA_OP + phase]
            mass += flow * up[of.FLUX_OP + phase * of.ne] * self.properties.Mw[0] / DAY
            heat += flow * up[of.FLUX_OP + phase * of.ne + 1] * KILO / DAY
        return float(mass), float(heat)

    def _values(self) -> np.ndarray:
        """Return the properties of all blocks, shape (n_blocks, n_operators)."""
        return view(self.physics.engine.op_vals_arr).reshape(-1, self.operators.n_ops)

    def _find_wells(self) -> None:
        """Find the connections of the wells: both directions, and that out of the well."""
        mesh = self.reservoir.mesh
        self.operators = self.physics.reservoir_operators[0]
        first, second = np.array(mesh.block_m), np.array(mesh.block_p)
        self.openings: list[np.ndarray] = []
        self.flows: list[list[tuple[int, int, int]]] = []
        for well in self.reservoir.wells:
            self.flows.append([])
            for segment, cell, *_ in well.perforations:
                inside = well.well_body_idx + segment
                out = np.flatnonzero((first == inside) & (second == cell))
                back = np.flatnonzero((first == cell) & (second == inside))
                self.openings.append(np.concatenate([out, back]))
                self.flows[-1] += [(int(c), inside, cell) for c in out]

    def _evaluate(self) -> None:
        """Evaluate the properties of the first state, so that a state says everything."""
        unknowns = np.array(self.physics.engine.X)
        n = len(unknowns) // 2
        values = engines.value_vector(np.zeros(n * self.operators.n_ops))
        slopes = engines.value_vector(np.zeros(n * self.operators.n_ops * 2))
        blocks = engines.index_vector(np.arange(n, dtype=np.int32))
        table = self.physics.acc_flux_itor[0]
        table.evaluate_with_derivatives(engines.value_vector(unknowns), blocks, values, slopes)
        self.put(np.concatenate([unknowns, np.array(values)]))


def view(vector: Any) -> np.ndarray:
    """Return the numbers of a vector of open-DARTS, which can be written to."""
    return np.array(vector, copy=False)
