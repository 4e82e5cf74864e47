"""Child process of `volume`: it renders views of cracks with PyVista, off screen.

It prints one line for each view that is ready.
"""

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LinearSegmentedColormap

from staffa.geometry.block import SIDES
from staffa.io.vtkhdf import read_vtkhdf

ROCK = "rock"  # the body without its near quarter, in which the cracks are left
CRACKS = "cracks"  # the cracks alone, from the opposite boundary: their tips are nearest
BEND = 40  # degrees; the facets of round faces bend by less
LENS = 24  # view angle of the camera, degrees; a larger one would distort the columns
# Rounds of smoothing that remove the facets of the mesh from the surface of a crack, and the
# frequencies that pass (Taubin 1995): its volume does not change.
ROUNDS, PASS = 40, 0.05
LINE = "#4a4a4a"
# From intact to broken rock; pale up to half, so that a crack is not as wide as its profile.
STONE = LinearSegmentedColormap.from_list(
    "stone", [(0, "#f2eadd"), (0.4, "#e6dccb"), (0.7, "#c2b29b"), (0.9, "#6b5a48"), (1, "#1d1712")]
)
# A cut along cell faces would leave slivers of cells, with visible edges.
BESIDE_THE_MIDDLE = 0.4987
MATT: Any = {"ambient": 0.36, "diffuse": 0.72, "show_scalar_bar": False}
OUTWARD = 0.04  # distance of the size labels from the body, over its largest size


def render(job: dict[str, Any]) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield images of each file, one look after the other, with the positions of the size labels.

    An image has shape (pixels, pixels, 3). The positions, one for each axis, are in pixels from its
    upper left corner, shape (3, 2).

    Parameters
    ----------
    job : looks, of `ROCK` and `CRACKS`; files; lower corner and size of the body (m); face, the
        side of a box from which depth is counted; turned, True if that is up in the view of the
        rock; deepest, depth at which the colors end (m); crack, the damage to draw; colors; pixels,
        the edge of an image.
    """
    for look in job["looks"]:
        for file in job["files"]:
            yield _view(job, _body(job, file), look)


def _body(job: dict[str, Any], file: str) -> Any:
    """Return the mesh with its damage, and the depth that colors the cracks."""
    import pyvista

    grid, values = read_vtkhdf(Path(file))
    body = pyvista.UnstructuredGrid({grid.type: grid.cells}, grid.points)
    axis, end = SIDES[3][job["face"]]
    along = grid.points[:, axis] - job["lower"][axis]
    body["alpha"] = values["alpha"]
    body["depth"] = job["size"][axis] - along if end > 0 else along
    return body


def _view(job: dict[str, Any], body: Any, look: str) -> tuple[np.ndarray, np.ndarray]:
    import pyvista

    away, up = _seen_from(job, look)
    plotter = pyvista.Plotter(
        off_screen=True, window_size=(job["pixels"], job["pixels"]), lighting="none"
    )
    plotter.set_background("white")
    _add_lights(plotter, away, up)
    plotter.add_mesh(_edges(body), color=LINE, line_width=2)
    if look == ROCK:
        quarter, rest = _quartered(job, body, away)
        for rim in _rims(job, body, away):
            plotter.add_mesh(rim, color=LINE, line_width=2)
        _add_rock(plotter, rest)
        _add_cracks(plotter, job, quarter)
    else:
        _add_cracks(plotter, job, body)
    middle = np.array(job["lower"]) + np.array(job["size"]) / 2
    plotter.camera_position = [tuple(middle + away), tuple(middle), tuple(up)]
    plotter.camera.view_angle = LENS
    plotter.reset_camera(bounds=body.bounds)
    plotter.enable_anti_aliasing("ssaa")
    image = np.asarray(plotter.screenshot(None, return_img=True))
    places = [_on_screen(plotter, point) for point in _beside(job, body, away, up)]
    plotter.close()
    return image, np.array(places)


def _add_cracks(plotter: Any, job: dict[str, Any], body: Any) -> None:
    """Draw the surface of broken rock, colored by depth; closed at the body's surface."""
    colors = {"scalars": "depth", "cmap": job["colors"], "clim": (0, job["deepest"])}
    walls = body.contour([job["crack"]], scalars="alpha")
    if walls.n_cells:
        walls = walls.smooth_taubin(n_iter=ROUNDS, pass_band=PASS)  # which leaves its rim in place
        plotter.add_mesh(walls, **colors, **MATT, smooth_shading=True)
    skin = body.extract_surface(algorithm="dataset_surface")
    ends = skin.clip_scalar(scalars="alpha", value=job["crack"], invert=False)
    if ends.n_cells:
        plotter.add_mesh(ends, **colors, **MATT)


def _add_rock(plotter: Any, parts: list[Any]) -> None:
    """Draw the surface of the rock, dark where it is broken."""
    for part in parts:
        skin = part.extract_surface(algorithm="dataset_surface")
        colors = {"scalars": "alpha", "cmap": STONE, "clim": (0, 1)}
        plotter.add_mesh(skin, **colors, **MATT, interpolate_before_map=True)


def _add_lights(plotter: Any, away: np.ndarray, up: np.ndarray) -> None:
    """Add a strong light from the viewer's upper left, and a weaker one from the right."""
    import pyvista

    right = np.cross(up, away) / np.linalg.norm(np.cross(up, away))
    for position, intensity in ((away + 1.2 * up - 0.9 * right, 0.8), (away + 1.2 * right, 0.5)):
        light = pyvista.Light(position=tuple(position), light_type="scene light")
        light.positional, light.intensity = False, intensity
        plotter.add_light(light)


def _quartered(job: dict[str, Any], body: Any, away: np.ndarray) -> tuple[Any, list[Any]]:
    """Return the quarter nearest to the viewer, through the whole depth, and the other parts."""
    quarter, parts = body, []
    for axis, plane in _cuts(job):
        parts.append(quarter.clip(**plane, invert=bool(away[axis] > 0)))
        quarter = quarter.clip(**plane, invert=bool(away[axis] < 0))
    return quarter, parts


def _cuts(job: dict[str, Any]) -> list[tuple[int, dict[str, Any]]]:
    """Return the two planes that cut out the quarter, each with the axis across it."""
    middle = np.array(job["lower"]) + np.array(job["size"]) * BESIDE_THE_MIDDLE
    level = sorted({0, 1, 2} - {SIDES[3][job["face"]][0]})
    return [(axis, {"normal": np.eye(3)[axis], "origin": middle}) for axis in level]


def _rims(job: dict[str, Any], body: Any, away: np.ndarray) -> Iterator[Any]:
    """Yield the lines in which the cuts meet the surface of the body, beside the quarter.

    These are not the edges of the cut mesh: in an unstructured mesh a cut leaves slivers with
    bends.
    """
    surface = body.extract_surface(algorithm="dataset_surface")
    one, other = _cuts(job)
    for (_, plane), (axis, across) in ((one, other), (other, one)):
        yield surface.slice(**plane).clip(**across, invert=bool(away[axis] < 0))


def _edges(body: Any) -> Any:
    """Return the edges of the body's surface: of a box its edges, of a bore its rims."""
    surface = body.extract_surface(algorithm="dataset_surface")
    bends = {"boundary_edges": False, "non_manifold_edges": False, "manifold_edges": False}
    return surface.extract_feature_edges(feature_angle=BEND, **bends)


def _seen_from(job: dict[str, Any], look: str) -> tuple[np.ndarray, np.ndarray]:
    """Return unit vectors to the camera, near one corner, and up.

    The rock is seen with its cooled face above, the cracks with their tips above.
    """
    axis, end = SIDES[3][job["face"]]
    if job["turned"] and look == CRACKS:
        end = -end
    away = np.array([-1.0, -1.5, -1.0])
    away[axis] = end * (0.95 if look == ROCK else 1.1)
    return away / np.linalg.norm(away), np.eye(3)[axis] * end


def _beside(job: dict[str, Any], body: Any, away: np.ndarray, up: np.ndarray) -> list[np.ndarray]:
    """Return for each axis a point beside the outline of the body in the view.

    The outline is the body at the left, or below an edge of its box.
    """
    half = np.array(job["size"]) / 2
    middle, near = np.array(job["lower"]) + half, np.sign(away)
    height = int(np.argmax(np.abs(up)))
    points = []
    for axis in range(3):
        aside = near * (np.arange(3) != axis)
        if axis == height:
            right = np.cross(up, away)
            place = np.array(body.points[np.argmin(body.points @ right)])
            place[height] = middle[height]
            outward = -1.4 * right / np.linalg.norm(right)
        else:
            outward = aside * (np.arange(3) != height) - up * 0.5
            aside[height] = -up[height]
            place = middle + half * aside
        points.append(place + OUTWARD * max(job["size"]) * outward)
    return points


def _on_screen(plotter: Any, point: np.ndarray) -> list[float]:
    """Return the position of a point in the image, in pixels from its upper left corner."""
    from vtkmodules.vtkRenderingCore import vtkCoordinate

    place = vtkCoordinate()
    place.SetCoordinateSystemToWorld()
    place.SetValue(*point)
    x, y = place.GetComputedDoubleDisplayValue(plotter.renderer)
    return [x, plotter.window_size[1] - y]


if __name__ == "__main__":
    task = json.load(sys.stdin)
    images, places = [], []
    for image, beside in render(task):
        images.append(image)
        places.append(beside)
        print("ready", flush=True)
    np.savez(task["result"], images=images, places=places)
