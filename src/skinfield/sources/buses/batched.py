"""What all buses have in common that take in and send messages in batches."""

import os

import numpy as np

from skinfield.acquisition.can import CanMessages
from skinfield.errors import Ints
from skinfield.sources.buses.datagrams import Datagrams
from skinfield.sources.buses.rows import fill
from skinfield.sources.buses.settings import BusSettings
from skinfield.sources.buses.system import buffer_note


class BatchedBus:
    """See `Bus`.

    Parameters
    ----------
    settings : BusSettings
    taken, sent : Datagrams
        Room for a batch of either direction.

    Attributes
    ----------
    buffer_bytes : int
        Of the receive buffer, as the system granted it.
    """

    def __init__(self, settings: BusSettings, taken: Datagrams, sent: Datagrams) -> None:
        self.settings = settings
        self._in, self._out = taken, sent
        self._counts: Ints = np.zeros(2, np.int64)
        self._one = CanMessages(1)
        self.up, self.fault, self.octets, self.buffer_bytes = False, "", 0, 0

    @property
    def overflowed(self) -> int:
        """Messages that the system dropped for want of room."""
        return self._in.dropped

    @property
    def malformed(self) -> int:
        """What came and was no message of classic CAN."""
        return int(self._counts[0])

    @property
    def errors(self) -> int:
        """Messages by which the bus reports an error."""
        return int(self._counts[1])

    @property
    def note(self) -> str:
        """What should be known of it, in words."""
        return buffer_note(self.settings.label, self.buffer_bytes)

    def send(self, identifier: int, data: bytes) -> bool:
        """Send one message."""
        fill(self._one, identifier, data)
        return self.send_many(self._one, 1) == 1

    def send_many(self, messages: CanMessages, count: int, first: int = 0) -> int:
        """Send rows of `messages`."""
        raise NotImplementedError

    def close(self) -> None:
        """Let go of what is open."""
        self._release()
        self.fault = "closed"

    def _broke(self, code: int) -> None:
        self._release()
        self.fault = f"{self.settings.label}: {os.strerror(code)}"

    def _release(self) -> None:
        raise NotImplementedError
