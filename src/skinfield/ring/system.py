"""Futex and memory fences: what a ring needs of operating system and processor.

Order. A lock around a slot, without waiting, needs that others see stores in the order in which
they were made, and that loads are made in theirs. On x86-64 both hold for ordinary memory without
any instruction (total store order: Intel SDM volume 3, "Memory Ordering"; copies by string
instructions and by glibc's streaming stores, which end with a fence, are ordered against stores
around them), and Python calls are opaque to the compiler. Who writes slots with streaming stores of
their own must end with a fence; NumPy and OpenBLAS use none. Elsewhere a full fence is called: the
system call membarrier with GLOBAL_EXPEDITED, which is a full barrier for its caller (and interrupts
only processes that registered for it: none here). Values are stored by one aligned 64-bit move:
CPython writes the items of a memoryview so.

Waking. Linux: a futex that processes share, on the file's mapping; waiting works on a mapping that
may only be read. Elsewhere readers look every half millisecond.
"""

import ctypes
import errno
import platform
import sys
import time
from collections.abc import Callable

from skinfield.errors import InputError

FUTEX = {"x86_64": 202, "aarch64": 98, "riscv64": 98}  # numbers of system calls on Linux
MEMBARRIER = {"x86_64": 324, "aarch64": 283, "riscv64": 283}
POLL = 0.0005  # s, where there is no futex

_WAIT, _WAKE = 0, 1  # operations of the futex, without the flag that makes it private
_QUERY, _GLOBAL_EXPEDITED = 0, 1 << 1  # commands of membarrier
_ALL = 0x7FFFFFFF

Fence = Callable[[], object]


def machine() -> str:
    """The processor's name, or nothing where Linux' system calls are not there."""
    return platform.machine() if sys.platform == "linux" else ""


def needs_fence() -> bool:
    """Whether this processor may reorder stores among each other, or loads."""
    return platform.machine().lower() not in ("x86_64", "amd64")


def fence() -> Fence | None:
    """What to call where the order matters; None where the processor keeps it by itself.

    Raises
    ------
    InputError
        If this machine needs a fence and offers none.
    """
    if sys.byteorder != "little":
        raise InputError("this machine is big-endian, expected a little-endian one for a ring")
    if not needs_fence():
        return None
    made = fence_of_kernel()
    if made is None:
        raise InputError(
            f"this machine ({platform.machine()}) has no fence that can be called, expected "
            "a Linux kernel of 4.16 or later with membarrier"
        )
    return made


def fence_of_kernel() -> Fence | None:
    """Membarrier, or None where the kernel does not offer it."""
    number = MEMBARRIER.get(machine())
    if number is None:
        return None
    call = ctypes.PyDLL(None).syscall
    call.restype = ctypes.c_long
    known = call(ctypes.c_long(number), ctypes.c_long(_QUERY), ctypes.c_long(0))
    if known < 0 or not known & _GLOBAL_EXPEDITED:
        return None
    arguments = (ctypes.c_long(number), ctypes.c_long(_GLOBAL_EXPEDITED), ctypes.c_long(0))
    return lambda: call(*arguments)


class _Time(ctypes.Structure):
    _fields_ = (("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long))


class Futex:
    """A 32-bit word on which processes wait until another wakes them.

    Parameters
    ----------
    address : int
        In this process; of memory that is mapped from the same file in all of them.
    number : int
        Of the system call.
    """

    def __init__(self, address: int, number: int) -> None:
        self._wake = ctypes.PyDLL(None).syscall  # keeps the GIL: nothing here waits
        self._wake_arguments = tuple(map(ctypes.c_long, (number, address, _WAKE, _ALL)))
        self._wait = ctypes.CDLL(None, use_errno=True).syscall
        self._wait.restype = ctypes.c_long
        self._place = (ctypes.c_long(number), ctypes.c_long(address), ctypes.c_long(_WAIT))

    def wake(self) -> None:
        """Wake all who wait."""
        self._wake(*self._wake_arguments)

    def wait(self, value: int, seconds: float) -> None:
        """Wait until woken, at most so long; not at all if the word is no longer `value`.

        Raises
        ------
        InputError
            If the system refuses, which it has no reason to.
        """
        whole = int(seconds)
        limit = _Time(whole, int((seconds - whole) * 1e9))
        if self._wait(*self._place, ctypes.c_long(value), ctypes.byref(limit)) < 0:
            problem = ctypes.get_errno()
            if problem not in (errno.EAGAIN, errno.ETIMEDOUT, errno.EINTR):
                raise InputError(f"waiting for the ring failed with {errno.errorcode[problem]}")


class Polling:
    """In place of a futex where there is none: who waits looks again after `POLL`."""

    def wake(self) -> None:
        """Nothing: nobody waits in the kernel."""

    def wait(self, value: int, seconds: float) -> None:
        """Sleep a little."""
        time.sleep(min(seconds, POLL))


def signal(address: int) -> Futex | Polling:
    """What to wake and to wait with on this machine."""
    number = FUTEX.get(machine())
    return Polling() if number is None else Futex(address, number)
