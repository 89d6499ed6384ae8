"""Scripts of recorded cycles: any rows are done again, or refused; never anything else."""

from contextlib import suppress
from dataclasses import replace

import numpy as np

import skinfield as sf
from skinfield.engine import Engine
from skinfield.engine.script import WIDTH
from skinfield.errors import InputError

PATCH = sf.layouts.icub_triangle()
SKIN = sf.Skin((PATCH, replace(PATCH, name="other")))
RNG = np.random.default_rng(0)
READINGS = RNG.normal(0.0, 0.002, 2 * len(PATCH))
READINGS[3] += 0.2
READINGS[-1] = np.nan
ENGINES = [
    Engine(SKIN, rungs=(6, 12), solver=solver, noise_std=0.002)
    for solver in (sf.NonNegative(), sf.GaussianField())
]


def _seed(engine: Engine) -> bytes:
    engine.run(READINGS, budget=10.0)
    return bytes([ENGINES.index(engine)]) + engine.script.tobytes()


SEEDS = [_seed(engine) for engine in ENGINES]


def one_input(data: bytes) -> None:
    """The first byte chooses a solver, and whether to forget before; then rows of 5 numbers."""
    if not data:
        return
    engine, room = ENGINES[data[0] % 2], data[1:]
    if data[0] & 2:
        engine.reset()
    rows = np.frombuffer(room[: len(room) // (8 * WIDTH) * 8 * WIDTH], np.int64)
    with suppress(InputError):
        engine.run(READINGS, script=rows.reshape(-1, WIDTH))
