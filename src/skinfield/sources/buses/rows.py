"""Rows of `CanMessages`, checked before compiled code writes or reads them."""

import numpy as np

from skinfield.acquisition.can import CanMessages
from skinfield.errors import InputError


def fill(messages: CanMessages, identifier: int, data: bytes, row: int = 0) -> None:
    """Write one message.

    Raises
    ------
    InputError
        If the data is longer than 8 octets.
    """
    if len(data) > 8:
        raise InputError(f"data has {len(data)} octets, expected up to 8: classic CAN")
    messages.ids[row], messages.lengths[row], messages.stamp_ns[row] = identifier, len(data), 0
    messages.data[row, : len(data)] = np.frombuffer(data, np.uint8)


def check_rows(messages: CanMessages, first: int, count: int) -> None:
    """Raise InputError unless rows `first` to `first + count` are there."""
    if first < 0 or count < 0 or first + count > len(messages):
        raise InputError(
            f"rows {first} to {first + count} are asked for, expected some of 0 to "
            f"{len(messages)}: the room of these messages"
        )
