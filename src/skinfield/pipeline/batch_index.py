"""What an index of NumPy's kind wants of an array whose rows are computed."""

from dataclasses import dataclass
from operator import index as whole
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Wanted:
    """An index, taken apart.

    Attributes
    ----------
    rows : (N,) int array
        Of the first axis, rising, each once.
    trim : tuple
        Basic indices of the later axes, to be applied to every row.
    trimmed : tuple of int
        What a row's shape is then.
    rest : tuple
        Index that makes the answer of the trimmed rows.
    """

    rows: NDArray[np.int64]
    trim: tuple[Any, ...]
    trimmed: tuple[int, ...]
    rest: tuple[Any, ...]


def wanted(key: Any, shape: tuple[int, ...]) -> Wanted:
    """Take an index of an array of some shape apart.

    Raises
    ------
    IndexError
        As NumPy does: out of range, too many, or no index at all.
    """
    keys = key if isinstance(key, tuple) else (key,)
    items = _without_masks(_filled(keys, len(shape)), shape)
    end = (Ellipsis,) if any(item is Ellipsis for item in keys) else ()  # then no bare number
    at = next(place for place, item in enumerate(items) if item is not None)
    rows, first = _rows(items[at], shape[0])
    later = tuple(items[at + 1 :])
    if at == 0 and all(isinstance(item, int | slice) for item in later):
        trimmed = np.broadcast_to(np.int8(0), shape[1:])[later].shape
        return Wanted(rows, later, trimmed, (first, *end))
    return Wanted(rows, (), shape[1:], (*items[:at], first, *later, *end))


def _filled(keys: tuple[Any, ...], axes: int) -> list[Any]:
    """Items for all axes, where those that an ellipsis or nothing stands for are whole."""
    items = [_plain(item) for item in keys]
    gaps = [place for place, item in enumerate(items) if item is Ellipsis]
    if len(gaps) > 1:
        raise IndexError("an index can only have a single ellipsis ('...')")
    used = sum(_axes(item) for item in items)
    if used > axes:
        raise IndexError(f"too many indices: the array has {axes} axes, but {used} are indexed")
    at = gaps[0] if gaps else len(items)
    return [*items[:at], *[slice(None)] * (axes - used), *items[at + len(gaps) :]]


def _axes(item: Any) -> int:
    """How many axes an item speaks of."""
    if item is None or item is Ellipsis:
        return 0
    return item.ndim if isinstance(item, np.ndarray) and item.dtype == np.bool_ else 1


def _plain(item: Any) -> Any:
    """An item as a whole number, a slice, an array of whole numbers or truths, None, Ellipsis."""
    if item is None or item is Ellipsis or isinstance(item, slice):
        return item
    if isinstance(item, bool | np.bool_):
        raise IndexError("a single truth value is no index of a lazy array: give one for each row")
    try:
        return whole(item)
    except TypeError:
        array = np.asarray(item)
    if not array.size and not isinstance(item, np.ndarray):
        array = array.astype(np.intp)
    if array.dtype.kind not in "iub" or not array.ndim:
        raise IndexError(
            "only integers, slices (`:`), ellipsis (`...`), None and integer or boolean arrays "
            f"are valid indices, got {item!r}"
        )
    return array


def _without_masks(items: list[Any], shape: tuple[int, ...]) -> list[Any]:
    """Masks as the places where they hold, one array for each of their axes."""
    plain: list[Any] = []
    axis = 0
    for item in items:
        if isinstance(item, np.ndarray) and item.dtype == np.bool_:
            if item.shape != shape[axis : axis + item.ndim]:
                raise IndexError(
                    f"boolean index of shape {item.shape} did not match the axes "
                    f"{shape[axis : axis + item.ndim]} from {axis} on"
                )
            plain += item.nonzero()
        else:
            plain.append(item)
        axis += _axes(item)
    return plain


def _rows(item: Any, count: int) -> tuple[NDArray[np.int64], Any]:
    """Rows that an item of the first axis needs, and its index among them."""
    if isinstance(item, int):
        if not -count <= item < count:
            raise IndexError(f"index {item} is out of bounds for axis 0 with size {count}")
        return np.array([item % count]), 0
    if isinstance(item, slice):
        places = range(count)[item]
        back = places.step < 0
        places = places[::-1] if back else places
        return np.array(places, np.int64), slice(None, None, -1 if back else 1)
    outside = (item < -count) | (item >= count)
    if outside.any():
        raise IndexError(f"index {item[outside][0]} is out of bounds for axis 0 with size {count}")
    rows, inverse = np.unique(item % max(count, 1), return_inverse=True)
    return rows.astype(np.int64), inverse.reshape(item.shape)
