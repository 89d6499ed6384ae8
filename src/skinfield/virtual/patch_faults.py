"""Faults of hardware that has a device of its own for each patch."""

from typing import Generic, Protocol, TypeVar

import numpy as np

from skinfield.layout import Patch
from skinfield.virtual.faults import numbers_of


class PatchDevice(Protocol):
    """What reads one patch.

    Attributes
    ----------
    patch : Patch
    quiet : bool
        While it is away.
    unplugged : set of int
        Modules of the patch that are not connected.
    """

    patch: Patch
    quiet: bool
    unplugged: set[int]


Each = TypeVar("Each", bound=PatchDevice)


class PatchFaults(Generic[Each]):
    """Unplugs modules, has devices boot again, and takes the bus off: see `Hardware`.

    Parameters
    ----------
    word : str
        What a device is called.
    devices : list
        One for each patch; may be filled later.

    Attributes
    ----------
    off : bool
        Whether the bus is.
    reboots : int
    """

    def __init__(self, word: str, devices: list[Each]) -> None:
        self._word, self.devices = word, devices
        self.off, self.reboots = False, 0

    def _went(self, device: Each) -> None:
        """Forget what a device forgets that loses its power."""
        raise NotImplementedError

    def _booted(self, device: Each) -> None:
        """Begin anew."""

    def _reschedule(self, now_ns: int) -> None:
        """Take over who sends now."""
        raise NotImplementedError

    def check(self, kind: str, what: str) -> None:
        """See `Hardware`."""
        if kind == "unplug":
            self._modules(what)
        elif kind == "bus-off":
            numbers_of(what, 1, "bus")
        else:
            self._named(what)

    def begin(self, kind: str, what: str, now_ns: int) -> None:
        """See `Hardware`."""
        self.check(kind, what)
        if kind == "unplug":
            for device, module in self._modules(what):
                device.unplugged.add(module)
        elif kind == "bus-off":
            self.off = True
        else:
            for device in self._named(what):
                device.quiet = True
                self._went(device)
                self.reboots += 1
            self._reschedule(now_ns)

    def end(self, kind: str, what: str, now_ns: int, warmth: float) -> None:
        """See `Hardware`."""
        if kind == "unplug":
            for device, module in self._modules(what):
                device.unplugged.discard(module)
        elif kind == "bus-off":
            self.off = False
        else:
            for device in self._named(what):
                device.quiet = False
                self._booted(device)
            self._reschedule(now_ns)

    def _named(self, what: str) -> list[Each]:
        return [self.devices[n] for n in numbers_of(what, len(self.devices), self._word)]

    def _modules(self, what: str) -> list[tuple[Each, int]]:
        """Modules of device 0, as ``"3"``, or of the named one, as ``"1.3"``."""
        first, dot, second = what.partition(".")
        found = []
        for device in self._named(first) if dot else self.devices[:1]:
            modules = np.unique(device.patch.module).tolist()
            for place in numbers_of(second if dot else first, len(modules), "module"):
                found.append((device, int(modules[place])))
        return found
