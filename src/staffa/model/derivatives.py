"""Derivatives of the energy as vectors and matrices, assembled from its compiled forms."""

from staffa.backend.stack import MPI, PETSc

from dolfinx import fem, la
from dolfinx.fem import petsc as fem_petsc

from staffa.backend.parallel import sum_over_ranks
from staffa.model.fields import read_vector


class EnergyDerivatives:
    """Assembly of the energy's derivatives; `Energy` compiles the forms. Collective.

    Attributes
    ----------
    comm : communicator of the mesh.
    """

    comm: MPI.Comm
    _load: fem.Form
    _residual: fem.Form
    _gradient: fem.Form
    _resistance: fem.Form
    _stiffness: fem.Form
    _mixed: fem.Form
    _hessian: fem.Form
    _sums_u: fem.Function
    _sums_alpha: fem.Function

    def _integral(self, form: fem.Form) -> float:
        return float(sum_over_ranks(self.comm, fem.assemble_scalar(form)))

    def _vector(self, form: fem.Form, sums: fem.Function, out: PETSc.Vec) -> None:
        sums.x.array[:] = 0.0
        fem.assemble_vector(sums.x.array, form)
        sums.x.scatter_reverse(la.InsertMode.add)
        read_vector(sums, out)

    def _matrix(self, form: fem.Form, out: PETSc.Mat) -> None:
        out.zeroEntries()
        fem_petsc.assemble_matrix(out, form)
        out.assemble()

    def stiffness(self, out: PETSc.Mat) -> None:
        """Write the second derivative in u, without supports."""
        self._matrix(self._stiffness, out)

    def load(self, out: PETSc.Vec) -> None:
        """Write the forces of temperature and loads: minus the derivative in u at u = 0."""
        self._vector(self._load, self._sums_u, out)

    def residual(self, out: PETSc.Vec) -> None:
        """Write the derivative in u."""
        self._vector(self._residual, self._sums_u, out)

    def gradient(self, out: PETSc.Vec) -> None:
        """Write the derivative in alpha."""
        self._vector(self._gradient, self._sums_alpha, out)

    def hessian(self, out: PETSc.Mat) -> None:
        """Write the second derivative in alpha."""
        self._matrix(self._hessian, out)

    def mixed(self, out: PETSc.Mat) -> None:
        """Write the derivative in alpha, then in u: rows of alpha, columns of u."""
        self._matrix(self._mixed, out)

    def resistance(self, out: PETSc.Vec) -> None:
        """Write int Gc/(4 c_w ell) phi_i, the scale of the gradient in alpha."""
        self._vector(self._resistance, self._sums_alpha, out)

    def new_stiffness(self) -> PETSc.Mat:
        """Return a matrix that `stiffness` can fill; the caller destroys it."""
        return fem_petsc.create_matrix(self._stiffness)

    def new_mixed(self) -> PETSc.Mat:
        """Return a matrix that `mixed` can fill; the caller destroys it."""
        return fem_petsc.create_matrix(self._mixed)

    def new_hessian(self) -> PETSc.Mat:
        """Return a matrix that `hessian` can fill; the caller destroys it."""
        return fem_petsc.create_matrix(self._hessian)
