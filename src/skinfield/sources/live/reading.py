"""Readings of a stream for scripts, outside the engine."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from select import select
from time import monotonic, time_ns

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition import Blocks, Channels, Stream
from skinfield.acquisition.block import UNUSABLE
from skinfield.errors import SkinfieldError, check_range
from skinfield.reading import Reading

STEP = 1e-3  # s between two polls of a stream that cannot be waited for


class NoReadingError(SkinfieldError, TimeoutError):
    """Nothing that is new enough has come."""


@dataclass(eq=False)
class StreamReader:
    """Whole readings of a stream.

    Parameters
    ----------
    stream : Stream
        It is polled here only.

    Attributes
    ----------
    channels : Channels
        The newest counts of all.
    """

    stream: Stream
    channels: Channels = field(init=False)
    _blocks: Blocks = field(init=False)
    _new: NDArray[np.bool_] = field(init=False)  # channels of the reading that is under way

    def __post_init__(self) -> None:
        self._blocks = Blocks()
        self.channels = Channels(sum(port.channels for port in self.stream.ports))
        self._new = np.zeros(len(self.channels), bool)

    def take(self) -> int:
        """Take in what has arrived; how many messages. Never waits."""
        self._blocks.clear()
        messages = self.stream.poll(self._blocks, 0, time_ns())
        if len(self._blocks.data):
            self.channels.apply(self._blocks)
        return messages

    def read(self, timeout: float = 1.0) -> Reading:
        """Wait for the next reading of all channels that answer.

        It is complete when all channels that ever brought something have brought something new, or
        one brings something for the second time.

        Parameters
        ----------
        timeout : float, s

        Raises
        ------
        NoReadingError
            If it is not complete in time.
        """
        check_range("timeout", timeout, 0.0, 1e9, "seconds to wait at most")
        end = monotonic() + timeout
        stamps, new = self.channels.stamp_ns, self._new
        known = stamps > 0
        while True:
            before = stamps.copy()
            self.take()
            came = stamps != before
            if (came & new).any():
                new[:] = came
                return self._reading()
            new |= came
            if known.any() and new[known].all():
                new[:] = False
                return self._reading()
            left = end - monotonic()
            if left <= 0:
                raise NoReadingError(
                    f"{np.count_nonzero(new)} of {len(new)} channels brought something new within "
                    f"{timeout:g} s, expected all that answer: {self._state()}"
                )
            self._wait(left)

    def read_latest(self, max_age: float = 0.1) -> Reading:
        """The newest counts, without waiting.

        Parameters
        ----------
        max_age : float, s
            Of the newest; taxels that are older than that beside newer ones are not `valid`.

        Raises
        ------
        NoReadingError
            If all are older.
        """
        check_range("max_age", max_age, 0.0, 1e9, "seconds since the newest reading, at most")
        self.take()
        newest = int(self.channels.stamp_ns.max())
        age = (time_ns() - newest) * 1e-9
        if not newest or age > max_age:
            what = f"{age:.3g} s old" if newest else "none"
            raise NoReadingError(
                f"the newest reading is {what}, expected at most {max_age:g} s: {self._state()}"
            )
        return self._reading(newest - round(max_age * 1e9))

    def _reading(self, oldest_ns: int = 1) -> Reading:
        channels = self.channels
        good = (channels.stamp_ns >= max(oldest_ns, 1)) & np.isfinite(channels.counts)
        good &= (channels.status & UNUSABLE) == 0
        return Reading(int(channels.stamp_ns.max()), channels.counts.copy(), good)

    def _state(self) -> str:
        return "the source is up" if self.stream.up else f"the source is down{_why(self.stream)}"

    def _wait(self, seconds: float) -> None:
        numbers: Sequence[int] = self.stream.filenos()
        # never for long: a connection that broke is noticed by polling alone
        if numbers:
            select(numbers, [], [], min(seconds, 20 * STEP))
        else:
            select([], [], [], min(seconds, STEP))


def _why(stream: Stream) -> str:
    fault = getattr(stream, "fault", "")
    return f" ({fault})" if fault else ""


def read(stream: Stream, timeout: float = 1.0) -> Reading:
    """Next reading of all channels; see `StreamReader.read`, which is for more than one."""
    return StreamReader(stream).read(timeout)


def read_latest(stream: Stream, max_age: float = 0.1) -> Reading:
    """Newest reading that has arrived; see `StreamReader.read_latest`, for more than one."""
    return StreamReader(stream).read_latest(max_age)
