"""How much the page sends."""

import time
from typing import Any


class Meter:
    """Counts updates and bytes to all browsers."""

    def __init__(self) -> None:
        self.updates = self.bytes = 0
        self._before = (time.monotonic(), 0, 0)

    def count(self, size: int) -> None:
        """A message of so many bytes was sent."""
        self.bytes += size

    def look(self, clients: int) -> dict[str, Any]:
        """Per second since the last look."""
        now = (time.monotonic(), self.updates, self.bytes)
        seconds = max(now[0] - self._before[0], 1e-9)
        told = {
            "clients": clients,
            "updates_per_s": (now[1] - self._before[1]) / seconds,
            "bytes_per_s": (now[2] - self._before[2]) / seconds,
        }
        self._before = now
        return told
