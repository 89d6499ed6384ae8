"""Any other interface of python-can, message by message."""

from collections.abc import Sequence
from time import time_ns
from types import ModuleType
from typing import Any

import numpy as np

from skinfield.acquisition.can import ERROR, EXTENDED, REMOTE, CanMessages
from skinfield.errors import InputError
from skinfield.sources.buses.rows import check_rows, fill
from skinfield.sources.buses.settings import BusSettings

NEAR = 1_000_000_000  # ns: stamps further off are of a clock of the adapter's own


def python_can() -> ModuleType:
    """The package.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        import can
    except ImportError as error:
        raise InputError(
            "interface is one of python-can's, expected python-can to be installed: "
            "pip install skinfield[can]"
        ) from error
    return can


class PythonCanBus:
    """See `Bus` and `BusSettings`."""

    def __init__(self, settings: BusSettings) -> None:
        self._can = python_can()
        self.settings = settings
        self._check_interface()
        self._bus: Any = None
        self._one = CanMessages(1)
        self.up, self.fault = False, ""
        self.overflowed, self.malformed, self.errors, self.octets = 0, 0, 0, 0
        self._open()

    def _check_interface(self) -> None:
        known = sorted(self._can.VALID_INTERFACES)
        if self.settings.interface not in known:
            raise InputError(
                f"interface is {self.settings.interface!r}, expected udp_multicast, udp, socketcan "
                f"or one of python-can's: {', '.join(known)}"
            )

    def reopen(self) -> bool:
        """Open it anew."""
        try:
            return self._open()
        except InputError as error:
            self.fault = str(error)
            return False

    def _open(self) -> bool:
        self._release()
        name, given = self.settings.interface, dict(self.settings.options)
        if self.settings.channel:
            given["channel"] = self.settings.channel
        if self.settings.bitrate:
            given["bitrate"] = self.settings.bitrate
        try:
            self._bus = self._can.Bus(interface=name, ignore_config=True, **given)
        except self._can.CanInterfaceNotImplementedError as error:
            raise self._unusable(given, error) from error
        except (self._can.CanError, OSError) as error:
            self.fault = f"{self.settings.label}: {error}"
            return False
        except Exception as error:  # drivers raise whatever they do not catch
            raise self._unusable(given, error) from error
        self.up, self.fault = True, ""
        return True

    def _unusable(self, given: dict[str, Any], error: Exception) -> InputError:
        return InputError(
            f"{self.settings.label} cannot be opened with {given}, expected settings that "
            f"python-can understands, and the driver installed: {type(error).__name__}: {error}"
        )

    def receive(self, into: CanMessages, first: int = 0) -> int:
        """Take in what has arrived."""
        at = first
        while self._bus is not None and at < len(into):
            try:
                message = self._bus.recv(0)
            except Exception as error:  # drivers raise whatever they do not catch
                self._broke(error)
                break
            if message is None:
                break
            at += self._take(message, into, at)
        return at - first

    def _take(self, message: Any, into: CanMessages, row: int) -> int:
        """Note one message; 1 if it is of interest."""
        if message.is_error_frame:
            self.errors += 1
            return 0
        if message.is_fd or not 0 <= message.dlc <= 8:
            self.malformed += 1
            return 0
        now, stamp = time_ns(), int(message.timestamp * 1e9)
        data = np.frombuffer(bytes(message.data[:8]), np.uint8)
        into.ids[row] = message.arbitration_id | (
            (EXTENDED if message.is_extended_id else 0) | (REMOTE if message.is_remote_frame else 0)
        )
        into.lengths[row] = message.dlc
        into.data[row, : len(data)] = data
        into.data[row, len(data) :] = 0
        into.stamp_ns[row] = stamp if now - NEAR < stamp <= now else now
        self.octets += len(data)
        return 1

    def send(self, identifier: int, data: bytes) -> bool:
        """Send one message."""
        fill(self._one, identifier, data)
        return self.send_many(self._one, 1) == 1

    def send_many(self, messages: CanMessages, count: int, first: int = 0) -> int:
        """Send rows of `messages`."""
        check_rows(messages, first, count)
        for row in range(first, first + count):
            if self._bus is None:
                return row - first
            try:
                self._bus.send(self._message(messages, row), timeout=0)
            except self._can.CanTimeoutError:
                return row - first
            except Exception as error:
                self._broke(error)
                return row - first
        return count

    def _message(self, messages: CanMessages, row: int) -> Any:
        identifier, length = int(messages.ids[row]), int(messages.lengths[row])
        remote = bool(identifier & REMOTE)
        return self._can.Message(
            arbitration_id=identifier & 0x1FFFFFFF,
            is_extended_id=bool(identifier & EXTENDED),
            is_remote_frame=remote,
            is_error_frame=bool(identifier & ERROR),
            dlc=length,
            data=None if remote else messages.data[row, :length].tobytes(),
        )

    def _broke(self, error: Exception) -> None:
        self._release()
        self.fault = f"{self.settings.label}: {error}"

    def filenos(self) -> Sequence[int]:
        """Of the adapter, where it has one."""
        try:
            number = self._bus.fileno() if self._bus is not None else -1
        except Exception:  # not all have one
            number = -1
        return (number,) if number >= 0 else ()

    def _release(self) -> None:
        bus, self._bus, self.up = self._bus, None, False
        if bus is not None:
            try:
                bus.shutdown()
            except Exception as error:
                self.fault = f"{self.settings.label}: {error}"

    def close(self) -> None:
        """Let go of the adapter."""
        self._release()
        self.fault = "closed"
