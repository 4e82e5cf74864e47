"""Excess stiffness of elements where the rock is nearly incompressible.

    python -m verification.locking.run

prints the table of docs/how-to/choose-a-solver.md, of Lame's ring (`tests/support/rings.py`).
"""

from staffa.physics.locking import too_stiff
from support.rings import INNER, lame, quarter, widened

NUS = (0.3, 0.45, 0.49, 0.499)
CELLS = {"quadrilateral": (4, 16), "triangle": (4, 16), "hexahedron": (8,), "tetrahedron": (8,)}


def lacking(cells: str, n: int, nu: float, elements: str) -> float:
    """The part of Lame's displacement that the inner side lacks."""
    made = quarter(cells, n, nu, [f"domain.elements={elements}"])
    return 1 - widened(made).inner / float(lame(nu, INNER))


def main() -> None:
    """Print the table as Markdown: linear elements, what is said of them, and the others."""
    print(f"| cells across the wall | elements | {' | '.join(f'nu = {nu:g}' for nu in NUS)} |")
    print(f"| --- | --- |{' --- |' * len(NUS)}")
    for cells, counts in CELLS.items():
        other = "reduced" if cells in ("quadrilateral", "hexahedron") else "quadratic"
        for n in counts:
            rows = {e: [lacking(cells, n, nu, e) for nu in NUS] for e in ("linear", other)}
            said = [too_stiff(nu, cells, n) for nu in NUS]
            for elements, values in [*rows.items(), ("linear, as `check` says", said)]:
                shown = " | ".join(f"{100 * value:.2g} %" for value in values)
                print(f"| {n} {cells} | {elements} | {shown} |", flush=True)


if __name__ == "__main__":
    main()
