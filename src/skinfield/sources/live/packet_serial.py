"""Packets of microcontrollers over a serial line, which may be unplugged and plugged in again."""

import fcntl
import os
import struct
import termios
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from types import ModuleType
from typing import Any

from skinfield.acquisition.block import Octets
from skinfield.errors import InputError, check_count, check_type
from skinfield.protocols.packet import PacketDevice
from skinfield.sources.live.packet_bytes import ByteStream
from skinfield.sources.live.packet_stream import checked_devices

LOOK = 0.25  # s between two looks at whether the device's node is still there


@dataclass(frozen=True)
class PacketSerial:
    """Devices at a serial line.

    Parameters
    ----------
    devices : sequence of PacketDevice, or int
        A number: one device, of number 1, with so many channels.
    path : str
        Of the device's node. One below /dev/serial/by-id stays the same when it is plugged in
        again, however many others there are.
    baud : int, bit/s
        Boards with USB of their own ignore it.
    names : sequence of str
        Of the devices' ports; default "skin", or "device<number>" of several.
    unit : str
        Of the numbers, one of `skinfield.reading.UNITS`.
    command : bool
        Whether devices are told to start and to stop.
    """

    devices: Sequence[PacketDevice] | int
    path: str = "/dev/ttyACM0"
    baud: int = 921600
    names: Sequence[str] = ()
    unit: str = "count"
    command: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "devices", checked_devices(self.devices))
        object.__setattr__(self, "names", tuple(self.names))
        check_type("path", self.path, str, "of the device's node, as /dev/ttyACM0")
        check_count("baud", self.baud, 50, 20_000_000, "bit/s of the line")

    def open(self) -> ByteStream:
        """Open the line; a device that is not plugged in now is waited for.

        Raises
        ------
        InputError
            If pyserial is not installed, or the line cannot be set up so.
        """
        link = SerialLink(self.path, self.baud)
        try:
            return ByteStream(
                checked_devices(self.devices), self.names, self.unit, link, self.command
            )
        except BaseException:
            link.close()
            raise


def pyserial() -> ModuleType:
    """The package.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        import serial
    except ImportError as error:
        raise InputError(
            "a serial line is asked for, expected pyserial to be installed: "
            "pip install skinfield[serial]"
        ) from error
    module: ModuleType = serial
    return module


class SerialLink:
    """A serial line; pyserial sets it up, reading is the system's own call."""

    def __init__(self, path: str, baud: int) -> None:
        self._serial = pyserial()
        self._path, self._baud = path, baud
        self._port: Any = None
        self._number = -1
        self._node = (0, 0)
        self._look = 0.0
        self._waiting = bytearray(4)
        self.up, self.fault = False, ""
        self._open()

    def reopen(self) -> bool:
        """Open it anew, if its node is there."""
        try:
            return self._open()
        except InputError as error:
            self.fault = str(error)
            return False

    def _open(self) -> bool:
        self.close()
        try:
            node = Path(self._path).stat()
            self._port = self._serial.Serial(
                self._path, self._baud, timeout=0, write_timeout=0, exclusive=True
            )
            self._port.reset_input_buffer()
        except ValueError as error:
            raise InputError(
                f"line {self._path} at {self._baud} bit/s: {error}, expected a rate that it has"
            ) from error
        except OSError as error:  # SerialException is one
            return self._broke(error) == 1
        self._node = node.st_dev, node.st_ino
        self._number = self._port.fileno()
        self.up, self.fault, self._look = True, "", monotonic() + LOOK
        return True

    def receive(self, into: Octets) -> int:
        """Write what has arrived."""
        if not self.up:
            return 0
        try:
            # a line that was unplugged reads as empty for ever, but refuses this question
            fcntl.ioctl(self._number, termios.FIONREAD, self._waiting)
            if struct.unpack("=i", self._waiting)[0] > 0:
                return os.readv(self._number, [into.data])
            if monotonic() > self._look:
                self._check_node()
        except (BlockingIOError, InterruptedError):
            return 0
        except (OSError, ValueError) as error:
            return self._broke(error)
        return 0

    def _check_node(self) -> None:
        """Raise OSError if the node is gone, or another one."""
        self._look = monotonic() + LOOK
        node = Path(self._path).stat()
        if (node.st_dev, node.st_ino) != self._node:
            raise OSError(f"{self._path} is another device now")

    def send(self, data: bytes) -> None:
        """Send a few bytes."""
        if self.up:
            try:
                os.write(self._number, data)
            except (BlockingIOError, InterruptedError):
                return
            except OSError as error:
                self._broke(error)

    def _broke(self, error: Exception) -> int:
        self.close()
        self.fault = f"{self._path}: {getattr(error, 'strerror', None) or error}"
        return 0

    def filenos(self) -> Sequence[int]:
        """Of the line."""
        return (self._number,) if self.up else ()

    def close(self) -> None:
        """Let go of the line."""
        port, self._port, self.up, self._number = self._port, None, False, -1
        if port is not None:
            with suppress(OSError, termios.error):
                port.close()
