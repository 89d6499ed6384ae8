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


SEEDS = [
    b"# Histogram\n000000 000000\n000001 000007\n000004 000001\n# Total: 000000010\n"
    b"# Max Latencies: 02402\n# Histogram Overflows: 00002\n# Thread 0: 00146 00329\n"
]
