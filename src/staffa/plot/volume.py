"""The cracks of a 3-D body at chosen times: from a corner, and down on their tips."""

import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from staffa.errors import StaffaError
from staffa.grid import SIDES
from staffa.manifest import Manifest
from staffa.plot.frames import Frame
from staffa.plot.labels import moment, with_unit
from staffa.plot.style import WIDTH, new_figure

RENDERER = "staffa.plot.rendering"
CRACK = 0.7  # damage that is drawn as crack
DEPTHS = "viridis"
MOST = 3  # moments side by side
PIXELS = 600  # edge of a rendered view
PATIENCE = 300  # seconds that rendering may take before it is given up


def volume_figure(manifest: Manifest, frames: Sequence[Frame]) -> Figure:
    """The last three moments: cracks colored by depth, from a corner and down on their tips.

    Raises
    ------
    StaffaError
        Rendering is not possible here.
    """
    shown = frames[-MOST:]
    bottom = deepest(manifest, shown)
    views = rendered(manifest, shown, bottom)
    figure = new_figure(2 * WIDTH / MOST + 1.4)
    panels = figure.subplots(2, len(shown), squeeze=False)
    for column, frame in enumerate(shown):
        for row in range(2):
            panels[row, column].imshow(views[row, column])
            panels[row, column].set_axis_off()
        panels[0, column].set_title(moment(manifest, frame.step), loc="left")
        panels[1, column].set_title("seen from the far side", loc="left", fontsize=8)
    name = f"depth below the {'cooled face' if manifest.face else 'bottom'}"
    figure.colorbar(
        ScalarMappable(Normalize(0, bottom), DEPTHS), ax=panels,
        location="bottom", shrink=0.5, aspect=40, label=with_unit(name, manifest, "m"),
    )  # fmt: skip
    return figure


def rendered(manifest: Manifest, frames: Sequence[Frame], bottom: float) -> np.ndarray:
    """Views (row) of moments (column) as images, shape (2, n, PIXELS, PIXELS, 3).

    bottom: depth (m) at which the colors end.

    VTK ends its process where it finds neither a display nor a software renderer, so a child
    renders, and only the picture is lost.
    """
    with tempfile.TemporaryDirectory(prefix="staffa-") as folder:
        result = Path(folder) / "views.npy"
        job = {
            "result": str(result),
            "files": [str(frame.path.resolve()) for frame in frames],
            "lower": manifest.corner,
            "size": manifest.size,
            "face": manifest.cooled_side or "bottom",
            "deepest": bottom,
            "crack": CRACK,
            "colors": DEPTHS,
            "pixels": PIXELS,
        }
        said = _in_a_child(json.dumps(job))
        if not result.is_file():
            raise StaffaError(
                f"VTK cannot render off screen here ({said}); open the files in fields/ with "
                f"ParaView, or run `staffa report` on a machine with OpenGL"
            )
        return np.load(result)


def deepest(manifest: Manifest, frames: Sequence[Frame]) -> float:
    """Depth (m) at which the colors end: that of the deepest tip, or of the body."""
    measured = [frame.step.measures for frame in frames]
    front = max((m.front for m in measured if m is not None), default=0.0)
    return front or manifest.size[SIDES[3][manifest.cooled_side or "bottom"][0]]


def _in_a_child(job: str) -> str:
    """Run the renderer on a job; what it said last."""
    command = [sys.executable, "-m", RENDERER]
    try:
        child = subprocess.run(
            command, input=job, capture_output=True, text=True, timeout=PATIENCE, check=False
        )
    except subprocess.TimeoutExpired:
        return f"no picture after {PATIENCE} s"
    return (child.stderr.strip().splitlines() or [f"exit status {child.returncode}"])[-1]
