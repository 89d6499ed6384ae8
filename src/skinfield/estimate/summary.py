"""Contacts as a short table of numbers, for loops that have no time for more."""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_shape
from skinfield.estimate.finder import ContactFinder
from skinfield.estimate.uncertainty import PressureError
from skinfield.skin import Grid

ROW = np.dtype(
    [
        ("x", np.float64),
        ("y", np.float64),
        ("normal_force", np.float64),
        ("area", np.float64),
        ("peak_pressure", np.float64),
        ("cells", np.int64),
    ]
)


class ContactTable:
    """The strongest contacts of one field after the other, written into the same few rows.

    They are those of a `ContactFinder`, by the same rules of peak, saddle and edge. Of a contact
    there is less: no covariance, outline or axes, the place in the plane alone. The force is the
    sum of the pressure; on a curved skin a `Contact` has the part of it along one normal, which is
    less. Nothing is allocated per field.

    Parameters
    ----------
    grid : Grid
    rows : int
        At most so many contacts are told.
    finder : ContactFinder, optional
    noise : PressureError, optional
        Of the pressure: what stands out of it is a contact. Default none, for fields that are
        exactly 0 where nothing presses, such as those of `NonNegative`: there whatever is above 0
        and `relative_height` of the highest is a contact, and two peaks are two wherever
        `prominence` says so, though the noise may be deeper than the saddle.

    Attributes
    ----------
    rows : structured (rows,) array
        Fields `x`, `y` (m, in the patch's plane), `normal_force` (N), `area` (m²),
        `peak_pressure` (Pa) and `cells` (their number), by falling force. Those after the last
        contact of the last field keep what they had.
    """

    def __init__(
        self,
        grid: Grid,
        rows: int = 8,
        *,
        finder: ContactFinder | None = None,
        noise: PressureError | None = None,
    ) -> None:
        from skinfield.estimate.regions_kernel import room_for, tabulate

        if rows < 1:
            raise InputError(f"rows is {rows}, expected 1 or more contacts that may be told")
        self.grid = grid
        self.rows: NDArray[np.void] = np.zeros(rows, ROW)
        std = np.zeros(len(grid)) if noise is None else noise.std
        check_shape("noise.std", std, (len(grid),), "one per node of the grid")
        self._std = np.require(std, np.float64, ("C", "W"))
        known = ContactFinder() if finder is None else finder
        sigmas = 1.0 if noise is None else known.sigmas(noise)
        self._heights = sigmas, known.relative_height, known.prominence, known.edge
        self._origin, self._work = np.array(grid.origin), room_for(*grid.shape)
        self._tabulate = tabulate
        self(np.zeros(len(grid)))  # so that the first field is as fast as the next

    def __call__(self, pressure: Floats) -> int:
        """Write the contacts of a field; how many there are, which may be more than rows.

        Parameters
        ----------
        pressure : (K,) array of float64, contiguous, Pa

        Raises
        ------
        InputError
            For another number of nodes.
        """
        grid = self.grid
        if pressure.shape != self._std.shape:
            check_shape("pressure", pressure, self._std.shape, "one per node of the grid")
        count = self._tabulate(
            pressure,
            self._std,
            grid.shape[1],
            self._origin,
            grid.pitch,
            self._heights,
            self._work,
            self.rows,
        )
        return int(count)


def summarise(
    grid: Grid,
    pressure: Floats,
    *,
    rows: int = 8,
    finder: ContactFinder | None = None,
    noise: PressureError | None = None,
) -> NDArray[np.void]:
    """Contacts of one field as rows of numbers; a `ContactTable` that is kept is much faster.

    Parameters
    ----------
    grid : Grid
    pressure : (K,) array, Pa
    rows, finder, noise
        See `ContactTable`.

    Returns
    -------
    structured array
        As `ContactTable.rows`, only as long as there are contacts.
    """
    table = ContactTable(grid, rows, finder=finder, noise=noise)
    count = table(np.require(pressure, np.float64, ("C", "W")))
    return table.rows[:count].copy()
