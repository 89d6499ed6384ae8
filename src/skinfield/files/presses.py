"""Simulated presses as files."""

from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import InputError
from skinfield.files.pending import write_npz
from skinfield.simulate import Press
from skinfield.simulate.pressing.press import base_stress_below_cells, parts_of
from skinfield.skin import Patch


def save_press(press: Press, path: str | Path, patch: Patch | None = None) -> None:
    """Write all that is known of a press, in SI units, as NPZ.

    Of the cells: `x` (columns,), `y` (rows,) m; `pressure` (rows, columns) Pa; `traction`
    (rows, columns, 3) Pa and `displacement` (rows, columns, 3) m, z outward; `gap` (rows, columns)
    m between surface and body, infinite under none; `contact` (rows, columns); `base_stress`
    (rows, columns) Pa. Of the indenters: `kind`, `position` (bodies, 2) m, `depth` (bodies,) m,
    `forces` (bodies,) N, `centres` of pressure (bodies, 2) m, `areas` (bodies,) m². Of all:
    `force` N, `moment` (3,) N m about the origin, `contact_area` m², `residual`. Of the layer:
    `thickness` m, `young_modulus` Pa, `poisson_ratio`. Of the taxels of a patch: `pad_position`
    (L, 2) m, `pad_diameter` m, `pad_stress` (L,) Pa, `pad_gap_change` (L,) m, `pad_capacitance`
    (L,) ΔC/C₀.

    Parameters
    ----------
    press : Press
    path : str or Path
        Ends in `.npz`.
    patch : Patch, optional
        Whose taxels read the press.

    Raises
    ------
    InputError
        For another extension.
    FileError
        If the file cannot be written.
    """
    check_press_name(path)
    shape, plane = press.grid.shape, press.grid.plane
    fields: dict[str, Any] = {
        "x": plane.reshape(*shape, 2)[0, :, 0],
        "y": plane.reshape(*shape, 2)[:, 0, 1],
        "pressure": press.pressure.reshape(shape),
        "traction": press.traction.reshape(*shape, 3),
        "displacement": press.displacement.reshape(*shape, 3),
        "gap": press.gap.reshape(shape),
        "contact": press.contact.reshape(shape),
        "base_stress": base_stress_below_cells(press).reshape(shape),
    }
    parts = parts_of(press)
    fields |= {
        "kind": np.array([body.kind for body in press.indenters]),
        "position": np.array([body.position for body in press.indenters]),
        "depth": press.approach,
        "forces": press.forces,
        "centres": np.array([[part["x_m"], part["y_m"]] for part in parts]),
        "areas": np.array([part["area_m2"] for part in parts]),
        "force": press.force,
        "moment": press.moment,
        "contact_area": press.contact_area,
        "residual": press.residual,
        "thickness": press.layer.thickness,
        "young_modulus": press.layer.young_modulus,
        "poisson_ratio": press.layer.poisson_ratio,
    }
    if patch is not None:
        places, diameter = patch.plane, patch.pad_diameter
        fields |= {
            "pad_position": places,
            "pad_diameter": diameter,
            "pad_stress": press.base_stress(places, diameter),
            "pad_gap_change": press.gap_change(places, diameter),
            "pad_capacitance": press.capacitance(places, diameter),
        }
    write_npz(path, fields)


def check_press_name(path: str | Path) -> None:
    """Raise InputError unless a press can be written under this name."""
    if Path(path).suffix.lower() != ".npz":
        raise InputError(f"path is {str(path)!r}, expected a name that ends in .npz")
