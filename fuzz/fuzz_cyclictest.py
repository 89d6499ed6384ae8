"""What cyclictest prints: any text is a histogram, or a FileError."""

from skinfield.errors import FileError
from skinfield.realtime.cyclictest import lateness_of


def one_input(data: bytes) -> None:
    """The bytes as its output."""
    try:
        found = lateness_of(data.decode("utf-8", "replace").splitlines())
    except FileError:
        return
    assert found.count > 0
    assert found.quantiles().count == found.count
