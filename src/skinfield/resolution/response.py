"""How strongly a touch at any place moves the readings, and how that changes with the touch."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats, InputError, Ints
from skinfield.resolution.design import SkinDesign, Touch

if TYPE_CHECKING:
    from skinfield.inverse.atoms.kernel import Tables

BLOCK = 4096  # places whose neighbouring taxels are listed at once
FAINT = 1e-6  # of the strongest reading per newton: what is below is no response
TRIAL = 1e-3  # N: at which readings are proportional to the force
DEEPEST = 0.9  # of the gap: beyond it the elastomer is flat


@dataclass(frozen=True, eq=False)
class Responses:
    """Inner products of the whitened readings of a touch and of their derivatives, per place.

    Attributes
    ----------
    gram : (P, 5, 5) array
        Of the readings y / noise and their derivatives by x m, y m, ln force and ln radius. So
        [:, 0, 0] is the squared signal-to-noise ratio and [:, 1:, 1:] the Fisher information.
    """

    gram: Floats

    @property
    def snr(self) -> Floats:
        """Signal-to-noise ratio of a matched filter, (P,)."""
        return np.asarray(np.sqrt(self.gram[:, 0, 0]))

    @property
    def turn(self) -> Floats:
        """How the direction of the readings turns with the place: metric (P, 2, 2), 1/m²."""
        power = np.maximum(self.gram[:, 0, 0], np.finfo(float).tiny)[:, None, None]
        across = self.gram[:, 1:3, 0] / power[:, 0]  # its square could underflow
        return np.asarray(self.gram[:, 1:3, 1:3] / power - across[:, :, None] * across[:, None, :])


def tables_of_design(design: SkinDesign) -> "Tables":
    """Readings of round contacts on this skin, as compiled functions take them."""
    from skinfield.inverse.atoms.kernel import tables_of
    from skinfield.inverse.atoms.table import atom_table

    return tables_of(atom_table(design.physics))


def largest_force(design: SkinDesign, radius: float) -> float:
    """Force in N at which a contact of some radius in m has closed the gap to DEEPEST of it.

    Infinite where readings are taken as proportional to the force.
    """
    from skinfield.inverse.atoms.profiles import BALL, unit_indentation

    if not tables_of_design(design).strain.size:
        return float("inf")
    axis = np.array([1e-6 * radius])
    sunk = unit_indentation(design.layer, design.mechanics, BALL, radius, axis)
    return float(DEEPEST * design.layer.thickness / sunk[0])


def check_depth(design: SkinDesign, touch: Touch) -> None:
    """Raise InputError where the touch would reach the base of the elastomer."""
    most = largest_force(design, touch.radius)
    if touch.force > most:
        raise InputError(
            f"force is {touch.force:g} N on a contact of radius {touch.radius * 1e3:g} mm, "
            f"expected at most {most:.3g} N: it would press the elastomer flat; take less force, a "
            "wider contact, a harder or thicker elastomer, or only the linear response"
        )


def sight_of(design: SkinDesign, radius: float) -> float:
    """Distance in m from a contact's middle beyond which a taxel reads nothing."""
    from skinfield.inverse.atoms.table import SIGHT

    return radius + design.patch.pad_diameter / 2 + SIGHT * design.layer.thickness


def respond(
    design: SkinDesign, touch: Touch, points: Floats, forces: Floats | None = None
) -> Responses:
    """Responses to a touch at points (P, 2) m of the plane, from the taxels within its sight.

    Memory grows with P alone: taxels are listed for some thousand places at a time.

    Parameters
    ----------
    design : SkinDesign
    touch : Touch
    points : (P, 2) array, m
    forces : (P,) array, N, optional
        Instead of the touch's, place by place.
    """
    from skinfield.resolution.kernels import grams

    touch.check_on(design.layer)
    if forces is None:
        check_depth(design, touch)
        forces = np.full(len(points), touch.force)
    h, tables, logs = design.layer.thickness, tables_of_design(design), np.log(forces)
    taxels, white = design.patch.plane / h, 1.0 / design.noise
    gram = np.empty((len(points), 5, 5))
    for first in range(0, len(points), BLOCK):
        part = slice(first, first + BLOCK)
        start, rows = near_taxels(design, points[part], sight_of(design, touch.radius))
        scaled, log_radius = points[part] / h, float(np.log(touch.radius / h))
        grams(scaled, logs[part], log_radius, taxels, white, start, rows, tables, gram[part])
    unit = np.array([1.0, 1.0 / h, 1.0 / h, 1.0, 1.0])
    return Responses(gram * unit[:, None] * unit)


def near_taxels(design: SkinDesign, points: Floats, distance: float) -> tuple[Ints, Ints]:
    """Taxels within a distance of each point, nearest first.

    Returns
    -------
    start : (P + 1,) int array
        Where each point's taxels begin in `rows`.
    rows : (N,) int array
    """
    from scipy.spatial import cKDTree

    plane = design.patch.plane
    near: Any = cKDTree(plane).query_ball_point(points, distance)
    counts = np.array([len(rows) for rows in near], dtype=np.int64)
    start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    rows = np.concatenate([np.asarray(rows, dtype=np.int64) for rows in near])
    point = np.repeat(np.arange(len(points)), counts)
    away = np.linalg.norm(plane[rows] - points[point], axis=1)
    return start, rows[np.lexsort([away, point])]


def snr_per_newton(design: SkinDesign, radius: float, points: Floats) -> Floats:
    """Signal-to-noise ratio of a light touch of some radius in m, over its force: (P,), 1/N."""
    return respond(design, Touch(TRIAL, radius), points).snr / TRIAL
