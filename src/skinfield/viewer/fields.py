"""Pressures that were worked out beside the engine."""

from collections.abc import Mapping
from typing import Any

from skinfield.errors import Floats


class Fields:
    """See `Fitted`: pressures by the names of patches."""

    def __init__(self, fields: Mapping[str, Any]) -> None:
        self._fields = fields

    def pressure(self, patch: str) -> Floats | None:
        """On the finest grid, (K,) Pa; None where there is none."""
        return self._fields.get(patch)
