"""Cracks on planes of symmetry: a case with two of them, and what such cracks cost."""

import tomllib
from pathlib import Path

TWO_CRACKS = Path(__file__).parent / "two-cracks.toml"
# Cells per ell of the cases with cracks on a side, and the toughness they reckon with.
ON_A_SIDE = {
    "the ready case two-cracks": (0.0065 / 0.0015671, 1.1234),
    "two-cracks": (0.00433 / 0.0010533, 1.1245),
    "four-cracks": (0.013 / 0.0030964, 1.1208),
}


def even_bands(file: Path = TWO_CRACKS) -> str:
    """The bands of a case with two cracks without the imperfection, as a setting."""
    case = tomllib.loads(file.read_text())
    bands = [
        f"{{lower={b['lower']},upper={b['upper']},factor={b['factor']}}}"
        for b in case["toughness"]["bands"]
        if b["factor"] != 1.01
    ]
    return f"toughness.bands=[{','.join(bands)}]"
