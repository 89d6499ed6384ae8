"""What each indenter of a press does, and what the base below all cells carries."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.mechanics import LatticeConvolution
from skinfield.mechanics.lattice import lattice, mirrored
from skinfield.simulate.indenters import Indenter
from skinfield.simulate.pressing.press import Press


@dataclass(frozen=True, eq=False)
class Part:
    """One indenter's part of a press.

    Attributes
    ----------
    indenter : Indenter
    force : float, N
        Into the skin.
    depth : float, m
        Of its lowest point below the undeformed surface.
    centre : (2,) array, m
        Of its pressure in the plane; NaN where it does not touch.
    area : float, m²
        That it touches.
    peak : float, Pa
        Largest mean pressure of a cell. Below a sharp edge it grows without bound as cells shrink.
    """

    indenter: Indenter
    force: float
    depth: float
    centre: Floats
    area: float
    peak: float


def parts_of(press: Press) -> list[Part]:
    """Part of each indenter, in order."""
    pressure = pressure_by_body(press)
    parts = []
    for index, indenter in enumerate(press.indenters):
        force, moment = float(press.forces[index]), press.moments[index]
        # A force -F along z at (x, y) has the moment (-y F, x F).
        centre = np.array([moment[1], -moment[0]]) / force if force > 0 else np.full(2, np.nan)
        area = sum(
            float(touch.share[touch.body == index].sum())
            * (press.grid.pitch / touch.window.split) ** 2
            for touch in press.touches
        )
        peak = float(pressure[index].max())
        depth = float(press.approach[index])
        parts.append(Part(indenter, force, depth, centre, area, peak))
    return parts


def pressure_by_body(press: Press) -> Floats:
    """Mean pressure (bodies, K) Pa on each cell by each indenter; their sum is `press.pressure`."""
    out = np.zeros((len(press.indenters), *press.grid.shape))
    for touch in press.touches:
        for index in range(len(press.indenters)):
            push = np.where(touch.body == index, -touch.traction[2], 0.0)
            out[index][touch.window.cells] += touch.window.means(push)
    return out.reshape(len(press.indenters), -1)


def base_stress_below_cells(press: Press) -> Floats:
    """Normal stress (K,) Pa on the base below the centre of each cell, positive in compression.

    By convolution of the cells' mean tractions: for maps, where `Press.base_stress` at each cell
    would take long. The two agree where cells are smaller than the layer is thick.
    """
    rows, columns = press.grid.shape
    offsets, pitch = lattice(rows - 1, columns - 1, press.grid.pitch), press.grid.pitch
    traction = press.traction.reshape(rows, columns, 3)
    if not traction[..., :2].any():
        response = press.mechanics.base_stress(press.layer, offsets, pitch, 0.0)
        kernel = mirrored(response.reshape(rows, columns))
        return np.asarray(LatticeConvolution(kernel)(-traction[..., 2])).ravel()
    response = press.mechanics.base_traction(press.layer, offsets, pitch, 0.0)[:, 2]
    along = response.T.reshape(3, rows, columns)
    total = np.zeros((rows, columns))
    for axis, (odd_x, odd_y) in enumerate(((True, False), (False, True), (False, False))):
        kernel = mirrored(along[axis], odd_x=odd_x, odd_y=odd_y)
        total -= LatticeConvolution(kernel)(traction[..., axis])
    return total.ravel()
