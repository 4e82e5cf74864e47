"""The child process of `volume`: renders views of cracks with PyVista, off screen."""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LinearSegmentedColormap

from staffa.geometry.block import SIDES
from staffa.io.vtkhdf import read_vtkhdf

ROCK = "rock"  # the body, its near quarter cut away, the cracks in there left
CRACKS = "cracks"  # the cracks alone, from the opposite boundary: their tips are nearest
BEND = 40  # degrees; round faces are cut into facets that bend less
LENS = 24  # degrees that the camera takes in; more would bend the columns
# Rounds of smoothing that take the facets of the mesh out of the surface of a crack, and the
# frequencies that pass (Taubin 1995): its volume stays.
ROUNDS, PASS = 40, 0.05
LINE = "#4a4a4a"
# Sound rock up to broken rock; pale up to half, so that a crack is not as wide as its profile.
STONE = LinearSegmentedColormap.from_list(
    "stone", [(0, "#f2eadd"), (0.4, "#e6dccb"), (0.7, "#c2b29b"), (0.9, "#6b5a48"), (1, "#1d1712")]
)
# A cut along faces of cells would leave slivers of these, whose edges are seen.
BESIDE_THE_MIDDLE = 0.4987
MATT: Any = {"ambient": 0.36, "diffuse": 0.72, "show_scalar_bar": False}
OUTWARD = 0.04  # how far outside of the body its sizes are written, over its largest
ROOM = 0.85  # of the image that the body may take, so that its sizes have room beside it
LETTERS = 1 / 46  # height of the letters over the edge of the image


def render(job: dict[str, Any]) -> None:
    """Write an image of each file in each look, and print a line when one is ready.

    Parameters
    ----------
    job : result, the file to write, of shape (looks, files, pixels, pixels, 3); looks, of `ROCK`
        and `CRACKS`; files; lower corner, size and sizes (as text) of the body; face, the side of
        a box that depth counts from; turned, whether that is up where it is looked at; deepest,
        where the colors end; crack, the damage to draw; colors; pixels, the edge of an image.
    """
    images = np.zeros((len(job["looks"]), len(job["files"]), *[job["pixels"]] * 2, 3), np.uint8)
    for k, look in enumerate(job["looks"]):
        for n, file in enumerate(job["files"]):
            images[k, n] = _view(job, _body(job, file), look)
            print("ready", flush=True)
    np.save(job["result"], images)


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


def _view(job: dict[str, Any], body: Any, look: str) -> np.ndarray:
    import pyvista

    bounds, (away, up) = body.bounds, _seen_from(job, look)
    plotter = pyvista.Plotter(
        off_screen=True, window_size=(job["pixels"], job["pixels"]), lighting="three lights"
    )
    plotter.set_background("white")
    plotter.add_point_labels(
        _beside(job, away, up), job["sizes"], show_points=False, shape=None,
        always_visible=True, bold=False, text_color="#555555",
        font_size=round(LETTERS * job["pixels"]),
        justification_horizontal="center", justification_vertical="center",
    )  # fmt: skip
    plotter.add_mesh(_edges(body), color=LINE, line_width=2)
    if look == ROCK:
        body, rest, rims = _cut_open(job, body, away)
        for rim in rims:
            plotter.add_mesh(rim, color=LINE, line_width=2)
        for part in rest:
            colors = {"scalars": "alpha", "cmap": STONE, "clim": (0, 1)}
            plotter.add_mesh(_surface(part), **colors, **MATT, interpolate_before_map=True)
    _add_cracks(plotter, job, body)
    middle = np.array(job["lower"]) + np.array(job["size"]) / 2
    plotter.camera_position = [tuple(middle + away), tuple(middle), tuple(up)]
    plotter.camera.view_angle = LENS
    plotter.reset_camera(bounds=bounds)
    plotter.camera.zoom(ROOM)
    plotter.enable_anti_aliasing("ssaa")
    image = np.asarray(plotter.screenshot(None, return_img=True))
    plotter.close()
    return image


def _add_cracks(plotter: Any, job: dict[str, Any], body: Any) -> None:
    """Draw the surface of broken rock, colored by depth; closed at the body's surface."""
    colors = {"scalars": "depth", "cmap": job["colors"], "clim": (0, job["deepest"])}
    walls = body.contour([job["crack"]], scalars="alpha")
    if walls.n_cells:
        walls = walls.smooth_taubin(n_iter=ROUNDS, pass_band=PASS)  # which leaves its rim in place
        plotter.add_mesh(walls, **colors, **MATT, smooth_shading=True)
    ends = _surface(body).clip_scalar(scalars="alpha", value=job["crack"], invert=False)
    if ends.n_cells:
        plotter.add_mesh(ends, **colors, **MATT)


def _cut_open(job: dict[str, Any], body: Any, away: np.ndarray) -> tuple[Any, list[Any], list[Any]]:
    """Return the quarter nearest to who looks, all through from the cooled face, rest and rims.

    Rims, where a cut meets the surface of the body, are not the edges of what was cut: between
    cells in all directions a cut leaves slivers with bends.
    """
    middle = np.array(job["lower"]) + np.array(job["size"]) * BESIDE_THE_MIDDLE
    level = sorted({0, 1, 2} - {SIDES[3][job["face"]][0]})
    one, other = ({"normal": np.eye(3)[axis], "origin": middle} for axis in level)
    near, close = (bool(away[axis] < 0) for axis in level)
    half, surface = body.clip(**one, invert=near), _surface(body)
    rest = [body.clip(**one, invert=not near), half.clip(**other, invert=not close)]
    rims = [
        surface.slice(**one).clip(**other, invert=close),
        surface.slice(**other).clip(**one, invert=near),
    ]
    return half.clip(**other, invert=close), rest, rims


def _surface(body: Any) -> Any:
    return body.extract_surface(algorithm="dataset_surface")


def _edges(body: Any) -> Any:
    """Return the edges of the body's surface: of a box its edges, of a bore its rims."""
    bends = {"boundary_edges": False, "non_manifold_edges": False, "manifold_edges": False}
    return _surface(body).extract_feature_edges(feature_angle=BEND, **bends)


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


def _beside(job: dict[str, Any], away: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return a point beside an edge of the box along each axis, at the left or below, (3, 3)."""
    half = np.array(job["size"]) / 2
    level, left = np.where(up, -up, np.sign(away)), -np.sign(np.cross(up, away))
    sides = np.array([left if height else level for height in up]) * (1 - np.eye(3))
    return np.asarray(job["lower"] + half + (half + OUTWARD * max(job["size"])) * sides)


if __name__ == "__main__":
    render(json.load(sys.stdin))
