"""Draw the toughness of layers.toml: python docs/pictures/rock.py."""

from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
from matplotlib.figure import Figure

from staffa.case.reading.read import read_case
from staffa.model.domain import middles
from staffa.plot.style import new_figure, write_picture
from staffa.setup.build import problem

HERE = Path(__file__).parent


def drawn() -> Figure:
    """Gc cell by cell, the regions' names beside them."""
    case = read_case(HERE / "layers.toml")
    built = problem(case, comm=MPI.COMM_SELF)
    x = middles(built.domain.mesh)
    Gc = built.material.Gc * built.material.toughness(x)
    for name, rock in built.regions.items():
        cells = built.domain.cells(name)
        Gc[cells] = rock.Gc * rock.toughness(x[:, cells])
    order, rows = np.lexsort(x[:2].round(9)), len(np.unique(x[1].round(9)))
    figure = new_figure(2.3)
    axes = figure.add_subplot()
    width, height = built.domain.size
    image = axes.imshow(
        Gc[order].reshape(rows, -1), origin="lower", extent=(0, width, 0, height), cmap="cividis"
    )
    axes.grid(False)
    axes.set(xlabel="x", ylabel="y")
    for name, region in case.regions.items():
        assert region.lower is not None and region.upper is not None
        middle = float(region.lower[1] + region.upper[1]) / 2
        axes.annotate(name, (0.03, middle), color="white", va="center", fontsize=8)
    figure.colorbar(image, label="Gc", shrink=0.8)
    return figure


if __name__ == "__main__":
    write_picture(HERE / "rock.png", drawn)
