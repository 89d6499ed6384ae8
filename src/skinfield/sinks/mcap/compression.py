"""How the chunks of a recording are compressed."""

from dataclasses import dataclass
from typing import Protocol

from skinfield.errors import check_count

Bytes = bytes | bytearray | memoryview


class Compression(Protocol):
    """One of those that MCAP knows."""

    @property
    def name(self) -> str:
        """As the file states it."""
        ...

    def pack(self, data: Bytes) -> Bytes:
        """Compress a chunk."""
        ...


@dataclass(frozen=True)
class Zstd:
    """Zstandard: about a third smaller for 8-bit counts, little for 16-bit ones.

    Parameters
    ----------
    level : int
        1 is the quickest.
    """

    level: int = 1

    def __post_init__(self) -> None:
        check_count("level", self.level, 1, 22, "of zstandard")

    @property
    def name(self) -> str:
        """See `Compression`."""
        return "zstd"

    def pack(self, data: Bytes) -> Bytes:
        """See `Compression`."""
        import zstandard

        return zstandard.ZstdCompressor(level=self.level).compress(data)  # type: ignore[no-any-return, unused-ignore]


@dataclass(frozen=True)
class Lz4:
    """LZ4: hardly any time, hardly any gain on noisy counts."""

    @property
    def name(self) -> str:
        """See `Compression`."""
        return "lz4"

    def pack(self, data: Bytes) -> Bytes:
        """See `Compression`."""
        import lz4.frame

        return lz4.frame.compress(data)  # type: ignore[no-any-return, unused-ignore]


@dataclass(frozen=True)
class NoCompression:
    """Chunks as they are."""

    @property
    def name(self) -> str:
        """See `Compression`."""
        return ""

    def pack(self, data: Bytes) -> Bytes:
        """See `Compression`."""
        return data
