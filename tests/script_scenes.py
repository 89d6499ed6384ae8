"""Chains of cycles under small budgets, and what they answered, for tests of scripts."""

import hashlib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from engine_scenes import BALL, HEXAGON, NOISE, SKIN, engine_of

import skinfield as sf
from skinfield.engine import Engine
from skinfield.errors import Floats, Ints

SOLVERS = {"search": sf.NonNegative(), "linear": sf.GaussianField()}
STARTS = [0, *np.cumsum([len(patch) for patch in SKIN]).tolist()]
SEVERAL = 20  # cycles in which the same taxels are missing
AWAY = np.linspace(0.0, 80e-3, 400)  # m, from the middle of a press
PROFILE = BALL.readings(
    np.stack([AWAY, np.zeros(len(AWAY))], axis=1), HEXAGON.pad_diameter, "capacitance"
)


class Chain(NamedTuple):
    """Cycles as they were: readings (C, N), which taxels to use, scripts and what was answered."""

    readings: Floats
    valid: Any
    scripts: list[Ints]
    digests: list[str]


def moving(cycles: int, seed: int) -> tuple[Floats, Any]:
    """Readings (C, N) of balls that come, slide and go on every patch, and taxels to use (C, N)."""
    rng, phase = np.random.default_rng(seed), np.linspace(0.0, 1.0, cycles)
    readings = rng.normal(0.0, NOISE, (cycles, STARTS[-1]))
    valid = np.ones(readings.shape, np.bool_)
    for patch, start in zip(SKIN, STARTS, strict=False):
        low, high = patch.plane.min(axis=0), patch.plane.max(axis=0)
        turns = rng.uniform(3, 9, 3)[:, None] * 2 * np.pi * phase + rng.uniform(0, 6, 3)[:, None]
        middle = low + (high - low) * (0.5 + 0.4 * np.sin(turns[:2].T))
        away = np.linalg.norm(patch.plane[None] - middle[:, None], axis=2)
        strength = np.maximum(np.sin(turns[2]), 0.0)[:, None]
        readings[:, start : start + len(patch)] += strength * np.interp(away, AWAY, PROFILE)
        for first in range(0, cycles, SEVERAL):
            kind, here = rng.integers(6), slice(first, first + SEVERAL)
            taxels = start + rng.integers(len(patch), size=3)
            if kind == 0:
                readings[here, taxels[:, None]] = np.nan
            elif kind == 1:
                valid[here, taxels[:, None]] = False
            elif kind == 2 and rng.random() < 0.3:
                readings[here, start : start + len(patch)] = np.nan
    return readings, valid


def digest(engine: Engine) -> str:
    """Of all that a cycle answered, bit for bit."""
    found, results = hashlib.blake2b(digest_size=12), engine.results
    for patch in range(len(engine.names)):
        found.update(results.pressure_of(patch).tobytes())
    for each in (results.answer, results.rung, results.gap, results.iterations, results.age):
        found.update(each.tobytes())
    return found.hexdigest()


def lived(engine: Engine, readings: Floats, valid: Any, budgets: Floats) -> Chain:
    """A chain by the clock."""
    engine.reset()
    scripts, digests = [], []
    for cycle, budget in enumerate(budgets):
        engine.run(readings[cycle], valid[cycle], budget=budget)
        scripts.append(engine.script.copy())
        digests.append(digest(engine))
    return Chain(readings, valid, scripts, digests)


def replayed(engine: Engine, chain: Chain) -> list[str]:
    """The same chain by its scripts."""
    engine.reset()
    digests = []
    for readings, valid, script in zip(chain.readings, chain.valid, chain.scripts, strict=True):
        engine.run(readings, valid, script=script)
        digests.append(digest(engine))
    return digests


def save(path: Path, chain: Chain) -> None:
    lengths = np.array([len(each) for each in chain.scripts])
    np.savez(
        path, chain.readings, chain.valid, np.concatenate(chain.scripts), lengths, chain.digests
    )


def replay_file(path: str, solver: str) -> None:
    """What another process does: raise if anything is different."""
    with np.load(path) as stored:
        readings, valid, rows, lengths, digests = (stored[f"arr_{i}"] for i in range(5))
    scripts = np.split(rows, np.cumsum(lengths)[:-1])
    chain = Chain(readings, valid, scripts, digests.tolist())
    found = replayed(engine_of(SOLVERS[solver]), chain)
    wrong = [cycle for cycle, (a, b) in enumerate(zip(found, digests, strict=True)) if a != b]
    if wrong:
        raise SystemExit(f"{len(wrong)} cycles are different, the first is {wrong[0]}")
