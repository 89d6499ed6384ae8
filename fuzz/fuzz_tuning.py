"""Orders to an engine, and blocks of what it goes by: taken, or refused; never anything else."""

import numpy as np

import skinfield as sf
from skinfield.acquisition import Blocks, Kind, Port
from skinfield.acquisition.block import PAYLOAD
from skinfield.errors import InputError
from skinfield.live.configuration import Configuration
from skinfield.live.control import order_of
from skinfield.live.in_force import InForce, beginning
from skinfield.live.recipe import Recipe
from skinfield.live.tuning import Focus, Limits, Tuning

NAMES = ("palm", "thumb")
LIMITS = Limits(rungs=(10, 20), longest=9e-4, patches=NAMES)
PATCH = sf.layouts.icub_triangle()
RECIPE = Recipe(
    skin=sf.Skin((PATCH,)),
    ports=(Port("port", 12),),
    layer=sf.Layer(),
    mechanics=sf.BondedLayer(),
    quantity=sf.Capacitance(),
    solver=sf.NonNegative(),
    rungs=(10, 20),
    board=None,
    budget=4e-4,
    rows=8,
)


def told() -> bytes:
    """Blocks of an engine that begins."""
    blocks = Blocks(1 << 12)
    text = Configuration(1, RECIPE.solver, began=True).text()
    blocks.put_rows(1, 0, Kind.CONFIGURATION, np.frombuffer(text.encode(), np.uint8))
    focus = Focus(patch=PATCH.name, low=(0.0, 0.0), high=(1e-3, 1e-3))
    numbers = Tuning(smoothing=0.02, focus=focus).numbers([PATCH.name])
    blocks.put_rows(2, 0, Kind.TUNING, numbers)
    rows = np.zeros(len(PATCH), PAYLOAD[Kind.SMOOTHED])
    blocks.put_rows(3, 0, Kind.SMOOTHED, rows)
    return blocks.data.tobytes()


SEEDS = [
    told(),
    b'{"do": "set", "set": {"resolution": 20, "deadline": 3e-4, "threshold": 0.2}}',
    b'{"do": "set", "set": {"focus": {"patch": "palm", "low": [0, 0], "high": [1, 1e-3]}}}',
    b'{"do": "set", "set": {"smoothing": NaN, "resolution": "auto", "focus": null}}',
    b'{"do": ["tare"], "set": {"": 1e999}}',
]


def one_input(data: bytes) -> None:
    """As a message, and as blocks."""
    _, values = order_of(data)
    try:
        changes = values.get("set")
        if isinstance(changes, dict):
            tuning = LIMITS.check(Tuning().changed(changes))
            assert Tuning.from_numbers(tuning.numbers(NAMES), NAMES) == tuning
    except InputError:
        pass
    blocks = Blocks(max(len(data), 64))
    blocks.put_data(data[: len(data) // 8 * 8])
    try:
        beginning(blocks, 0)
        InForce(RECIPE, len(PATCH)).take(blocks.data, None)
    except InputError:  # of which FileError is one
        pass
