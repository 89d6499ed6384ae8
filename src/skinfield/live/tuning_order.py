"""Has a running engine change its tuning, and waits until it has."""

import time
from collections.abc import Mapping
from typing import Any

from skinfield.live.control import order
from skinfield.live.snapshot import Stale
from skinfield.live.tuning import Focus, Limits, Tuning, tuning_of
from skinfield.ring import RingReader

LOOK = 0.005  # s


def retune(reader: RingReader, changes: Mapping[str, Any], timeout: float) -> Tuning:
    """Change settings by name; see `Live.tune`, whose errors these are."""
    limits = Limits.of(reader.description)
    wanted = limits.check(tuning_of(reader).changed(changes))
    if not changes:
        return wanted
    order(reader.name, "set", {"set": {name: _plain(getattr(wanted, name)) for name in changes}})
    end = time.monotonic() + timeout
    while timeout > 0 and not _in_force(found := tuning_of(reader), wanted, changes):
        if time.monotonic() > end:
            raise Stale(
                f"the engine did not take over {', '.join(changes)} within {timeout:g} s, and goes "
                f"by {found}: see `skinfield status {reader.name}`"
            )
        time.sleep(LOOK)
    return tuning_of(reader) if timeout > 0 else wanted


def _in_force(found: Tuning, wanted: Tuning, changes: Mapping[str, Any]) -> bool:
    """Whether all that was asked for is; another program may have changed the rest."""
    return all(getattr(found, name) == getattr(wanted, name) for name in changes)


def _plain(value: Any) -> Any:
    return value.as_dict() if isinstance(value, Focus) else value
