"""Orders to an engine, and settings of recordings: taken, or refused; never anything else."""

import contextlib
import json

import skinfield as sf
from skinfield.errors import InputError
from skinfield.loop.control import order_of
from skinfield.loop.model_config import Configuration
from skinfield.loop.runtime_parameters import Limits, Tuning

NAMES = ("palm", "thumb")
LIMITS = Limits(rungs=(10, 20), longest=9e-4, patches=NAMES)
SEEDS = [
    json.dumps(Configuration(1, sf.NonNegative(), Tuning()).as_dict()).encode(),
    b'{"do": "set", "set": {"resolution": 20, "deadline": 3e-4, "threshold": 0.2}}',
    b'{"do": "set", "set": {"focus": {"patch": "palm", "low": [0, 0], "high": [1, 1e-3]}}}',
    b'{"do": "set", "set": {"smoothing": NaN, "resolution": "auto", "focus": null}}',
    b'{"do": ["tare"], "set": {"": 1e999}}',
]


def one_input(data: bytes) -> None:
    """As a message, and as a configuration."""
    _, values = order_of(data)
    with contextlib.suppress(InputError):
        changes = values.get("set")
        if isinstance(changes, dict):
            tuning = LIMITS.check(Tuning().changed(changes))
            assert Tuning().changed(json.loads(json.dumps(tuning.as_dict()))) == tuning
    with contextlib.suppress(InputError, ValueError, RecursionError):  # refused; no JSON
        Configuration.from_dict(json.loads(data))
