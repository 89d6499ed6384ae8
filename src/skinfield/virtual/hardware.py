"""What the boards of every maker offer to the loop that plays them."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from skinfield.virtual.electronics import Converters
from skinfield.virtual.schedule import Schedule


class Hardware(Protocol):
    """Boards on their buses.

    Attributes
    ----------
    converters : Converters
        Its first channels are the taxels of all patches.
    schedule : Schedule
    addresses : sequence of str
        Where a host finds each bus.
    readings : int
        Of boards, that were made so far.
    """

    @property
    def converters(self) -> Converters:
        """See above."""
        ...

    @property
    def schedule(self) -> Schedule:
        """See above."""
        ...

    @property
    def addresses(self) -> Sequence[str]:
        """See above."""
        ...

    @property
    def readings(self) -> int:
        """See above."""
        ...

    @property
    def chances(self) -> Mapping[str, float]:
        """Probabilities of `lose`, `duplicate` and `swap`, per message."""
        ...

    def start(self, now_ns: int) -> None:
        """Send from now on what sends without being told."""
        ...

    def check(self, kind: str, what: str) -> None:
        """Raise InputError if there is no such triangle, board or bus."""
        ...

    def filenos(self) -> Sequence[int]:
        """File descriptors that become readable when a host says something."""
        ...

    def listen(self, now_ns: int, warmth: float) -> None:
        """Take in what hosts say, and answer; never waits."""
        ...

    def send(self, members: Sequence[int], now_ns: int) -> None:
        """Send the counts of now from some boards."""
        ...

    def begin(self, kind: str, what: str, now_ns: int) -> None:
        """Begin a fault of a triangle, board or bus.

        Raises
        ------
        InputError
            If there is no such one.
        """
        ...

    def end(self, kind: str, what: str, now_ns: int, warmth: float) -> None:
        """End it."""
        ...

    def set_chances(self, lose: float, duplicate: float, swap: float) -> None:
        """Change what happens to messages from now on."""
        ...

    def counts(self) -> dict[str, Any]:
        """What was sent and what was done to it: whole numbers."""
        ...

    def close(self) -> None:
        """Let go of the buses."""
        ...
