"""Paths of cracks behind a cold front in rock whose toughness has directions; with a picture."""

from typing import Any

import numpy as np

from staffa.physics.elasticity import Orthotropic
from staffa.plot.style import BLACK, ORANGE, new_figure, write_picture
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ROOT

# The toughness across the second axis over that across the first, and the angle of the first to x.
ROCKS = ((1.0, 0.0), (2.0, 30.0), (2.0, 45.0), (2.0, -45.0), (2.0, 60.0), (3.0, 45.0))
PLATE = {"cells_per_ell": 4, "width": 20.0, "rise": 16.0}
C, S = np.cos(np.pi / 4), np.sin(np.pi / 4)
# Twice as stiff along one axis, at 45 degrees, as along the other.
STIFF = Orthotropic(
    E=(1.0, 0.5, 0.5),
    nu=(0.2, 0.2, 0.2),
    G=(0.3, 0.2, 0.3),
    axes=np.array([[C, S, 0.0], [-S, C, 0.0], [0.0, 0.0, 1.0]]),
)
TOLERANCE = 3.0  # degrees
PICTURE = ROOT / "docs" / "pictures" / "verify-toughness-direction.png"


def toughness_direction() -> Found:
    """The angles of the cracks, and what the mesh makes of them; a picture."""
    from fem.test_turning import direction, roughness, turning

    uneven = 3 / (8 * PLATE["cells_per_ell"])  # h/(4 c_w ell) of AT1
    figures, lines, paths = [], [], []
    rocks: list[tuple[float, float, dict[str, Any]]] = [(*rock, {}) for rock in ROCKS]
    for ratio, angle, more in [*rocks, (2.0, 45.0, {"stiffness": STIFF})]:
        A = roughness(ratio, angle)
        found = turning(A, **PLATE, **more)
        expected, meshed = direction(A)[0], direction(A, uneven)[0]
        stiff = ", stiffness too" if more else ""
        name = (
            f"Gc, {ratio:g} Gc at {angle:g} degrees{stiff}" if ratio > 1 else "Gc in all directions"
        )
        figures.append(
            Figure(
                what=f"angle (degrees), {name}",
                source="least cost of a straight crack",
                reference=expected,
                measured=found.angle,
                tolerance=TOLERANCE,
            )
        )
        lines.append(f"| {name} | {expected:.1f} | {meshed:.1f} | {found.angle:.1f} |")
        paths.append((name, expected, found))
    draw(paths)
    text = [
        "| rock | least cost | the same with what cells add, Gc h/(4 c_w ell) | measured |\n"
        "| --- | --- | --- | --- |\n" + "\n".join(lines),
        f"![Cracks that turn](pictures/{PICTURE.name})",
    ]
    return Found(figures=figures, text="\n\n".join(text))


def draw(paths: list[tuple[str, float, Any]]) -> None:
    """The cracked vertices of each plate, and beside them the direction that costs least."""

    def drawn() -> Any:
        figure = new_figure(2.0)
        for number, (name, expected, path) in enumerate(paths, start=1):
            axes = figure.add_subplot(1, len(paths), number)
            axes.plot(*path.x.T, ".", color=BLACK, markersize=1.5)
            x, y = path.fitted.mean(axis=0)
            up = np.array([-PLATE["rise"], PLATE["rise"]]) / 2
            beside = x + 1.5 - np.tan(np.radians(expected)) * up
            axes.plot(beside, y + up, color=ORANGE, linewidth=1)
            axes.set(aspect="equal", xlim=(0, PLATE["width"]), ylim=(0, 32), xticks=(), yticks=())
            axes.set_title(name.replace(" degrees", "°").replace(", stiff", ",\nstiff"), fontsize=6)
        return figure

    write_picture(PICTURE, drawn)


CHECKS = {
    "toughness-direction": Check(
        title="A crack turns in rock of anisotropic toughness",
        text=(
            "A plate with constrained ends. A cold front moves up it from a straight notch, and "
            "the crack follows. In steady motion, front and crack release the same energy in each "
            "unit of height wherever they are. They pay Gc sqrt(n . A n)/cos(theta) for it, n = "
            "(cos(theta), sin(theta)), which is least at tan(theta) = -A_xy/A_yy. As nothing "
            "depends on x, the force on the tip along x is zero, which is the same condition: the "
            "growing crack finds this angle, whatever the stiffness. Rocks: toughness across the "
            "first axis and across the second, the angle of the first axis to x. Angles from y to "
            "the left, by a line through the vertices with alpha > 0.9; unstructured cells of "
            "ell/4, width of the plate 20 ell. Two of the rocks are mirror images, on one mesh. In "
            "isotropic rock 2.5 degrees more cost 0.1 %, less than the effect of irregular cells "
            "on the toughness."
        ),
        measure=toughness_direction,
    ),
}
