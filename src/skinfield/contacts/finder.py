"""From a pressure field to contacts: regions that stand out of the noise."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts.regions import border, regions
from skinfield.errors import Floats, check_range
from skinfield.fields import Contact, PressureNoise
from skinfield.layout import Grid


@lru_cache(maxsize=256)
def _significance(false_alarm_rate: float, chances: int) -> float:
    """Standard deviations that one of `chances` normal numbers exceeds at the given rate."""
    from scipy.special import ndtri

    return float(-ndtri(false_alarm_rate / chances))


@dataclass(frozen=True, kw_only=True)
class ContactFinder:
    """Connected regions of pressure above the noise.

    Parameters
    ----------
    false_alarm_rate : float
        Readings of an idle patch in which a contact may be seen. A peak must exceed the noise's
        quantile at this rate over as many chances as there are cells that feel it.
    relative_height : float
        A peak must reach this fraction of the highest: linear solvers ring beside a press.
    prominence : float
        Two peaks are two contacts if the lower stands out of the saddle by this fraction of
        itself; else one.
    edge : float
        A region ends where the pressure falls to this fraction of its peak.
    """

    false_alarm_rate: float = 1e-3
    relative_height: float = 0.2
    prominence: float = 0.3
    edge: float = 0.2

    def __post_init__(self) -> None:
        check_range("false_alarm_rate", self.false_alarm_rate, 1e-12, 0.5, "a share of readings")
        for name in ("relative_height", "prominence", "edge"):
            check_range(name, getattr(self, name), 0.0, 1.0, "a fraction of a peak")

    def __call__(self, grid: Grid, pressure: Floats, noise: PressureNoise) -> tuple[Contact, ...]:
        """Contacts of one field.

        Parameters
        ----------
        grid : Grid
        pressure : (K,) array, Pa
        noise : PressureNoise
            Of the pressure.

        Returns
        -------
        tuple of Contact
            By falling normal force.
        """
        chances = max(int(np.count_nonzero(noise.std)), 1)
        sigmas = _significance(self.false_alarm_rate, chances)
        highest = float(pressure.max())
        needed = np.maximum(sigmas * noise.std, self.relative_height * highest)
        if not (pressure > needed).any():
            return ()
        picture = pressure.reshape(grid.shape)
        drop = np.maximum(self.prominence * picture, sigmas * noise.std.reshape(grid.shape))
        floor = np.full(grid.shape, self.edge * self.relative_height * highest)
        found = regions(picture, drop, floor, self.edge)
        found = [cells for cells in found if (pressure > needed)[cells].any()]
        contacts = [_contact(grid, pressure, cells, noise) for cells in found]
        return tuple(sorted(contacts, key=lambda contact: -contact.normal_force))


def _contact(
    grid: Grid, pressure: Floats, cells: NDArray[np.int64], noise: PressureNoise
) -> Contact:
    weight = pressure[cells] * grid.cell_area
    total = float(weight.sum())
    centre = weight @ grid.plane[cells] / total
    surface = grid.patch.surface
    position = surface.position_from_plane(centre[None])[0]
    normal = surface.frame_from_plane(centre[None])[0, :, 2]
    forces = -weight[:, None] * grid.normals[cells]
    lever = grid.positions[cells] - position
    away = grid.plane[cells] - centre
    spread = (away * weight[:, None]).T @ away / total + np.eye(2) * grid.cell_area / 12
    variance, direction = np.linalg.eigh(spread)
    angle = float(np.arctan2(direction[1, 1], direction[0, 1]))
    corners = grid.origin + border(cells, grid.shape) * grid.pitch
    area = len(cells) * grid.cell_area
    ones = np.ones(len(cells))
    moves = np.stack([*(away / total).T, ones]) * grid.cell_area  # of the place and the force
    return Contact(
        position=position,
        force=forces.sum(axis=0),
        moment=np.cross(lever, forces).sum(axis=0),
        normal=normal,
        area=area,
        peak_pressure=float(pressure[cells].max()),
        covariance=noise.covariance_of_sums(cells, moves),
        area_std=grid.cell_area,
        radius=float(np.sqrt(area / np.pi)),
        shape="other",
        outline=surface.position_from_plane(corners),
        axes=2.0 * np.sqrt(variance[::-1]),  # of a uniform ellipse with these moments
        angle=(angle + np.pi / 2) % np.pi - np.pi / 2,
        cells=cells,
    )
