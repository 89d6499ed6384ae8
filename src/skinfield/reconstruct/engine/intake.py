"""Readings of all patches into one array: checked, linearised and in units of their noise."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import Capacitance, Quantity
from skinfield.errors import Floats, InputError, Ints, as_floats
from skinfield.reconstruct.engine.products import Singles
from skinfield.skin import Patch

Readings = Mapping[str, ArrayLike] | Sequence[ArrayLike]


class Intake:
    """Where the readings of a cycle are.

    Parameters
    ----------
    patches : sequence of Patch
        In the order of the arrays.
    order : sequence of int
        Place of each of them in the skin, which is that of readings that come as a sequence.
    quantity : Quantity
    noise_std : (N,) array
        Of all taxels.

    Attributes
    ----------
    starts : (P + 1,) list of int
        Where each patch's taxels begin.
    linear : (N,) array
        Linearised readings; 0 where invalid. With `white` it is written as a cycle opens.
    white : (N,) float32 array
        In units of their noise.
    valid : (N,) bool array
        Not NaN, not left out, and a number that a skin reads: finite, and not too low.
    present : (P,) bool array
        Patches that gave a reading.
    given, asked, places : (N,) arrays
        What was given, whether to use it, and where there each taxel stands.
    how : int
        How it is linearised: see `_linearised_how`.
    straight : (N,) array
        Room for what was taken in, linearised.
    per_noise : (N,) array
    """

    def __init__(
        self,
        patches: Sequence[Patch],
        order: Sequence[int],
        quantity: Quantity,
        noise_std: Floats,
    ) -> None:
        from skinfield.reconstruct.engine.cycle_kernel import take as gather

        self.names = [patch.name for patch in patches]
        self.order, self.quantity = list(order), quantity
        self.sizes = [len(patch) for patch in patches]
        self.starts = [0, *np.cumsum(self.sizes).tolist()]
        taxels = self.starts[-1]
        self.raw, self.linear, self.straight, self.given = np.zeros((4, taxels))
        self.white: Singles = np.zeros(taxels, np.float32)
        self.valid, self._every, self._asked = np.ones((3, taxels), np.bool_)
        self.present = np.ones(len(patches), np.bool_)
        self.all_valid = True
        self.per_noise = 1.0 / noise_std
        self._nothing = [np.zeros(size) for size in self.sizes]
        self._in_skin, self._here = self._places_in_skin(), np.arange(taxels)
        self._gather = gather
        self.asked, self.places = self._every, self._here
        self.how = _linearised_how(quantity, self.raw)

    def take(self, readings: Readings, valid: Mapping[str, ArrayLike] | None) -> None:
        """Take the readings of a cycle.

        Raises
        ------
        InputError
            For a name that no patch has, or another number of taxels.
        """
        rows = self._rows(readings)
        try:
            sized = list(map(len, rows)) == self.sizes
            np.concatenate(rows, out=self.given)
        except (TypeError, ValueError):
            sized = False
        if not sized:
            self._blame(rows)
        if valid is not None:
            self._leave_out(valid)
        self.asked = self._every if valid is None else self._asked
        self.places = self._here

    def take_flat(self, readings: Floats, valid: NDArray[np.bool_] | None) -> None:
        """Take the readings (N,) of all taxels, patch by patch in the skin's order.

        Raises
        ------
        InputError
            For another number of taxels, or type.
        """
        _check_flat("readings", readings, self.given)
        self.given[:] = readings
        if valid is not None:
            _check_flat("valid", valid, self._asked)
            self._asked[:] = valid
        self.present[:] = True
        self.asked = self._every if valid is None else self._asked
        self.places = self._in_skin

    def linearise(self) -> None:
        """Gather what was given into `straight` as the quantity says; 0 for what is not valid."""
        given, lowest = self.given, self.quantity.lowest
        self.all_valid = self._gather(given, self.asked, self.places, lowest, self.raw, self.valid)
        straight = self.quantity.linearise(self.raw, self.straight)
        if straight is not self.straight:
            self.straight[:] = straight

    def _places_in_skin(self) -> Ints:
        """Where each taxel stands among those of the skin, patch by patch in its order."""
        sizes = np.zeros(len(self.order), dtype=np.int64)
        sizes[self.order] = self.sizes
        starts = np.concatenate([[0], np.cumsum(sizes)])[self.order]
        ranges = [start + np.arange(n) for start, n in zip(starts, self.sizes, strict=True)]
        return np.asarray(np.concatenate(ranges), dtype=np.int64)

    def rows_of(self, place: int) -> slice:
        """Taxels of a patch."""
        return slice(self.starts[place], self.starts[place + 1])

    def _rows(self, readings: Readings) -> list[Any]:
        self.present[:] = True
        if isinstance(readings, Mapping):
            rows = [readings.get(name) for name in self.names]
            given = len(rows) - sum(row is None for row in rows)
            if given < len(readings):
                self._check_names(readings)
        else:
            if len(readings) != len(self.names):
                raise InputError(
                    f"readings has {len(readings)} entries, expected one for each of the "
                    f"{len(self.names)} patches in the skin's order, None where there is none; "
                    "or a mapping from names"
                )
            rows = [readings[place] for place in self.order]
            given = len(rows) - sum(row is None for row in rows)
        if given < len(rows):
            for place, row in enumerate(rows):
                if row is None:
                    self.present[place] = False
                    rows[place] = self._nothing[place]
        return rows

    def _check_names(self, given: Mapping[str, Any]) -> None:
        unknown = [name for name in given if name not in self.names]
        if unknown:
            known = ", ".join(self.names[:8])
            raise InputError(
                f"readings names {unknown[0]!r}, which is no patch, expected names among {known}"
                f"{', ...' if len(self.names) > 8 else ''}"
            )

    def _blame(self, rows: Sequence[ArrayLike]) -> None:
        """Name the patch whose readings do not fit."""
        for name, size, row in zip(self.names, self.sizes, rows, strict=True):
            shape = as_floats(f"readings[{name!r}]", row).shape
            if shape != (size,):
                raise InputError(
                    f"readings[{name!r}] has shape {shape}, expected ({size},): one per taxel; "
                    "an engine takes one reading of each patch in a cycle"
                )
        np.concatenate([as_floats("readings", row) for row in rows], out=self.given)

    def _leave_out(self, valid: Mapping[str, ArrayLike]) -> None:
        self._check_names(valid)
        self._asked[:] = True
        for place, name in enumerate(self.names):
            if name in valid:
                mask = np.asarray(valid[name], dtype=np.bool_)
                if mask.shape != (self.sizes[place],):
                    raise InputError(
                        f"valid[{name!r}] has shape {mask.shape}, expected "
                        f"({self.sizes[place]},): one per taxel"
                    )
                self._asked[self.rows_of(place)] = mask

    def views(self, array: NDArray[Any], first: int, count: int) -> NDArray[Any]:
        """Rows (count, L) of patches of one size in an array (N,)."""
        low, high = self.starts[first], self.starts[first + count]
        return array[low:high].reshape(count, -1)


def _check_flat(name: str, given: NDArray[Any], like: NDArray[Any]) -> None:
    if given.shape != like.shape or given.dtype != like.dtype:
        raise InputError(
            f"{name} has shape {given.shape} of {given.dtype}, expected {like.shape} of "
            f"{like.dtype}: one per taxel, patch by patch in the skin's order"
        )


def _linearised_how(quantity: Quantity, example: Floats) -> int:
    """0 if readings are linear as they are, 1 if c becomes c / (1 + c), 2 if the quantity knows."""
    if type(quantity) is Capacitance and quantity.order != 1:
        return 1
    return 0 if quantity.linearise(example, np.zeros_like(example)) is example else 2
