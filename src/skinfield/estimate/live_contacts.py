"""Contacts of a live loop: rows of numbers with an uncertainty and a number that lasts."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, Ints, check_shape
from skinfield.estimate.finder import EXACT, ContactFinder
from skinfield.estimate.track_memory import CONFIRMED, TrackMemory
from skinfield.estimate.tracker import Tracker
from skinfield.estimate.uncertainty import (
    ModelError,
    PressureError,
    PressureNoise,
    PressurePosterior,
)
from skinfield.skin import Grid

CONTACT = np.dtype(
    [
        ("track", np.int64),
        ("patch", np.int32),
        ("cells", np.int32),
        ("position", np.float64, (3,)),
        ("normal", np.float64, (3,)),
        ("x", np.float64),
        ("y", np.float64),
        ("normal_force", np.float64),
        ("force_std", np.float64),
        ("place_std", np.float64),
        ("area", np.float64),
        ("peak_pressure", np.float64),
        ("moments", np.float64, (3,)),
        ("age", np.float64),
        ("speed", np.float64),
        ("shape", np.int32),
        ("maybe", np.int32),
        ("radius", np.float64),
        ("covariance", np.float64, (6,)),
        ("area_std", np.float64),
    ]
)
SHAPES = ("other", "sphere", "flat", "line")  # what `shape` is an index into
ROOM = 2  # contacts that are followed, for each row


class GridLevel(NamedTuple):
    """What is known of the answers on one grid.

    Attributes
    ----------
    std : (K,) array, Pa
        By which contacts stand out.
    heights : tuple
        Columns of the grid, and the finder's limits, as `regions_kernel.find` takes them.
    positions, normals : (K, 3) arrays
    factor : (K, L) float32 array, Pa
    prior : array, Pa²
        Of a posterior: see `PressurePosterior`.
    signatures : (K, L) float32 array, 1/Pa
    numbers : array
        As the kernel names them.
    """

    std: Floats
    heights: tuple[int, float, float, float, float]
    positions: Floats
    normals: Floats
    factor: NDArray[np.float32]
    prior: Floats
    signatures: NDArray[np.float32]
    numbers: Floats


def level_of(
    grid: Grid,
    noise: PressureError,
    error: PressureError | None = None,
    model_error: ModelError = EXACT,
    finder: ContactFinder | None = None,
    *,
    signatures: ArrayLike | None = None,
    threshold: float = 0.0,
) -> GridLevel:
    """What is known of the answers on one grid, for `LiveContacts`; arguments as `ContactFinder`.

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
    numbers = [grid.shape[1], grid.pitch, *grid.origin, model_error.force, model_error.place]
    return GridLevel(
        std=_as_compiled(noise.std),
        heights=(grid.shape[1], *known.heights(noise)),
        positions=_as_compiled(grid.positions),
        normals=_as_compiled(grid.normals),
        factor=factor,
        prior=_as_compiled(prior),
        signatures=np.array(read, np.float32, order="C"),
        numbers=np.array([*numbers, sign, 0.0 if signatures is None else threshold]),
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


class LiveContacts:
    """The strongest contacts of one patch, reading after reading, in rows that are handed in.

    Which contacts there are is as a `ContactFinder` says. `force_std` and `place_std` (of either
    tangent) are those of the covariance of its `Contact`, of a region of more than 96 cells by as
    many of them, evenly; NaN if the covariance is neither that of a `PressureNoise` nor of a
    `PressurePosterior` of the whole grid. `track`, `age` and `speed` are those of a `Tracker` to
    which the rows are handed; a contact that it has not confirmed yet has a number, too, which
    changes if it turns out to be an absorbed one that came back. Nothing is allocated per reading.

    Parameters
    ----------
    levels : sequence of GridLevel
        Of each kind of answer, see `level_of`.
    patch : int
        For the rows.
    rows : int
        Contacts that are told, at most.
    tracker : Tracker, optional
        Whose settings count.
    ids : (1,) int64 array, optional
        The last number that was given, which may be shared between patches.

    Attributes
    ----------
    memory : TrackMemory
        Contacts of before, events and `ids`: all that lasts.
    """

    def __init__(
        self,
        levels: Sequence[GridLevel],
        *,
        patch: int = 0,
        rows: int = 8,
        tracker: Tracker | None = None,
        ids: Ints | None = None,
    ) -> None:
        from skinfield.estimate.live_contacts_kernel import take_rows, tell
        from skinfield.estimate.regions_kernel import find, room_for
        from skinfield.estimate.tracking_kernel import number_rows

        if rows < 1 or not levels:
            raise InputError(f"rows is {rows} on {len(levels)} levels, expected 1 or more of each")
        self.levels, self.patch, self.most = tuple(levels), int(patch), int(rows)
        rules = (Tracker() if tracker is None else tracker).rules
        self.memory = TrackMemory.of(ROOM * rows, rules, np.zeros(1, int) if ids is None else ids)
        self._find: Any = find
        self._tell: Any = tell
        self._take_rows: Any = take_rows
        self._number: Any = number_rows
        self._rooms = []
        for level in self.levels:
            room = room_for(len(level.std), level.heights[0])
            taxels = level.signatures.shape[1]
            moved = np.zeros((4, max(taxels, level.factor.shape[1])))
            self._rooms.append((level, room, moved, np.zeros(taxels)))

    def __call__(
        self,
        level: int,
        pressure: Floats,
        stamp_ns: int,
        out: NDArray[np.void],
        whitened: NDArray[Any] | None = None,
    ) -> int:
        """Write the contacts of a field into `out`; how many there are, which may be more.

        Parameters
        ----------
        level : int
            Which of `levels` the pressure is of.
        pressure : (K,) float64 array, contiguous, Pa
        stamp_ns : int, ns
            Of the reading.
        out : structured array of `CONTACT`, at most `rows`
            By falling force; those after the last contact keep what they had. `position` (m, in
            the patch's frame) lies on the skin, `x` and `y` are its place in the plane, `moments`
            the second moments xx, yy, xy of the pressure about it there (m²).
        whitened : (L,) array, optional
            The readings in units of their noise, 0 where left out, for a level with signatures.

        Raises
        ------
        InputError
            For arrays of another size.
        """
        known, room, moved, residual = self._rooms[level]
        if pressure.shape != known.std.shape or len(out) > self.most:
            check_shape("pressure", pressure, known.std.shape, "one per node of the grid")
            raise InputError(f"out has {len(out)} rows, expected at most {self.most}")
        if whitened is not None and len(residual) == len(whitened):
            residual[:] = whitened
        std, heights, *arrays = known
        count = self._find(pressure, std, *heights, *room)
        count = int(
            self._tell(
                pressure,
                count,
                *arrays,
                *room[1:],
                moved,
                residual,
                self.patch,
                out,
            )
        )
        self._number(self.memory, min(count, len(out)), stamp_ns, out)
        return count

    def take(
        self,
        rows: NDArray[np.void],
        count: int,
        shift: Floats,
        stamp_ns: int,
        out: NDArray[np.void],
    ) -> int:
        """Write contacts that a solver has found by itself into `out`; how many there are.

        Parameters
        ----------
        rows : (N,) structured array of `CONTACT`, contiguous
            By falling force, on a patch of equal geometry; `count` of them.
        shift : (2,) array, m
            From that patch's plane to this one's.
        stamp_ns, out
            As in a call.
        """
        known = self.levels[-1]
        count = int(
            self._take_rows(
                rows,
                rows.view(np.int64),
                count,
                shift,
                known.positions,
                known.normals,
                known.numbers,
                self.patch,
                out,
                out.view(np.int64),
            )
        )
        self._number(self.memory, min(count, len(out)), stamp_ns, out)
        return count

    def reset(self) -> None:
        """Forget the contacts of before; numbers go on."""
        self.memory.reset()

    def begin_from(self, rows: NDArray[np.void], stamp_ns: int) -> None:
        """Know of the contacts (N,) that rows state at `stamp_ns`, and of nothing else.

        Of their speed nothing is taken over; those of their first reading are confirmed if strong.
        """
        self.reset()
        if len(rows):
            ids = int(self.memory.ids[0])
            self.take(rows, len(rows), np.zeros(2), stamp_ns, rows.copy())
            self.memory.ids[0] = ids
            tracks = self.memory.tracks[: len(rows)]
            its = rows[tracks["column"]]
            tracks["number"], made = its["track"], stamp_ns - np.rint(its["age"] * 1e9).astype(int)
            tracks["made"] = tracks["slipped"] = made
            tracks["state"][made < stamp_ns] = CONFIRMED
