"""Bytes of a shape's file, of a size that can be one."""

from collections.abc import Iterable
from pathlib import Path

from skinfield.errors import FileError

MOST_BYTES = 256 * 2**20


def read_shape(path: str | Path, endings: Iterable[str], what: str) -> tuple[Path, bytes]:
    """Path and content of a file with one of `endings`.

    Raises
    ------
    FileError
        If it has another ending, cannot be read, or is larger than any such shape.
    """
    path = Path(path)
    if path.suffix.lower() not in endings:
        raise FileError(f"{path} has another ending, expected {what} in {', '.join(endings)}")
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise FileError(
                f"{path} holds {size / 2**20:.0f} MB, expected at most {MOST_BYTES // 2**20}: "
                "make the shape coarser, a tenth of the skin's thickness is fine enough"
            )
        return path, path.read_bytes()
    except OSError as error:
        raise FileError(
            f"{path} cannot be read, expected {what}: {error.strerror or error}"
        ) from error
