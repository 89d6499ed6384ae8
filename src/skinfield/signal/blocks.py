"""Buffer that sources append blocks to, and the channels' newest counts."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, Ints, check_count
from skinfield.signal.block import DTYPES, HEADER, LONGEST, WORD, Kind, Octets, Status, Words


class Full(InputError):
    """A block that does not fit into the rest of a buffer."""


class Blocks:
    """Blocks of one poll of the sources, one after the other in one memory.

    Compiled decoders write through `words`, `octets` and `end` by the functions of
    `blocks_kernel`; others by `put`. Nothing is allocated after the beginning.

    Parameters
    ----------
    size : int, bytes
        Rounded up to whole words.

    Attributes
    ----------
    words, octets, shorts, singles : arrays
        The same memory as int64, uint8, uint16 and float32.
    end : (1,) int64 array
        Words used.
    """

    def __init__(self, size: int = 1 << 22) -> None:
        check_count("size", size, HEADER + WORD, 1 << 34, "bytes for the blocks of one poll")
        self.words: Words = np.zeros(-(-size // WORD), np.int64)
        self.octets: Octets = self.words.view(np.uint8)
        self.shorts: NDArray[np.uint16] = self.words.view(np.uint16)
        self.singles: NDArray[np.float32] = self.words.view(np.float32)
        self.end: Words = np.zeros(1, np.int64)

    def clear(self) -> None:
        """Forget what was there."""
        self.end[0] = 0

    @property
    def data(self) -> Octets:
        """Bytes of the blocks, without copying."""
        return self.octets[: int(self.end[0]) * WORD]

    def put(
        self, stamp_ns: int, channel: int, values: ArrayLike, kind: Kind, status: Status = Status.OK
    ) -> None:
        """Append a block of counts.

        Parameters
        ----------
        stamp_ns : int, ns
        channel : int
            First of the values' channels.
        values : (n,) array
            As the kind's type can hold them: they are cast.
        kind : Kind
            BYTES, SHORTS or FLOATS.

        Raises
        ------
        Full
            If it does not fit; nothing changed then.
        """
        values, view = np.asarray(values), self.words.view(DTYPES[kind])
        check_count("values", len(values), 0, LONGEST, "channels in one block")
        start = self._begin(stamp_ns, channel, len(values), kind, status) // view.itemsize
        view[start : start + len(values)] = values

    def put_number(self, stamp_ns: int, source: int, kind: Kind, number: int) -> None:
        """Append a block of SOURCE or LOST.

        Raises
        ------
        Full
            If it does not fit.
        """
        self.words[self._begin(stamp_ns, source, 0, kind, Status.OK) // WORD] = number

    def _begin(self, stamp_ns: int, channel: int, count: int, kind: Kind, status: Status) -> int:
        """First octet of the payload of a new block."""
        from skinfield.signal.blocks_kernel import begin_block

        at = begin_block(self.words, self.end, stamp_ns, channel, count, int(kind), int(status))
        if at < 0:
            raise Full(
                f"blocks hold {int(self.end[0]) * WORD} of {self.octets.size} bytes and a block of "
                f"{count} channels does not fit, expected room: poll more often, or make the "
                "buffer larger"
            )
        return int(at)


class Channels:
    """Newest counts of all channels, as the blocks so far left them.

    Parameters
    ----------
    count : int
        Of channels, over all ports.

    Attributes
    ----------
    counts : (C,) float64 array
        NaN where nothing came yet, or a taxel did not answer.
    stamp_ns : (C,) int64 array, ns
        0 where nothing came yet.
    status : (C,) uint8 array
        Bits of `Status`.
    fresh : (C,) uint8 array
        1 where counts came; whoever uses them sets it back to 0.
    """

    def __init__(self, count: int) -> None:
        check_count("count", count, 1, 1 << 31, "channels of all ports together")
        self.counts: Floats = np.full(count, np.nan)
        self.stamp_ns: Ints = np.zeros(count, np.int64)
        self.status: Octets = np.zeros(count, np.uint8)
        self.fresh: Octets = np.zeros(count, np.uint8)

    def __len__(self) -> int:
        return len(self.counts)

    def apply(self, blocks: Blocks, start: int = 0) -> int:
        """Take in the blocks from word `start` on; how many.

        Raises
        ------
        InputError
            At the first that is no block, or has channels beyond the last; those before it are in.
        """
        applied = self._applied(blocks, start)
        if applied < 0:
            raise InputError(
                f"byte {(-applied - 1) * WORD} of {len(blocks.data)} begins no block for "
                f"{len(self)} channels: the data is damaged, or of another skin"
            )
        return applied

    def apply_good(self, blocks: Blocks) -> int:
        """Take in the blocks up to the first that is none; drop it and the rest.

        For the loop, where a faulty driver must not end the cycle.

        Returns
        -------
        int
            Words that were dropped.
        """
        applied = self._applied(blocks, 0)
        if applied >= 0:
            return 0
        dropped = int(blocks.end[0]) - (-applied - 1)
        blocks.end[0] = -applied - 1
        return dropped

    def _applied(self, blocks: Blocks, start: int) -> int:
        from skinfield.signal.blocks_kernel import apply_blocks

        applied = apply_blocks(
            blocks.words,
            blocks.octets,
            blocks.shorts,
            blocks.singles,
            start,
            blocks.end[0],
            self.counts,
            self.stamp_ns,
            self.status,
            self.fresh,
        )
        return int(applied)
