"""Head of a file: enough to say what it is without reading all of it."""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from skinfield.errors import FileError

SIZE = 1 << 20  # bytes; some hundred lines even of a whole body's skin
SAMPLE = 200  # lines that vote on the width


@dataclass(frozen=True)
class Magic:
    """First bytes of a file.

    Attributes
    ----------
    path : Path
    data : bytes
        At most `SIZE`.
    size : int, bytes
        Of the whole file.
    """

    path: Path
    data: bytes
    size: int

    @cached_property
    def lines(self) -> list[str]:
        """Lines without their ends; a last one that `SIZE` cuts is left out."""
        text = self.data.removeprefix(b"\xef\xbb\xbf").decode("latin-1")
        lines = [line.strip() for line in text.split("\n")]
        return lines[:-1] if len(self.data) < self.size and len(lines) > 1 else lines

    def numbered(self, skip: int = 0) -> list[tuple[int, str]]:
        """Lines that hold data, with their numbers from 1; the first `skip` lines are left out."""
        return [
            (number, line)
            for number, line in enumerate(self.lines, 1)
            if line and number > skip and not line.startswith("#")
        ]

    def rows(self, skip: int, delimiter: str | None, blank: str = "") -> list[list[str]]:
        """Tokens of the first `SAMPLE` data lines after `skip` lines."""
        spaces = str.maketrans(blank, " " * len(blank))
        lines = [line.translate(spaces) for _, line in self.numbered(skip)[:SAMPLE]]
        return [line.split(delimiter) for line in lines if line.strip()]


def read_head(path: Path) -> Magic:
    """First bytes of `path`; raises FileError if it cannot be read or holds nothing."""
    try:
        with path.open("rb") as file:
            head = Magic(path, file.read(SIZE), path.stat().st_size)
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise FileError(f"{path} cannot be read: {why}; expected a recording") from error
    if not head.data.strip():
        raise FileError(f"{path} is empty, expected a recording: was the recorder running?")
    return head


def usual_width(rows: list[list[str]]) -> int:
    """Number of tokens that most rows have; 0 without rows."""
    common = Counter(len(row) for row in rows).most_common(1)
    return common[0][0] if common else 0


def usual_decimals(rows: list[list[str]]) -> int:
    """Decimals of the last token where all rows agree on one or more; else 0."""
    width = usual_width(rows)
    decimals = {decimals_of(row[-1]) for row in rows[:-1] if len(row) == width}
    return decimals.pop() if len(decimals) == 1 else 0


def decimals_of(token: str) -> int:
    """Digits after the decimal point."""
    return len(token.partition(".")[2])


def is_whole(token: str) -> bool:
    """Whether `token` is an unsigned integer in plain digits."""
    return token.isascii() and token.isdigit()


def is_number(token: str) -> bool:
    """Whether `token` reads as a number, nan and inf included."""
    try:
        float(token)
    except ValueError:
        return False
    return "_" not in token
