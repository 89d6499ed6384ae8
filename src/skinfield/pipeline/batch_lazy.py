"""Arrays that are computed chunk by chunk when they are indexed."""

import math
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from operator import index as whole
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.pipeline.batch_index import Wanted, wanted

Load = Callable[[int, int], NDArray[Any]]


class ChunkCache:
    """Chunks that were computed last, up to so many bytes; threads wait for each other.

    Parameters
    ----------
    most_bytes : int
        The newest chunk is kept even if it alone is larger.
    """

    def __init__(self, most_bytes: int = 256 << 20) -> None:
        self.most_bytes = most_bytes
        self.nbytes = 0
        self._chunks: OrderedDict[tuple[Any, int], tuple[Any, int]] = OrderedDict()
        self._lock = threading.RLock()

    def get(
        self, key: tuple[Any, int], make: Callable[[], Any], nbytes: Callable[[Any], int]
    ) -> Any:
        """What stands under a key, made if it does not."""
        with self._lock:  # what makes chunks has buffers of its own: one at a time
            if key not in self._chunks:
                made = make()
                size = nbytes(made)
                self._chunks[key] = (made, size)
                self.nbytes += size
                while self.nbytes > self.most_bytes and len(self._chunks) > 1:
                    self.nbytes -= self._chunks.popitem(last=False)[1][1]
            self._chunks.move_to_end(key)
            return self._chunks[key][0]

    def has(self, key: tuple[Any, int]) -> bool:
        """Whether something stands under a key."""
        with self._lock:
            return key in self._chunks

    def alone(self) -> threading.RLock:
        """What threads wait for, to be held while something is made that is not kept."""
        return self._lock

    def clear(self) -> None:
        """Forget all chunks."""
        with self._lock:
            self._chunks.clear()
            self.nbytes = 0


class LazyArray:
    """A NumPy array as far as indexing goes; its first axis is computed in chunks.

    What an index gives is a NumPy array of its own, or a number. Basic indices of the later axes
    are applied chunk by chunk, so that ``array[:, 3]`` never holds more than a chunk and its
    answer. ``numpy.asarray(array)`` computes all of it.

    Parameters
    ----------
    shape : tuple of int
    dtype : dtype
    chunk : int
        Rows that are computed together, always at the same places: what a row holds does not
        depend on how it was asked for.
    load : callable
        Rows first to last, (last - first, ...), of one chunk.
    cache : ChunkCache
    into : callable, optional
        Writes rows first to last of one chunk into an array (last - first, ...): for chunks that
        are wanted as a whole, which are then not kept.
    """

    def __init__(
        self,
        shape: tuple[int, ...],
        dtype: Any,
        chunk: int,
        load: Load,
        cache: ChunkCache,
        into: Callable[[int, int, NDArray[Any]], None] | None = None,
    ) -> None:
        self.shape = shape
        self.dtype = np.dtype(dtype)
        self.chunk = chunk
        self._load = load
        self._cache = cache
        self._into = into
        self.origin: tuple[Any, str] | None = None  # an object and what it calls this array

    def __reduce__(self) -> tuple[Any, tuple[Any, str]]:
        """For pickles: the other process asks what it came from for it."""
        if self.origin is None:
            raise TypeError("this lazy array cannot be pickled: nothing says what it came from")
        return getattr, self.origin

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """Number of elements."""
        return math.prod(self.shape)

    @property
    def nbytes(self) -> int:
        """Bytes it would take in memory."""
        return self.size * int(self.dtype.itemsize)

    @property
    def chunks(self) -> tuple[tuple[int, ...], ...]:
        """Sizes of the chunks along each axis, as Dask and Zarr's users write them."""
        rows = range(0, len(self), self.chunk)
        first = tuple(min(self.chunk, len(self) - row) for row in rows)
        return (first, *((n,) for n in self.shape[1:]))

    def __len__(self) -> int:
        return self.shape[0]

    def __repr__(self) -> str:
        return (
            f"LazyArray(shape={self.shape}, dtype={self.dtype}, chunks of {self.chunk}, "
            f"{self.nbytes / 1e6:.3g} MB if computed)"
        )

    def __getitem__(self, key: Any) -> Any:
        """As NumPy indexes: whole numbers, slices, lists, masks, `...` and `None`."""
        return self._taken(wanted(key, self.shape))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        if copy is False:
            raise ValueError("a lazy array has no memory to share: take copy=None")
        return np.asarray(self[:], dtype=dtype)

    def __iter__(self) -> Iterator[NDArray[Any]]:
        """Row by row."""
        return (row for _, block in self.blocks() for row in block)

    def blocks(self) -> Iterator[tuple[slice, NDArray[Any]]]:
        """All rows, chunk by chunk, each with where it stands."""
        for first in range(0, len(self), self.chunk):
            part = slice(first, min(first + self.chunk, len(self)))
            yield part, self[part]

    def _taken(self, want: Wanted) -> Any:
        rows, trim = want.rows, want.trim
        out = np.empty((len(rows), *want.trimmed), self.dtype)
        done = 0
        while done < len(rows):
            number = rows[done] // self.chunk
            stop = (number + 1) * self.chunk
            ends = done + int(np.searchsorted(rows[done:], stop))
            local = np.asarray(rows[done:ends]) - number * self.chunk
            untrimmed = len(local) > 1 and all(item == slice(None) for item in trim)
            if not (untrimmed and self._written(int(number), local, out[done:ends])):
                block = self._chunk(int(number))
                even = local[-1] - local[0] == len(local) - 1
                part = block[local[0] : local[-1] + 1] if even else block[local]
                out[done:ends] = part[(slice(None), *trim)]
            done = ends
        return out[want.rest]

    def _written(self, number: int, local: NDArray[Any], out: NDArray[Any]) -> bool:
        """Whether a chunk was computed where it is wanted, as nothing of it is known or left."""
        first = number * self.chunk
        last = min(first + self.chunk, len(self))
        if self._into is None or len(local) < last - first or self._cache.has((self, number)):
            return False
        with self._cache.alone():
            self._into(first, last, out)
        return True

    def _chunk(self, number: int) -> NDArray[Any]:
        first = number * self.chunk
        last = min(first + self.chunk, len(self))
        return np.asarray(
            self._cache.get((self, number), lambda: self._load(first, last), lambda a: a.nbytes)
        )


class LazyList:
    """A sequence whose items are computed in chunks when they are asked for.

    Parameters
    ----------
    count : int
    chunk : int
        Items that are computed together.
    load : callable
        Items first to last, as a tuple.
    cache : ChunkCache
    item_bytes : int
        By which an item is counted in the cache.
    """

    def __init__(
        self,
        count: int,
        chunk: int,
        load: Callable[[int, int], tuple[Any, ...]],
        cache: ChunkCache,
        item_bytes: int = 4096,
    ) -> None:
        self.count, self.chunk = count, chunk
        self._load, self._cache, self._item_bytes = load, cache, item_bytes

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[Any]:
        return (self[item] for item in range(self.count))

    def __getitem__(self, key: Any) -> Any:
        """An item for a whole number; a tuple of items for a slice, a list or a mask."""
        try:
            number = whole(key)
        except TypeError:
            places = np.arange(self.count)[key]
            if places.ndim != 1:
                raise IndexError(f"index {key!r} has more than one axis, expected one") from None
            return tuple(self._item(int(place)) for place in places)
        if not -self.count <= number < self.count:
            raise IndexError(f"index {number} is out of range for {self.count} items")
        return self._item(number % self.count)

    def __repr__(self) -> str:
        return f"LazyList({self.count} items, {self.chunk} at a time)"

    def _item(self, number: int) -> Any:
        first = number - number % self.chunk
        last = min(first + self.chunk, self.count)
        made = self._cache.get(
            (self, first), lambda: self._load(first, last), lambda a: len(a) * self._item_bytes
        )
        return made[number - first]
