"""Files of rings: where they lie, and who writes them.

A ring is a file ``skinfield.NAME`` in memory. Its writer holds a lock on it (flock) from before the
file has that name until it ends, whichever way it ends: so it is certain whether a ring has a
writer, and two can never write the same one. Locks are kept by the kernel; readers take none.
"""

import fcntl
import json
import mmap
import os
import re
import tempfile
import time
import weakref
from pathlib import Path
from typing import Self

from skinfield.errors import FileError, InputError

SHARED = Path("/dev/shm")
PREFIX = "skinfield."
_NEW = "skinfield-new."  # of files that are being made
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")
_PATIENCE = 0.5  # s, for those who only look whether there is a lock


def folder_of(folder: Path | None) -> Path:
    """Where rings lie: in memory where the system has a folder for that."""
    return folder or (SHARED if SHARED.is_dir() else Path(tempfile.gettempdir()))


def path_of(name: str, folder: Path | None) -> Path:
    """Path of a ring.

    Raises
    ------
    InputError
        If `name` cannot be part of a file's name.
    """
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise InputError(
            f"name of a ring is {name!r}, expected letters, digits, '_', '-' and '.', at most 64"
        )
    return folder_of(folder) / f"{PREFIX}{name}"


def sidecar(name: str, what: str) -> Path:
    """Path of a file beside the ring `name`, for `what`; its own name is none that a ring can have.

    Raises
    ------
    InputError
        If no ring can have that name.
    """
    path_of(name, None)
    return folder_of(None) / f"skinfield-{what}.{name}"


def write_sidecar(name: str, what: str, plain: object) -> None:
    """Write plain values as JSON into a sidecar, in one step; quietly not where it is full."""
    path = sidecar(name, what)
    new = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        new.write_text(json.dumps(plain))
        new.chmod(0o600)
        new.replace(path)
    except OSError:
        new.unlink(missing_ok=True)


def open_ring(path: Path, write: bool) -> int:
    """Descriptor of a ring's file.

    Raises
    ------
    FileError
        If there is none, or it may not be opened.
    """
    flags = (os.O_RDWR if write else os.O_RDONLY) | os.O_CLOEXEC | os.O_NOFOLLOW
    try:
        return os.open(path, flags)
    except FileNotFoundError:
        raise FileError(
            f"{path} is not there, expected a ring: is its engine running (skinfield status)?"
        ) from None
    except OSError as error:
        raise FileError(
            f"{path} cannot be opened: {error.strerror}, expected a ring of this user"
        ) from error


class Lock:
    """A writer's lock on a file; it ends with `close`, with this object, or with the process.

    Children that are made by fork have no part in it: it would outlast the writer with them. (The
    kernel keeps it as long as any copy of the descriptor is open: so the file is mapped through
    another one, and children close theirs.)
    """

    def __init__(self, descriptor: int) -> None:
        self.descriptor = descriptor
        self._closer = weakref.finalize(self, os.close, descriptor)
        _LOCKS.add(self)

    @classmethod
    def take(cls, descriptor: int) -> Self | None:
        """Lock an open file; None, and it is closed, if another process has the lock."""
        end = time.monotonic() + _PATIENCE
        while True:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:  # a writer, or somebody who looks for one this very moment
                if time.monotonic() >= end:
                    os.close(descriptor)
                    return None
                time.sleep(0.002)
            else:
                return cls(descriptor)

    @property
    def held(self) -> bool:
        """Whether it was not closed yet."""
        return self._closer.alive

    def close(self) -> None:
        """Close the file; nothing happens the second time."""
        self._closer()


_LOCKS: weakref.WeakSet[Lock] = weakref.WeakSet()  # of this process


def _let_go() -> None:
    for lock in list(_LOCKS):
        lock.close()


os.register_at_fork(after_in_child=_let_go)


def locked(descriptor: int) -> bool:
    """Whether a living process writes the file."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    fcntl.flock(descriptor, fcntl.LOCK_UN)
    return False


def same(descriptor: int, path: Path) -> bool:
    """Whether the file that is open still has that name."""
    ours = os.fstat(descriptor)
    try:
        found = path.stat(follow_symlinks=False)
    except FileNotFoundError:
        return False
    return (ours.st_dev, ours.st_ino) == (found.st_dev, found.st_ino)


def unfinished(path: Path) -> Path:
    """Name of a ring's file while it is made."""
    return path.with_name(path.name.replace(PREFIX, _NEW, 1))


def reserve(descriptor: int, size: int, path: Path) -> None:
    """Make the file empty and so large, with its memory taken: writing it cannot fail later.

    Raises
    ------
    FileError
        If there is not so much memory.
    """
    try:
        os.ftruncate(descriptor, 0)
        os.ftruncate(descriptor, size)
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(descriptor, 0, size)
    except OSError as error:
        raise FileError(
            f"{path} needs {size} bytes, and {path.parent} has no room: {error.strerror}; "
            "make the log or the slots smaller"
        ) from error


def mapped(descriptor: int, path: Path, write: bool) -> mmap.mmap:
    """Map the whole file; without `write` nothing in this process can change it.

    Raises
    ------
    FileError
        If it is empty or cannot be mapped.
    """
    flags = mmap.MAP_SHARED | (getattr(mmap, "MAP_POPULATE", 0) if write else 0)
    protection = mmap.PROT_READ | (mmap.PROT_WRITE if write else 0)
    try:
        return mmap.mmap(descriptor, 0, flags, protection)
    except (OSError, ValueError) as error:
        raise FileError(f"{path} cannot be mapped into memory: {error}") from error


def mapped_apart(path: Path) -> mmap.mmap:
    """Map a whole file for writing, through a descriptor that is gone again."""
    descriptor = open_ring(path, write=True)
    try:
        return mapped(descriptor, path, write=True)
    finally:
        os.close(descriptor)
