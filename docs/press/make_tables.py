"""Tables of the page on which a skin is pressed in the browser.

`python3 dev.py python docs/press/make_tables.py` writes them, in ten seconds.

`press.js` looks its physics up in them. Presses are solved on a lattice by `sf.simulate`, as they
are for every test of accuracy; what is fitted to their readings comes from the exact indentation of
the layer by balls of other radii, and from Laplace's equation in the gap, which share no code with
the lattice.
"""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import skinfield as sf
from skinfield.elastic.axisymmetric import Ball, indent_by_force
from skinfield.elastic.round_gap import RoundGap

Floats = NDArray[np.float64]
LAYER = sf.Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.5)
PATCH = sf.layouts.hexagon72()
DISTANCES = np.arange(0.0, 16.01e-3, 0.25e-3)  # m, of a pad from the axis of a press
FORCES = np.geomspace(0.05, 4.0, 11)  # N
RADII = np.array([3.0, 4.5, 6.75, 10.1, 15.2]) * 1e-3  # m, of the balls that are fitted
TOOLS = {  # what presses
    "ball 8 mm": sf.simulate.Sphere(radius=4e-3),
    "ball 12 mm": sf.simulate.Sphere(radius=6e-3),
    "ball 20 mm": sf.simulate.Sphere(radius=10e-3),
}


def fitted(radius: float, force: float, gap: RoundGap) -> tuple[Floats, Floats, Floats]:
    """Readings (N,), pressure (N,) Pa and indentation (N,) m at `DISTANCES` from a ball's axis."""
    state = indent_by_force(LAYER, Ball(radius=radius), force)
    strain = state.indentation(gap.nodes * LAYER.thickness) / LAYER.thickness
    return (
        gap.readings(strain[None])[0],
        state.pressure(DISTANCES),
        state.indentation(DISTANCES),
    )


def pressed(tool: sf.simulate.Sphere, force: float) -> Floats:
    """Readings (N,) of pads at `DISTANCES` from a tool's axis, by the lattice."""
    press = sf.simulate.press(LAYER, [replace(tool, force=force)])
    along = np.stack([DISTANCES, 0.0 * DISTANCES], axis=1)
    return press.capacitance(along, PATCH.pad_diameter)


def rounded(values: Floats, digits: int) -> Any:
    """Nested lists of numbers with few digits."""
    return np.vectorize(lambda value: float(f"{value:.{digits}g}"))(values).tolist()


def tables() -> dict[str, Any]:
    """All that `press.js` needs; lengths in mm, forces in N, pressures in kPa."""
    h = LAYER.thickness
    gap = RoundGap.of(PATCH.pad_diameter / h, DISTANCES / h)
    fit = np.array([[fitted(radius, force, gap) for force in FORCES] for radius in RADII])
    return {
        "taxels": rounded(PATCH.positions[:, :2] * 1e3, 5),
        "pad": PATCH.pad_diameter * 1e3,
        "step": (DISTANCES[1] - DISTANCES[0]) * 1e3,
        "forces": rounded(FORCES, 5),
        "radii": rounded(RADII * 1e3, 5),
        "readings": rounded(fit[:, :, 0], 4),
        "pressure": rounded(fit[:, :, 1] * 1e-3, 3),
        "indentation": rounded(fit[:, :, 2] * 1e3, 3),
        "tools": {
            name: rounded(np.array([pressed(tool, force) for force in FORCES]), 4)
            for name, tool in TOOLS.items()
        },
        "sizes": {name: round(tool.radius * 1e3, 3) for name, tool in TOOLS.items()},
    }


if __name__ == "__main__":
    target = Path(__file__).with_name("tables.js")
    text = json.dumps(tables(), separators=(",", ":"))
    target.write_text(f"const SKINFIELD_TABLES = {text};\n", encoding="utf-8")
