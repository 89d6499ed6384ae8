"""Readings of a hexagon that two fingers move over, made before: a load for an engine."""

import mmap
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition import Blocks, Count, Kind, Port, counters
from skinfield.errors import Floats, Ints
from skinfield.layout import Patch

NOISE = 0.002  # of ΔC/C₀
STEPS = 60  # places of the fingers on their way round
ROWS = 1200  # readings until they repeat: each with noise of its own
FINGERS = ((1.5, 6e-3, 10e-3, 0.0), (0.8, 5e-3, 12e-3, 2.4))  # N, radius m, way m, angle


@dataclass(frozen=True, eq=False)
class Fingers:
    """One reading per cycle, untouched until the switch is thrown.

    Parameters
    ----------
    patch : str
        Its name.
    touched, untouched : (R, L) float32 arrays
        Readings ΔC/C₀, one after the other and again.
    switch : str
        A file of one byte that is not 0 once the fingers are on.
    """

    patch: str
    touched: NDArray[np.float32] = field(repr=False)
    untouched: NDArray[np.float32] = field(repr=False)
    switch: str

    def open(self) -> "FingerStream":
        """In the engine's process."""
        return FingerStream(self)


class FingerStream:
    """See `skinfield.acquisition.Stream`."""

    def __init__(self, source: Fingers) -> None:
        self.ports: Sequence[Port] = (Port(source.patch, source.touched.shape[1], "dC/C0"),)
        self.counters: Ints = counters()
        self.up = True
        self._rows = source.untouched, source.touched
        with Path(source.switch).open("rb") as file:
            self._switch = mmap.mmap(file.fileno(), 1, access=mmap.ACCESS_READ)
        self._at = 0

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        """The next reading, which has just arrived."""
        rows = self._rows[1 if self._switch[0] else 0]
        blocks.put(now_ns, channel, rows[self._at % len(rows)], Kind.FLOATS)
        self._at += 1
        self.counters[Count.RECEIVED] += 1
        self.counters[Count.READINGS] += 1
        return 1

    def filenos(self) -> Sequence[int]:
        """None: it is read at a rate."""
        return ()

    def close(self) -> None:
        """Let go of the switch."""
        self._switch.close()


class Switch:
    """A byte that two processes see."""

    def __init__(self) -> None:
        number, self.path = tempfile.mkstemp(prefix="skinfield-switch-")
        os.write(number, b"\0")
        self._memory = mmap.mmap(number, 1)
        os.close(number)

    def throw(self) -> None:
        """Put the fingers on."""
        self._memory[0] = 1

    def close(self) -> None:
        """Take the file away."""
        self._memory.close()
        Path(self.path).unlink(missing_ok=True)


def fingers(patch: Patch, switch: Switch, seed: int = 0) -> Fingers:
    """Press two balls along circles on a patch under the default layer."""
    clean = pressed(patch)
    rng = np.random.default_rng(seed)
    noise = rng.normal(scale=NOISE, size=(ROWS, len(patch)))
    between = np.linspace(0, STEPS, ROWS, endpoint=False)
    first = between.astype(int)
    share = (between - first)[:, None]
    moving = (1 - share) * clean[first] + share * clean[(first + 1) % STEPS]
    return Fingers(
        patch.name,
        (moving + noise).astype(np.float32),
        noise.astype(np.float32),
        switch.path,
    )


def pressed(patch: Patch) -> Floats:
    """Readings (STEPS, L) without noise: half a turn of two fingers, there and back.

    Each finger is pressed once, and the patch is moved under it. That the sum of both is not quite
    what both together would do makes no difference to how long it takes to reconstruct.
    """
    from skinfield.mechanics import Layer
    from skinfield.simulate import Sphere, press

    half = STEPS // 2
    there: Floats = np.zeros((half, len(patch)))
    for force, radius, way, angle in FINGERS:
        ball = Sphere(radius=radius, position=(0.0, 0.0), force=force)
        contact = press(Layer(), [ball])
        bearing = angle + np.pi * np.arange(half) / half
        places = way * np.column_stack([np.cos(bearing), np.sin(bearing)])
        moved = (patch.positions[None, :, :2] - places[:, None]).reshape(-1, 2)
        there += contact.capacitance(moved, patch.pad_diameter).reshape(half, -1)
    return np.concatenate([there, there[::-1]])
