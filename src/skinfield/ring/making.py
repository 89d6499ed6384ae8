"""Making a ring's file, and taking one over: who may do so when several try at once."""

import os
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from skinfield.errors import FileError, InputError
from skinfield.ring import files
from skinfield.ring.files import Lock
from skinfield.ring.layout import Layout
from skinfield.ring.present import present

_PATIENCE = 2.0  # s, for another process that makes the same ring


@contextmanager
def made(path: Path, plan: Layout) -> Iterator[tuple[Lock, Path]]:
    """A new file, locked, and where it is now; it gets its name when all went well.

    So readers never see half a ring, and the file of a writer that lives is never replaced.

    Raises
    ------
    InputError
        If a living process writes a ring there.
    FileError
        If there is no memory for it.
    """
    lock, new = _new_file(path)
    try:
        with ExitStack() as stack:
            for old in _claimed(path):
                stack.callback(old.close)
            files.reserve(lock.descriptor, plan.header.file_bytes, path)
            os.pwrite(lock.descriptor, plan.beginning(), 0)
            yield lock, new
            new.rename(path)
    except BaseException:
        new.unlink(missing_ok=True)
        lock.close()
        raise


@contextmanager
def taken_over(path: Path) -> Iterator[Lock]:
    """A ring's file, now locked for this process.

    Raises
    ------
    InputError
        If a living process writes it.
    FileError
        If it is not there.
    """
    claimed = _claimed(path)
    if not claimed:
        raise FileError(f"{path} is not there, expected a ring to go on with: use Ring.create")
    try:
        yield claimed[0]
    except BaseException:
        claimed[0].close()
        raise


def remove(path: Path) -> None:
    """Delete a ring that nobody writes, and what remained of making one."""
    for each in (path, files.unfinished(path)):
        for lock in _claimed(each):
            each.unlink(missing_ok=True)
            lock.close()


def _claimed(path: Path) -> list[Lock]:
    """Lock the file of that name; an empty list if there is no such file.

    As long as its lock is held, nobody else gives the name to another file.
    """
    while True:
        try:
            descriptor = files.open_ring(path, write=True)
        except FileError:
            if os.path.lexists(path):
                raise
            return []
        lock = Lock.take(descriptor)
        if lock is None:
            raise InputError(_taken(path))
        if files.same(lock.descriptor, path):
            return [lock]
        lock.close()  # replaced between opening and locking: look again


def _new_file(path: Path) -> tuple[Lock, Path]:
    """Open and lock the file that becomes a ring when it is renamed: one process at a time."""
    new, end = files.unfinished(path), time.monotonic() + _PATIENCE
    while time.monotonic() < end:
        try:
            flags = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW
            descriptor = os.open(new, flags, 0o600)
        except OSError as error:
            raise FileError(
                f"{new} cannot be made: {error.strerror}, expected a folder that can be written"
            ) from error
        lock = Lock.take(descriptor)
        if lock is not None:
            if files.same(lock.descriptor, new):
                os.fchmod(lock.descriptor, 0o600)
                return lock, new
            lock.close()  # another has just given it its name
    raise InputError(f"{path} is being made by another process, expected one at a time")


def _taken(path: Path) -> str:
    who = [each for each in present(path.parent) if each.path == path]
    text = f" (process {who[0].pid})" if who and who[0].pid else ""
    return (
        f"{path} is written by a living process{text}, expected none: stop that one first, or "
        "take another name"
    )
