"""What the child process of `volume` does: renders views of cracks with PyVista, off screen."""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from staffa.grid import SIDES
from staffa.io.vtkhdf import read_vtkhdf

# VTK frames the sphere around the body; seen from a corner a cube leaves this much of it free.
ZOOM = 1.05
BEND = 40  # degrees; round faces are cut into facets that bend less


def render(job: dict[str, Any]) -> np.ndarray:
    """Images of each file from a corner (first row) and from the far side (second row).

    Parameters
    ----------
    job : files; lower corner, size and cooled side of the body; deepest, where the colors end;
        crack, the damage to draw; pixels, the edge of an image.
    """
    bodies = [_body(job, file) for file in job["files"]]
    views = (_from_a_corner(job), _from_the_far_side(job))
    return np.array([[_view(job, body, view) for body in bodies] for view in views])


def _body(job: dict[str, Any], file: str) -> Any:
    """The mesh with its damage, and the depth that colors the cracks."""
    import pyvista

    grid, values = read_vtkhdf(Path(file))
    body = pyvista.UnstructuredGrid({grid.type: grid.cells}, grid.points)
    axis, end = SIDES[3][job["face"]]
    along = grid.points[:, axis] - job["lower"][axis]
    body["alpha"] = values["alpha"]
    body["depth"] = job["size"][axis] - along if end > 0 else along
    return body


def _view(job: dict[str, Any], body: Any, camera: list[Any]) -> np.ndarray:
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=(job["pixels"], job["pixels"]))
    plotter.set_background("white")
    plotter.add_mesh(_edges(body), color="#555555", line_width=1.5)
    cracks = body.clip_scalar(scalars="alpha", value=job["crack"], invert=False)
    if cracks.n_cells:
        surface = cracks.extract_surface(algorithm="dataset_surface")
        colors = {"scalars": "depth", "cmap": job["colors"], "clim": (0, job["deepest"])}
        plotter.add_mesh(surface, **colors, show_scalar_bar=False, ambient=0.25, specular=0.1)
    plotter.camera_position = camera
    plotter.enable_parallel_projection()
    plotter.reset_camera()
    plotter.camera.zoom(ZOOM)
    plotter.enable_anti_aliasing("ssaa")
    image = np.asarray(plotter.screenshot(None, return_img=True))
    plotter.close()
    return image


def _edges(body: Any) -> Any:
    """Where the surface of the body has a bend: of a box its edges, of a bore its rims."""
    surface = body.extract_surface(algorithm="dataset_surface")
    bends = {"boundary_edges": False, "non_manifold_edges": False, "manifold_edges": False}
    return surface.extract_feature_edges(feature_angle=BEND, **bends)


def _from_a_corner(job: dict[str, Any]) -> list[Any]:
    """Camera that sees the tips: from a corner, a little from the side that is not cooled."""
    axis, end = SIDES[3][job["face"]]
    direction = np.full(3, -1.0) * [1, 1.6, 1]
    direction[axis] = -0.75 * end
    return _camera(job, direction, up=_unit(axis) * -end)


def _from_the_far_side(job: dict[str, Any]) -> list[Any]:
    """Camera that looks through the rock at the cooled face: the deepest tips are nearest."""
    axis, end = SIDES[3][job["face"]]
    return _camera(job, _unit(axis) * -end, up=_unit(1 if axis == 2 else 2))


def _camera(job: dict[str, Any], direction: np.ndarray, up: np.ndarray) -> list[Any]:
    middle = np.array(job["lower"]) + np.array(job["size"]) / 2
    away = 4 * max(job["size"]) * direction / np.linalg.norm(direction)
    return [tuple(middle + away), tuple(middle), tuple(up)]


def _unit(axis: int) -> np.ndarray:
    return np.eye(3)[axis]


if __name__ == "__main__":
    task = json.load(sys.stdin)
    np.save(task["result"], render(task))
