"""Contacts of a live loop: rows of numbers with an uncertainty and a number that lasts."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, Ints, check_shape
from skinfield.estimate.finder import GridLevel
from skinfield.estimate.row_contacts import CONTACT as CONTACT
from skinfield.estimate.track_memory import CONFIRMED, TrackMemory
from skinfield.estimate.tracker import Tracker

ROOM = 2  # contacts that are followed, for each row


class LiveContacts:
    """The strongest contacts of one patch, reading after reading, in rows that are handed in.

    They are those of a `ContactFinder`, bit for bit; deviations are NaN if the covariance is
    neither that of a `PressureNoise` nor of a `PressurePosterior` of the whole grid. `track`, `age`
    and `speed` are those of a `Tracker` to which the rows are handed; a contact that it has not
    confirmed yet has a number, too, which changes if it turns out to be an absorbed one that came
    back. Nothing is allocated per reading.

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
        from skinfield.estimate.live_contacts_kernel import find_rows, number_rows, take_rows

        if rows < 1 or not levels:
            raise InputError(f"rows is {rows} on {len(levels)} levels, expected 1 or more of each")
        self.levels, self.patch, self.most = tuple(levels), int(patch), int(rows)
        rules = (Tracker() if tracker is None else tracker).rules
        self.memory = TrackMemory.of(ROOM * rows, rules, np.zeros(1, int) if ids is None else ids)
        self._find: Any = find_rows
        self._take_rows: Any = take_rows
        self._number: Any = number_rows
        self._rooms = [(level, level.room()) for level in self.levels]

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
        known, room = self._rooms[level]
        residual = room[-1]
        if pressure.shape != known.std.shape or len(out) > self.most:
            check_shape("pressure", pressure, known.std.shape, "one per node of the grid")
            raise InputError(f"out has {len(out)} rows, expected at most {self.most}")
        if whitened is not None and len(residual) == len(whitened):
            residual[:] = whitened
        count = int(self._find(pressure, *known, *room, self.patch, out))
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
