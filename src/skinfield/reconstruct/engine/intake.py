"""Readings of all patches into one array: checked, linearised and in units of their noise."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import Capacitance, Quantity
from skinfield.errors import Floats, InputError, as_floats
from skinfield.reconstruct.engine.patch_kinds import Singles, check_names
from skinfield.signal.creep import CreepCompensation
from skinfield.skin import Patch

Readings = Mapping[str, ArrayLike] | Sequence[ArrayLike]


class EngineReadings:
    """Where the readings of a cycle are.

    Parameters
    ----------
    patches : sequence of Patch
        In the order of the arrays.
    order : sequence of int
        Place of each of them in the skin, whose order that of `given` is.
    quantity : Quantity
    noise_std : (N,) array
        Of all taxels.

    Attributes
    ----------
    starts : (P + 1,) list of int
        Where each patch's taxels begin.
    given, wanted, deviation, noise_std : (N,) arrays
        What was handed in, in the skin's order, whether to use it, its standard deviation, and that
        of single readings.
    places : (N,) int array
        Where in these each taxel stands.
    linear : (N,) array
        Linearised readings; 0 where invalid. With `white` it is written as a cycle opens.
    white : (N,) float32 array
        In units of their noise.
    valid : (N,) bool array
        Not NaN, not left out, and a number that a skin reads: finite, and not too low.
    present : (P,) bool array
        Patches that gave a reading.
    how : int
        How it is linearised: see `_linearised_how`.
    per_noise : (N,) array
    """

    def __init__(
        self, patches: Sequence[Patch], order: Sequence[int], quantity: Quantity, noise_std: Floats
    ) -> None:
        self.names = [patch.name for patch in patches]
        self.quantity = quantity
        self.sizes = [len(patch) for patch in patches]
        self.starts = [0, *np.cumsum(self.sizes).tolist()]
        taxels = self.starts[-1]
        self.linear, self.given = np.zeros((2, taxels))
        self.noise_std = np.empty(taxels)
        self.white: Singles = np.zeros(taxels, np.float32)
        self.valid = np.ones(taxels, np.bool_)
        self.wanted: NDArray[np.bool_] = np.ones(taxels, np.bool_)
        self.present = np.ones(len(patches), np.bool_)
        self.all_valid = True
        self.per_noise = 1.0 / noise_std
        self._rows: list[int] = np.argsort(order).tolist()  # of each patch in the skin's order
        sizes = [self.sizes[row] for row in self._rows]
        ends = np.cumsum(sizes).tolist()
        parts = [slice(end - size, end) for end, size in zip(ends, sizes, strict=True)]
        self._parts = {self.names[row]: part for row, part in zip(self._rows, parts, strict=True)}
        self._nothing = [np.zeros(size) for size in sizes]
        self.places = np.concatenate([np.r_[self._parts[name]] for name in self.names])
        self.noise_std[self.places] = noise_std
        self.deviation = self.noise_std.copy()
        self._new, self._stamps = np.ones(len(sizes), np.int64), np.zeros(len(sizes), np.int64)
        self.how = _linearised_how(quantity, self.given)

    def take(self, readings: Readings, valid: Mapping[str, ArrayLike] | None) -> None:
        """Take the readings of a cycle.

        Raises
        ------
        InputError
            For a name that no patch has, or another number of taxels.
        """
        for (name, part), row in zip(self._parts.items(), self._each(readings), strict=True):
            values, expected = as_floats(f"readings[{name!r}]", row), self.given[part].shape
            if values.shape != expected:
                raise InputError(
                    f"readings[{name!r}] has shape {values.shape}, expected {expected}: one per "
                    "taxel; an engine takes one reading of each patch in a cycle"
                )
            self.given[part] = values
        self.wanted[:] = True
        self.deviation[:] = self.noise_std
        if valid is not None:
            self._leave_out(valid)

    def take_flat(
        self, readings: Floats, valid: NDArray[np.bool_] | None, deviation: Floats | None = None
    ) -> None:
        """Take the readings (N,) of all taxels, patch by patch in the skin's order.

        Raises
        ------
        InputError
            For another number of taxels, or type.
        """
        _check_flat("readings", readings, self.given)
        self.given[:] = readings
        if valid is not None:
            _check_flat("valid", valid, self.wanted)
        if deviation is not None:
            _check_flat("deviation", deviation, self.deviation)
        self.wanted[:] = True if valid is None else valid
        self.deviation[:] = self.noise_std if deviation is None else deviation
        self.present[:] = True

    def undo_creep(self, creep: CreepCompensation, stamp_ns: int) -> None:
        """Free what was taken, in the skin's order, from what patches remember."""
        self._stamps[:], raw = stamp_ns, self.given
        good = (raw > self.quantity.lowest) & (raw < self.quantity.highest) & self.wanted
        for name, place in zip(self._parts, self._rows, strict=True):
            good[self._parts[name]] &= self.present[place]
        creep.take(raw, good, self._new, self._stamps)

    def linearise(self) -> None:
        """Take what was given into `linear` as the quantity says; 0 for what is not valid."""
        raw = self.given[self.places]
        lowest, highest = self.quantity.lowest, self.quantity.highest
        good = (raw > lowest) & (raw < highest) & self.wanted[self.places]
        self.valid[:] = good
        self.linear[:] = self.quantity.linearise(np.where(good, raw, 0.0), self.linear)

    def rows_of(self, place: int) -> slice:
        """Taxels of a patch."""
        return slice(self.starts[place], self.starts[place + 1])

    def raw_of(self, place: int) -> Floats:
        """What was handed in of a patch, (L,): a view."""
        given: Floats = self.given[self._parts[self.names[place]]]
        return given

    def _each(self, readings: Readings) -> list[Any]:
        """Readings of each patch in the skin's order; zeros where there are none."""
        if isinstance(readings, Mapping):
            rows = [readings.get(name) for name in self._parts]
        elif len(readings) == len(self.names):
            rows = list(readings)
        else:
            raise InputError(
                f"readings has {len(readings)} entries, expected one for each of the "
                f"{len(self.names)} patches in the skin's order, None where there is none; "
                "or a mapping from names"
            )
        missing = [place for place, row in enumerate(rows) if row is None]
        if isinstance(readings, Mapping) and len(rows) - len(missing) < len(readings):
            check_names("readings", readings, self.names)
        self.present[:] = True
        for place in missing:
            self.present[self._rows[place]] = False
            rows[place] = self._nothing[place]
        return rows

    def _leave_out(self, valid: Mapping[str, ArrayLike]) -> None:
        check_names("valid", valid, self.names)
        for name, given in valid.items():
            mask, part = np.asarray(given, dtype=np.bool_), self.wanted[self._parts[name]]
            if mask.shape != part.shape:
                raise InputError(
                    f"valid[{name!r}] has shape {mask.shape}, expected {part.shape}: one per taxel"
                )
            part[:] = mask

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
