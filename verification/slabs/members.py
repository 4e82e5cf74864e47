"""Members of the kept slabs, as their names say: section, ell, cells, seed."""

CASE = "verification/slabs/case.toml"
# What a crack costs on cells of ell/4, over Gc; `staffa run` measures it. For triangles: of EDGE.
FACTOR = {"quadrilateral": 1.0956, "unstructured": 1.111, "triangle": 1.13522}
LAST = {"stretch": (0.30, 30), "free": (0.32, 32)}
# Four triangles take the place of a square, with two vertices: squares larger by the root of 2 have
# as many vertices per area as those of ell/4, ell = 0.013.
EDGE = 2**0.5 * 0.013 / 4
# A segment of a crack's path this long, over ell, has a direction to five degrees.
SEGMENT = 3.0
COUNTED = (0.1, 0.2, 0.3)
WITHIN = 0.03  # of a length, or ell where that is more


def settings(name: str) -> list[str]:
    """Return the settings by which a member differs from verification/slabs/case.toml.

    Parameters
    ----------
    name : like "stretch-0.013-quadrilateral-1". Triangles follow the cracks, with ell = 0.013.
    """
    section, ell, cells, seed = name.split("-")
    assert cells != "triangle" or ell == "0.013", "the cost of a crack is that of EDGE"
    stop, steps = LAST[section]
    held = "rollers" if section == "free" else "free"
    own = [f"domain.h={float(ell) / 4}"]
    if cells == "triangle":
        own = [f"domain.h={EDGE:.6f}", "domain.refine=true"]
    return [
        f"damage.ell={ell}",
        *own,
        f"domain.cells={cells}",
        f"material.Gc={1 / FACTOR[cells]:.5f}",
        f"toughness.seed={seed}",
        f"supports.left={held}",
        f"supports.section={'none' if section == 'free' else section}",
        f"time.tau={{start=0.01,stop={stop},steps={steps}}}",
    ]
