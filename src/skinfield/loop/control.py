"""Orders to a running engine: small JSON messages to a socket that only its user can reach."""

import contextlib
import json
import os
import socket
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skinfield.errors import InputError
from skinfield.ring.files import sidecar

LONGEST = 4096  # bytes of an order
ORDERS = ("tare", "set", "hand over", "stop")


def address_of(name: str) -> Path:
    """Socket of the engine that serves this ring."""
    return sidecar(name, "control")


class EngineControl:
    """The engine's end; asked in every cycle, never waits.

    Parameters
    ----------
    name : str
        Of the ring.

    Attributes
    ----------
    values : dict
        That came with the last order.
    """

    def __init__(self, name: str) -> None:
        self.address = address_of(name)
        with contextlib.suppress(FileNotFoundError):
            self.address.unlink()
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        before = os.umask(0o177)  # for this user alone, from the first moment on
        try:
            self._socket.bind(str(self.address))
        finally:
            os.umask(before)
        self.values: dict[str, Any] = {}

    def poll(self) -> str:
        """The next order, or nothing."""
        try:
            data = self._socket.recv(LONGEST)
        except OSError:
            return ""
        order, self.values = order_of(data)
        return order

    def close(self) -> None:
        """Give the socket back."""
        self._socket.close()
        with contextlib.suppress(OSError):
            self.address.unlink()


def order_of(data: bytes) -> tuple[str, dict[str, Any]]:
    """An order and the values that came with it; nothing of bytes that are no order."""
    try:
        values = json.loads(data)
        order = values.pop("do")
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return "", {}
    return (order, values) if isinstance(order, str) and order in ORDERS else ("", {})


def order(name: str, what: str, more: Mapping[str, Any] | None = None) -> None:
    """Send an order to the engine of a ring.

    Raises
    ------
    InputError
        If there is no such order, or no engine that listens.
    """
    if what not in ORDERS:
        raise InputError(f"order is {what!r}, expected one of {', '.join(ORDERS)}")
    address = address_of(name)
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
            sender.sendto(json.dumps({**(more or {}), "do": what}).encode(), str(address))
    except OSError as error:
        raise InputError(
            f"the engine of {name!r} does not listen: {error.strerror}; is `skinfield run` on?"
        ) from error
