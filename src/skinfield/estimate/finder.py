"""Contact finder: regions of pressure that stand out of the noise, and what they amount to."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, Ints, check_shape
from skinfield.estimate.contact import Contact
from skinfield.estimate.row_contacts import CONTACT, contacts_of_rows
from skinfield.estimate.uncertainty import (
    ModelError,
    PressureError,
    PressureNoise,
    PressurePosterior,
)
from skinfield.settings import Range, Section
from skinfield.skin import Grid

EXACT = ModelError()
FEW = 16  # rows that are tried first


class GridLevel(NamedTuple):
    """What is known of the answers on one grid: a prepared finder of contacts.

    Attributes
    ----------
    std : (K,) array, Pa
        By which contacts stand out.
    positions, normals : (K, 3) arrays
    factor : (K, L) float32 array, Pa
    prior : array, Pa²
        Of a posterior: see `PressurePosterior`.
    signatures : (K, L) float32 array, 1/Pa
    numbers : (13,) array
        As `live_contacts_kernel` names them, from `HEIGHTS` on the finder's limits.
    """

    std: Floats
    positions: Floats
    normals: Floats
    factor: NDArray[np.float32]
    prior: Floats
    signatures: NDArray[np.float32]
    numbers: Floats

    def room(self) -> tuple[Any, ...]:
        """Where `find_rows` works on fields of this grid, again and again."""
        from skinfield.estimate.regions_kernel import room_for

        taxels = self.signatures.shape[1]
        moved = np.zeros((4, max(taxels, self.factor.shape[1])))
        return *room_for(len(self.std), int(self.numbers[0])), moved, np.zeros(taxels)


def level_of(
    grid: Grid,
    noise: PressureError,
    error: PressureError | None = None,
    model_error: ModelError = EXACT,
    finder: "ContactFinder | None" = None,
    *,
    signatures: ArrayLike | None = None,
    threshold: float = 0.0,
) -> GridLevel:
    """What is known of the answers on one grid; other arguments as of a `ContactFinder`'s call.

    Parameters
    ----------
    signatures : (K, L) array, 1/Pa, optional
        What each cell's pressure reads on the taxels, in units of their noise.
    threshold : float
        Standard deviations that each further contact must stand out of the noise by; 0: it is as
        the regions say, as for linear answers, whose noise is in their heights.

    Raises
    ------
    InputError
        For a noise of another number of nodes.
    """
    check_shape("noise.std", noise.std, (len(grid),), "one per node of the grid")
    known = ContactFinder() if finder is None else finder
    factor, prior, sign = _covariance(grid, noise if error is None else error)
    read = np.zeros((1, 1)) if signatures is None else signatures
    least = 0.0 if signatures is None else threshold
    numbers = [grid.shape[1], grid.pitch, *grid.origin]
    numbers += [model_error.force, model_error.place, sign, least, grid.cell_area]
    return GridLevel(
        std=_as_compiled(noise.std),
        positions=_as_compiled(grid.positions),
        normals=_as_compiled(grid.normals),
        factor=factor,
        prior=_as_compiled(prior),
        signatures=np.array(read, np.float32, order="C"),
        numbers=np.array([*numbers, known.sigmas(noise), *known.shares]),
    )


def _as_compiled(array: Floats) -> Floats:
    """As the kernels are compiled for: others would be compiled for anew."""
    return np.require(array, np.float64, ("C", "W"))


def _covariance(grid: Grid, error: PressureError) -> tuple[NDArray[np.float32], Floats, float]:
    """Factor (K, L), prior by offset, and the sign of what the factor tells; 0 if not known."""
    if isinstance(error, PressureNoise):
        return error.single, np.zeros((1, 1)), 1.0
    if isinstance(error, PressurePosterior):
        steps = np.stack(np.divmod(np.arange(len(grid)), grid.shape[1]), axis=1)
        covers = min(len(error.prior) - grid.shape[0], error.prior.shape[1] - grid.shape[1]) >= 0
        if covers and np.array_equal(error.steps, steps):
            return error.single, error.prior, -1.0
    return np.zeros((len(grid), 1), np.float32), np.zeros((1, 1)), 0.0


@lru_cache(maxsize=256)
def _significance(false_alarm_rate: float, chances: int) -> float:
    """Standard deviations that one of `chances` normal numbers exceeds at the given rate."""
    from scipy.special import ndtri

    return float(-ndtri(false_alarm_rate / chances))


@dataclass(frozen=True, kw_only=True)
class ContactFinder(Section):
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

    false_alarm_rate: Annotated[float, Range(1e-12, 0.5, "a share of readings")] = 1e-3
    relative_height: Annotated[float, Range(0.0, 1.0, "a fraction of a peak")] = 0.2
    prominence: Annotated[float, Range(0.0, 1.0, "a fraction of a peak")] = 0.3
    edge: Annotated[float, Range(0.0, 1.0, "a fraction of a peak")] = 0.2

    def sigmas(self, noise: PressureError) -> float:
        """Standard deviations by which a peak must exceed the noise of the cells that feel it."""
        return _significance(self.false_alarm_rate, max(noise.felt, 1))

    @property
    def shares(self) -> tuple[float, float, float]:
        """Relative height, prominence and edge."""
        return self.relative_height, self.prominence, self.edge

    def __call__(
        self,
        grid: Grid,
        pressure: Floats,
        noise: PressureError,
        error: PressureError | None = None,
        model_error: ModelError = EXACT,
    ) -> tuple[Contact, ...]:
        """Contacts of one field.

        Parameters
        ----------
        grid : Grid
        pressure : (K,) array, Pa
        noise : PressureError
            Of the pressure: what stands out of it is a contact.
        error : PressureError, optional
            How far the pressure may be from the truth, if the solver states more than its noise.
        model_error : ModelError
            What is wrong with the contacts beside.

        Returns
        -------
        tuple of Contact
            By falling normal force; of equal ones (to 1e-9), the one with the smallest cell first.

        Raises
        ------
        InputError
            If the pressure or the noise is not one number for each node.
        """
        flat = _as_compiled(pressure)
        if not flat.shape == noise.std.shape == (len(grid),):
            check_shape("pressure", flat, (len(grid),), "one per node of the grid")
            check_shape("noise.std", noise.std, (len(grid),), "one per node of the grid")
        level = level_of(grid, noise, error, model_error, self)
        return contacts_on(level, grid, flat, noise if error is None else error, model_error)


def contacts_on(
    level: GridLevel,
    grid: Grid,
    pressure: Floats,
    error: PressureError,
    model_error: ModelError,
    whitened: Floats | None = None,
) -> tuple[Contact, ...]:
    """All contacts of a field (K,) Pa on a level of this grid, as `LiveContacts` has the strongest.

    An error of another kind than the compiled ones states its covariance of sums over cells.
    `whitened` (L,) are the readings in units of their noise, for a level with signatures.
    """
    from skinfield.estimate import live_contacts_kernel as kernel
    from skinfield.estimate.regions_kernel import REGIONS, SPARE, STARTS

    if not (pressure > level.numbers[kernel.HEIGHTS] * level.std).any():  # as in most readings
        return ()
    find_rows: Any = kernel.find_rows
    room, rows, count = level.room(), np.zeros(0, CONTACT), FEW
    while count > len(rows):
        rows = np.zeros(count, CONTACT)
        if whitened is not None:
            room[-1][:] = whitened
        count = int(find_rows(pressure, *level, *room, 0, rows))
    rows, (starts, cells, listed) = rows[:count], room[2][[STARTS, REGIONS, SPARE]]
    parts = [cells[starts[region] : starts[region + 1]].copy() for region in listed[:count]]
    if not level.numbers[kernel.SIGN]:
        for row, part in zip(rows, parts, strict=True):
            row["covariance"] = _stated(grid, pressure, part, error, model_error)
    return contacts_of_rows(rows, grid, pressure, parts)


def _stated(
    grid: Grid, pressure: Floats, cells: Ints, error: PressureError, model_error: ModelError
) -> Floats:
    """Covariance of a region's place and force as a row has it, to first order, (6,)."""
    total = float(pressure[cells].sum())
    away = grid.plane[cells] - pressure[cells] @ grid.plane[cells] / total
    moves = grid.cell_area * np.vstack([away.T / (total * grid.cell_area), np.ones(len(cells))])
    known = error.covariance_of_sums(cells, moves)
    known = known + model_error.covariance(total * grid.cell_area)
    return np.asarray(known[np.tril_indices(3)])
