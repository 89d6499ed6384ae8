"""A growing file to which pieces are added whole or not at all."""

import os
from pathlib import Path
from typing import Protocol

from skinfield.errors import FileError, InputError


class Output(Protocol):
    """Where a container's pieces go."""

    @property
    def end(self) -> int:
        """Bytes so far."""
        ...

    def append(self, piece: bytes | bytearray | memoryview) -> None:
        """Add a piece; on OSError nothing of it is there."""
        ...

    def sync(self) -> None:
        """Have the system write everything to the disk."""
        ...

    def close(self) -> None:
        """Let go of the file."""
        ...


class FileOutput:
    """A file, unbuffered: what was appended survives the end of the process.

    Parameters
    ----------
    path : Path
    overwrite : bool
        Whether a file of this name may be replaced.

    Raises
    ------
    InputError
        If there is one and it may not.
    FileError
        If it cannot be made.
    """

    def __init__(self, path: Path, *, overwrite: bool = False) -> None:
        self.end = 0
        flags = os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC | (os.O_TRUNC if overwrite else os.O_EXCL)
        try:
            self._file = os.open(path, flags, 0o666)
        except FileExistsError as error:
            raise InputError(
                f"{path} is there already, expected a new name: choose another, or allow to "
                "overwrite it"
            ) from error
        except (OSError, ValueError) as error:  # a zero byte in the name is a ValueError
            why = getattr(error, "strerror", None) or error
            raise FileError(
                f"{path} cannot be made: {why}; expected a folder that can be written to"
            ) from error

    def append(self, piece: bytes | bytearray | memoryview) -> None:
        """See `Output`."""
        left = memoryview(piece)
        try:
            while left:
                left = left[os.pwrite(self._file, left, self.end + len(piece) - len(left)) :]
        except OSError:
            os.ftruncate(self._file, self.end)  # what a full disk took of it
            raise
        self.end += len(piece)

    def sync(self) -> None:
        """See `Output`."""
        os.fdatasync(self._file)

    def close(self) -> None:
        """See `Output`."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1
