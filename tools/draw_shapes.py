"""Draw docs/pictures/shapes.png, the shapes of docs/how-to/geometry.md with names of their parts:
.venv/bin/python tools/draw_shapes.py"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import Patch
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from staffa.geometry.shapes import Bored, Layered, Round, Shape, meshed
from staffa.geometry.simplices import Simplices

PICTURE = Path(__file__).parent.parent / "docs" / "pictures" / "shapes.png"
LAYERS = (("shale", 0.3), ("sand", 0.25), ("shale", 0.25))
SHAPES: dict[str, tuple[Shape, float]] = {
    "plate with hole": (Bored(size=(1.0, 0.8), radius=0.2, center=(0.5, 0.4)), 0.06),
    "disc": (Round(radius=0.4), 0.06),
    "layers, a base of one number": (Layered(base=(1.0,), layers=LAYERS), 0.06),
    "wellbore": (Bored(size=(1.0, 0.8, 0.6), radius=0.2, center=(0.5, 0.4)), 0.1),
    "cylinder": (Round(radius=0.4, height=0.8), 0.1),
    "layers, a base of two": (Layered(base=(1.0, 0.8), layers=LAYERS), 0.1),
}
COLORS = ("#4c78a8", "#e45756", "#72b7b2", "#b279a2", "#f58518", "#54a24b", "#9d755d")
ROCKS = {"rock": "#efece6", "shale": "#d9d2c5", "sand": "#f3e3b3"}


def flat(axes: Axes, mesh: Simplices) -> None:
    """Triangles colored by region, and the faces as thick lines."""
    for region, cells in mesh.regions.items():
        axes.tripcolor(
            *mesh.x.T, mesh.cells[cells], facecolors=np.zeros(len(cells)), edgecolors="#8a8378",
            linewidth=0.4, cmap=matplotlib.colors.ListedColormap([ROCKS[region]]),
        )  # fmt: skip
    for (_, rows), color in zip(mesh.faces.items(), COLORS, strict=False):
        axes.plot(*mesh.x[rows].transpose(2, 1, 0), color=color, linewidth=2.5)
    axes.set_aspect("equal")


def solid(axes: Axes, mesh: Simplices) -> None:
    """The triangles of the surface, colored by face, or by region where there are several."""
    rows = np.concatenate(list(mesh.faces.values()))
    colors = np.repeat(COLORS[: len(mesh.faces)], [len(r) for r in mesh.faces.values()])
    if len(mesh.regions) > 1:
        colors = np.array([ROCKS[_region(mesh, row)] for row in rows])
    axes.add_collection3d(
        Poly3DCollection(mesh.x[rows], facecolors=colors, edgecolor="#5a544b", linewidth=0.3)
    )
    lower, upper = mesh.x.min(axis=0), mesh.x.max(axis=0)
    axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), zlim=(lower[2], upper[2]))
    axes.set_box_aspect(upper - lower)
    axes.view_init(elev=28, azim=-58)


def _region(mesh: Simplices, row: np.ndarray) -> str:
    """The region of a facet on the surface."""
    return next(
        name
        for name, cells in mesh.regions.items()
        if (np.isin(mesh.cells[cells], row).sum(axis=1) == 3).any()
    )


def main() -> None:
    """Mesh and draw each of them."""
    figure = plt.figure(figsize=(11, 8.4))
    figure.subplots_adjust(0.02, 0.1, 0.98, 0.95, wspace=0.1, hspace=0.4)
    for number, (title, (shape, h)) in enumerate(SHAPES.items(), start=1):
        mesh = meshed(shape, h, title)
        axes = figure.add_subplot(2, 3, number, projection="3d" if mesh.dim == 3 else None)
        (flat if mesh.dim == 2 else solid)(axes, mesh)
        regions = [Patch(facecolor=ROCKS[r], edgecolor="#8a8378", label=r) for r in mesh.regions]
        faces = [Patch(color=c, label=f) for f, c in zip(mesh.faces, COLORS, strict=False)]
        if mesh.dim == 3 and len(mesh.regions) > 1:
            faces = [Patch(color="none", label="faces as of a wellbore")]
        axes.legend(
            handles=[*faces, *regions], loc="upper center", bbox_to_anchor=(0.5, -0.04), ncols=3,
            fontsize=8, frameon=False, handlelength=1.2,
        )  # fmt: skip
        axes.set_title(title, fontsize=10)
        axes.set_axis_off()
    figure.savefig(PICTURE, dpi=90)


if __name__ == "__main__":
    main()
