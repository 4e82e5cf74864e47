"""Named PETSc presets: what each is for, why its options are what they are, and their sources."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from staffa.backend.stack import PETSc

from staffa.backend.parallel import require_together
from staffa.errors import SolveError

# The stiffness is symmetric positive definite (the residual stiffness sees to that), so Cholesky
# does half the work of LU: measured 1.5 times faster a solve on the slab at 25k unknowns.
# The factorization preconditions CG: one iteration where it is new, a few where the stiffness has
# changed a little since. MUMPS estimates its work space from the pattern; with its own margin it
# ran out of it (INFOG(1) = -9) on a plate of 6600 unknowns on 3 ranks. Large fronts are eliminated
# by the blocks of its low-rank format, in which nothing is compressed (users' guide, ICNTL 35, 36,
# CNTL 7 = 0): a sixth less time on 460k unknowns in 2-D, none on 126k. CNTL 7 = 1e-14 took another
# sixth off, but counts in units of the stiffness, and with one of 1e-9 the solution was wrong.
DIRECT = {
    "ksp_type": "cg",
    "ksp_rtol": "1e-10",
    "ksp_max_it": "8",
    "ksp_norm_type": "unpreconditioned",
    "pc_type": "cholesky",
    "pc_factor_mat_solver_type": "mumps",
    "mat_mumps_icntl_14": "100",
    "mat_mumps_icntl_35": "2",
    "mat_mumps_icntl_36": "1",
}

# Smoothed aggregation with the rigid-body modes as near-null space is the standard for elasticity
# (PETSc manual, PCGAMG; ex56). No coupling is dropped: a positive threshold makes aggregates of one
# vertex, with fewer unknowns than rigid modes, on which the coarse matrix is singular; for the same
# reason coarsening ends early. The coarsest solver stays PCGAMG's own, whose LU shifts zero pivots.
# Interpolation, most of the work, is kept from one preconditioner to the next within a step.
# Chebyshev's method must cover the whole spectrum, or it is not positive definite. The estimate is
# too low by a tenth and more where tetrahedra are broken: 1.1 of it, the default, failed on a
# refined brick of 76k unknowns, which a factorization then took over; 1.2 and more took 11
# iterations. On a brick of hexahedra 1.3 takes as many iterations as 1.1.
ITERATIVE = {
    "ksp_type": "cg",
    "ksp_rtol": "1e-8",
    "ksp_max_it": "1000",
    "ksp_norm_type": "unpreconditioned",
    "pc_type": "gamg",
    "pc_gamg_threshold": "-1",
    "pc_gamg_coarse_eq_limit": "300",
    "mg_levels_ksp_type": "chebyshev",
    "mg_levels_pc_type": "jacobi",
    "mg_levels_ksp_chebyshev_esteig": "0,0.1,0,1.3",
}

# The damage Hessian is a mass matrix plus ell^2 times a Laplacian: its condition number is about
# (ell/h)^2, so CG with a pointwise preconditioner does, and does the same on any number of ranks.
# Projected Newton with a line search: a full step is exact for AT1 and AT2, whose energy is
# quadratic in alpha; measured 1.5 iterations a sweep on the slab, against 4 to 30 for bntr, gpcg
# and blmvm. The active-set tolerance is that of SNES's own solver: with TAO's default, 1e-3, damage
# just above its bound counts as held. An iteration frees one layer of cells around a crack, so
# cells of ell/64 take more than a hundred.
TAO = {
    "tao_type": "bnls",
    "tao_max_it": "1000",
    "tao_bnk_as_tol": "1e-8",
    "tao_bnk_ksp_rtol": "1e-6",
    "tao_bnk_pc_type": "jacobi",
}

# Reduced-space active set of Benson and Munson (2006), with a line search that is a full step
# whenever that lowers the residual. PETSc's SNES ends where the residual is 1e4 of the first one:
# of a body that is nearly at rest that is next to nothing.
SNES = {
    "snes_type": "vinewtonrsls",
    "snes_max_it": "1000",
    "snes_divergence_tolerance": "1e30",
    "snes_linesearch_type": "basic",
    "ksp_type": "cg",
    "ksp_rtol": "1e-6",
    "pc_type": "jacobi",
}

# Preconditioner of the damage within Newton's move: as many steps of Chebyshev's method on the
# Hessian scaled by its diagonal, so that it is linear, symmetric, and the same on any number of
# ranks (its spectrum is estimated from the right-hand side, not from random numbers). On the slab
# and the brick of the benchmark 5 or 10 steps took as many outer iterations as a factorization.
NEWTON = {
    "ksp_type": "chebyshev",
    "ksp_max_it": "8",
    "ksp_norm_type": "none",
    "ksp_chebyshev_esteig": "0,0.05,0,1.1",
    "ksp_chebyshev_esteig_noisy": "false",
    "pc_type": "jacobi",
}

# The second derivative of the energy may be indefinite: MUMPS' LDL^T gives its inertia with its
# factors (Sylvester). It counts them right only where null pivots are looked for and the last front
# is not handed to ScaLAPACK (MUMPS users' guide, ICNTL 24 and 13).
INERTIA = {
    "ksp_type": "preonly",
    "pc_type": "cholesky",
    "pc_factor_mat_solver_type": "mumps",
    "mat_mumps_icntl_24": "1",
    "mat_mumps_icntl_13": "1",
    "mat_mumps_icntl_14": "100",
}

# Bounded quadratic problems in displacement and damage together: each active set is solved for
# exactly, for CG without a good preconditioner takes thousands of iterations on the two of them.
ON_THE_CONE = {
    "snes_type": "vinewtonrsls",
    "snes_max_it": "200",
    "snes_divergence_tolerance": "1e30",
    "snes_linesearch_type": "basic",
    **INERTIA,
}

# Capacity and conduction over steps that end while heat still diffuses: the capacity on the
# diagonal keeps the condition number at 8 kappa dt/h^2 or so, and CG scaled by the diagonal takes
# tens of iterations; multigrid and a factorization took longer on the slab. Tight, since what
# enters is held against what is stored.
HEAT = {
    "ksp_type": "cg",
    "ksp_rtol": "1e-11",
    "ksp_max_it": "20000",
    "ksp_norm_type": "unpreconditioned",
    "pc_type": "jacobi",
}

# Of Newton's method, whose matrix is not symmetric where the conductivity depends on temperature;
# what a step is off by, the next one makes up for.
HEAT_NEWTON = {
    "ksp_type": "bcgs",
    "ksp_rtol": "1e-8",
    "ksp_atol": "1e-200",
    "ksp_max_it": "5000",
    "pc_type": "bjacobi",
    "sub_pc_type": "ilu",
}

DISPLACEMENT = {"direct": DIRECT, "iterative": ITERATIVE}
DAMAGE = {"tao": TAO, "snes": SNES}
ACCELERATION = {"newton": NEWTON, "none": None}


def apply(prefix: str, preset: Mapping[str, str]) -> None:
    """Set the options of a preset under a prefix; options set by PETSC_OPTIONS there stay."""
    options = PETSc.Options()
    if not options.hasName("options_left"):
        options.setValue("options_left", "no")  # a preset serves more than one solver type
    for key, value in preset.items():
        if not options.hasName(prefix + key):
            options.setValue(prefix + key, value)


@contextmanager
def petsc_errors(what: str, comm: PETSc.Comm) -> Iterator[None]:
    """Turn an error that PETSc raises, on NaN in most cases, into the failure of a solver.

    What broke off in a call back to Python comes as a SystemError, with its cause.

    Raises
    ------
    SolveError
        On all ranks.
    AloneError
        PETSc raised it on some only, and the others wait within it.
    """
    try:
        yield
    except (PETSc.Error, SystemError) as error:
        causes = tuple(_causes(error))
        if any(isinstance(cause, KeyboardInterrupt) for cause in causes):
            raise
        numbers = [cause.ierr for cause in causes if isinstance(cause, PETSc.Error)]
        if not numbers:
            raise
        failure = SolveError(f"{what}: PETSc stopped with error {numbers[0]}")
        require_together(comm.tompi4py(), failure)
        raise failure from error


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__
