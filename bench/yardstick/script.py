"""Alternate minimization as a capable FEniCSx user writes it in an afternoon: the yardstick.

UFL forms; stiffness assembled and factorized again at each sweep in 2-D (MUMPS Cholesky), CG with
GAMG set up at each sweep in 3-D; SNES vinewtonrsls on the damage; stop on max |change of alpha|.
Nothing of staffa is used here but the order in which it loads the libraries.
"""

from collections import Counter
from time import perf_counter

from staffa.backend.stack import MPI, PETSc

import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem import petsc as fp

from bench.common.cases import BenchCase


class Script:
    """The whole computation; `step(time)` marches on. Collective."""

    def __init__(self, case: BenchCase, comm: MPI.Comm) -> None:
        self.case, self.comm, self.phases = case, comm, Counter()
        dim = case.dim
        corners = [np.zeros(dim), np.array(case.size)]
        if dim == 2:
            domain = mesh.create_rectangle(comm, corners, case.counts, mesh.CellType.quadrilateral)
        else:
            domain = mesh.create_box(comm, corners, case.counts, mesh.CellType.hexahedron)
        V = fem.functionspace(domain, ("Lagrange", 1, (dim,)))
        W = fem.functionspace(domain, ("Lagrange", 1))
        self.u, self.alpha, self.T = fem.Function(V), fem.Function(W), fem.Function(W)
        self.before = fem.Function(W)
        self.lower, self.upper = fem.Function(W), fem.Function(W)
        self.x = W.tabulate_dof_coordinates().T
        self.upper.x.array[:] = 1.0
        notch = case.cracked(self.x)
        self.alpha.x.array[notch] = self.lower.x.array[notch] = 1.0
        Gc = fem.Function(fem.functionspace(domain, ("Discontinuous Lagrange", 0)))
        Gc.x.array[:] = case.toughness(Gc.function_space.tabulate_dof_coordinates().T)

        u, alpha, ell, nu = self.u, self.alpha, case.ell, case.nu
        mu = 1 / (2 * (1 + nu))
        lam = nu / (1 - nu**2) if dim == 2 else nu / ((1 + nu) * (1 - 2 * nu))
        e = ufl.sym(ufl.grad(u)) - self.T * ufl.Identity(dim)
        psi = lam / 2 * ufl.tr(e) ** 2 + mu * ufl.inner(e, e)
        w, c_w = (alpha, 2 / 3) if case.law == "AT1" else (alpha**2, 1 / 2)
        grad2 = ufl.dot(ufl.grad(alpha), ufl.grad(alpha))
        dx = ufl.Measure("dx", domain, metadata={"quadrature_degree": 2})
        elastic = ((1 - alpha) ** 2 + case.residual_stiffness) * psi * dx
        total = elastic + Gc / (4 * c_w) * (w / ell + ell * grad2) * dx

        v, beta = ufl.TestFunction(V), ufl.TestFunction(W)
        du, dalpha = ufl.TrialFunction(V), ufl.TrialFunction(W)
        equation = ufl.replace(ufl.derivative(elastic, u, v), {u: du})
        self.energy = fem.form(total)
        self.K_form, self.f_form = fem.form(ufl.lhs(equation)), fem.form(ufl.rhs(equation))
        gradient = ufl.derivative(total, alpha, beta)
        self.g_form = fem.form(gradient)
        self.H_form = fem.form(ufl.derivative(gradient, alpha, dalpha))

        self.pulled = fem.Constant(domain, 0.0)
        self.bcs = self._pull(V) if not case.severity else self._rollers(V)
        self.K, self.f = fp.create_matrix(self.K_form), fp.create_vector(V)
        self.ksp = PETSc.KSP().create(comm)
        self.ksp.setOperators(self.K)
        self.ksp.setOptionsPrefix("script_u_")
        options = PETSc.Options()
        if dim == 2:
            options_u = {
                "ksp_type": "preonly",
                "pc_type": "cholesky",
                "pc_factor_mat_solver_type": "mumps",
            }
            self.K.setOption(PETSc.Mat.Option.SPD, True)
        else:
            options_u = {
                "ksp_type": "cg",
                "ksp_rtol": 1e-8,
                "ksp_norm_type": "unpreconditioned",
                "pc_type": "gamg",
                "pc_gamg_threshold": -1,
                "mg_levels_ksp_type": "chebyshev",
                "mg_levels_pc_type": "jacobi",
            }
            self.K.setNearNullSpace(self._rigid_modes(V))
            self.ksp.setInitialGuessNonzero(True)
        for key, value in options_u.items():
            options[f"script_u_{key}"] = value
        self.ksp.setFromOptions()

        self.H, self.g = fp.create_matrix(self.H_form), fp.create_vector(W)
        self.snes = PETSc.SNES().create(comm)
        self.snes.setOptionsPrefix("script_alpha_")
        options_alpha = {
            "snes_type": "vinewtonrsls",
            "snes_linesearch_type": "basic",
            "snes_atol": 1e-8,
            "snes_rtol": 1e-6,
            "snes_stol": 0.0,
            "snes_max_it": 50,
            "ksp_type": "cg",
            "ksp_rtol": 1e-5,
            "pc_type": "jacobi",
        }
        for key, value in options_alpha.items():
            options[f"script_alpha_{key}"] = value
        self.snes.setFunction(self._gradient, self.g)
        self.snes.setJacobian(self._hessian, self.H)
        self.snes.setFromOptions()

    def _component(self, V: fem.FunctionSpace, axis: int, where) -> np.ndarray:
        return fem.locate_dofs_geometrical((V.sub(axis), V.sub(axis).collapse()[0]), where)[0]

    def _rollers(self, V: fem.FunctionSpace) -> list[fem.DirichletBC]:
        """No displacement across the sides, and one vertex of the far face held."""
        size, top = self.case.size, self.case.dim - 1
        bcs = []
        for axis in range(top):
            for end in (0.0, size[axis]):
                dofs = self._component(V, axis, lambda x, a=axis, e=end: np.isclose(x[a], e))
                bcs.append(fem.dirichletbc(0.0, dofs, V.sub(axis)))
        corner = np.array(size)[:, None]
        dofs = self._component(V, top, lambda x: np.all(np.isclose(x[: top + 1], corner), axis=0))
        return [*bcs, fem.dirichletbc(0.0, dofs, V.sub(top))]

    def _pull(self, V: fem.FunctionSpace) -> list[fem.DirichletBC]:
        """The bottom clamped, the top pulled upwards."""
        height = self.case.size[1]
        bcs = []
        for axis, value in ((0, 0.0), (1, self.pulled)):
            low = self._component(V, axis, lambda x: np.isclose(x[1], 0.0))
            high = self._component(V, axis, lambda x: np.isclose(x[1], height))
            bcs.append(fem.dirichletbc(0.0, low, V.sub(axis)))
            bcs.append(fem.dirichletbc(value, high, V.sub(axis)))
        return bcs

    def _rigid_modes(self, V: fem.FunctionSpace) -> PETSc.NullSpace:
        x = V.tabulate_dof_coordinates()[: V.dofmap.index_map.size_local]
        modes = [self.f.duplicate() for _ in range(6)]
        for axis in range(3):
            modes[axis].array_w[axis::3] = 1.0
        for k, (i, j) in enumerate([(0, 1), (1, 2), (2, 0)]):
            modes[3 + k].array_w[i::3] = -x[:, j]
            modes[3 + k].array_w[j::3] = x[:, i]
        orthonormal = []
        for mode in modes:
            for other in orthonormal:
                mode.axpy(-mode.dot(other), other)
            mode.normalize()
            orthonormal.append(mode)
        return PETSc.NullSpace().create(vectors=orthonormal, comm=self.comm)

    def _keep(self, x: PETSc.Vec) -> None:
        x.ghostUpdate(PETSc.InsertMode.INSERT, PETSc.ScatterMode.FORWARD)
        with x.localForm() as local:
            self.alpha.x.array[:] = local.array_r

    def _gradient(self, snes: PETSc.SNES, x: PETSc.Vec, g: PETSc.Vec) -> None:
        started = perf_counter()
        self._keep(x)
        with g.localForm() as local:
            local.set(0.0)
        fp.assemble_vector(g, self.g_form)
        g.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        self.phases["damage assembly"] += perf_counter() - started

    def _hessian(self, snes: PETSc.SNES, x: PETSc.Vec, H: PETSc.Mat, P: PETSc.Mat) -> None:
        started = perf_counter()
        self._keep(x)
        H.zeroEntries()
        fp.assemble_matrix(H, self.H_form)
        H.assemble()
        self.phases["damage assembly"] += perf_counter() - started

    def _solve_u(self) -> None:
        t0 = perf_counter()
        self.K.zeroEntries()
        fp.assemble_matrix(self.K, self.K_form, bcs=self.bcs)
        self.K.assemble()
        with self.f.localForm() as local:
            local.set(0.0)
        fp.assemble_vector(self.f, self.f_form)
        fp.apply_lifting(self.f, [self.K_form], [self.bcs])
        self.f.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        fp.set_bc(self.f, self.bcs)
        t1 = perf_counter()
        self.ksp.setOperators(self.K)  # tells it that the entries are new
        self.ksp.setUp()
        self.ksp.pc.setUpOnBlocks()
        t2 = perf_counter()
        self.ksp.solve(self.f, self.u.x.petsc_vec)
        self.u.x.scatter_forward()
        t3 = perf_counter()
        assert self.ksp.getConvergedReason() > 0
        self.phases["stiffness assembly"] += t1 - t0
        self.phases["factorization or set-up"] += t2 - t1
        self.phases["solve"] += t3 - t2

    def _solve_alpha(self) -> None:
        t0, assembly = perf_counter(), self.phases["damage assembly"]
        self.snes.setVariableBounds(self.lower.x.petsc_vec, self.upper.x.petsc_vec)
        self.snes.solve(None, self.alpha.x.petsc_vec)
        self.alpha.x.scatter_forward()
        assert self.snes.getConvergedReason() > 0
        within = self.phases["damage assembly"] - assembly
        self.phases["damage solve"] += perf_counter() - t0 - within

    def total_energy(self) -> float:
        """Elastic plus surface energy."""
        return self.comm.allreduce(fem.assemble_scalar(self.energy))

    def step(self, time: float) -> int:
        """Minimize at a time from the state so far; the number of sweeps."""
        if self.case.severity:
            self.T.x.array[:] = self.case.temperature(self.x, time)
        else:
            self.pulled.value = time
        self.lower.x.array[:] = self.alpha.x.array
        for sweep in range(1, 10_000):
            self.before.x.array[:] = self.alpha.x.array
            self._solve_u()
            self._solve_alpha()
            change = np.abs(self.alpha.x.array - self.before.x.array).max()
            if self.comm.allreduce(change, op=MPI.MAX) <= self.case.tolerance:
                return sweep
        raise RuntimeError("not converged")

    def state(self) -> dict[str, np.ndarray]:
        """Displacement and damage on this rank, ghosts included, and their places."""
        return {"u": self.u.x.array, "alpha": self.alpha.x.array, "x": self.x}
