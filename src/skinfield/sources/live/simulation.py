"""A source without hardware or another process: readings that were computed before."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skinfield.acquisition import Port
from skinfield.errors import Floats, InputError, as_floats, check_positive
from skinfield.layout import Patch, Skin
from skinfield.mechanics import Layer
from skinfield.sources.live.table import TableStream

LADDER = 3  # forces that are solved; those between are interpolated
RADIUS = 6e-3  # m, of the ball that presses
REST, NOISE = 1000.0, 20.0  # counts


@dataclass(frozen=True, eq=False)
class SimulationSource:
    """Delivers the rows of a table at a steady rate.

    Parameters
    ----------
    counts : (T, C) array
        NaN where a taxel does not answer.
    rate : float, 1/s
    ports : sequence of Port
        Of C channels together; default one of the name "skin", in counts.
    loop : bool
        Whether it begins anew behind the last row.
    """

    counts: ArrayLike
    rate: float = 50.0
    ports: Sequence[Port] = ()
    loop: bool = True

    def __post_init__(self) -> None:
        check_positive("rate", self.rate, "readings per second")
        counts = as_floats("counts", self.counts)
        if counts.ndim != 2 or not counts.size:
            raise InputError(f"counts has shape {counts.shape}, expected (readings, channels)")
        ports = tuple(self.ports) or (Port("skin", counts.shape[1]),)
        channels = sum(port.channels for port in ports)
        if channels != counts.shape[1]:
            raise InputError(
                f"counts has {counts.shape[1]} columns, expected {channels}: the channels of "
                f"{', '.join(port.name for port in ports)}"
            )
        object.__setattr__(self, "counts", counts)
        object.__setattr__(self, "ports", ports)

    def open(self) -> TableStream:
        """Begin; the first reading is there at the first poll."""
        counts = np.asarray(self.counts, np.float64)
        step = round(1e9 / self.rate)
        after = np.arange(len(counts), dtype=np.int64) * step
        return TableStream(tuple(self.ports), counts, after, loop=self.loop, pause_ns=step)


def pressed(
    skin: Skin | Patch,
    layer: Layer | None = None,
    *,
    force: float = 3.0,
    period: float = 4.0,
    rest: float = 6.0,
    rate: float = 50.0,
    seed: int = 0,
) -> SimulationSource:
    """A ball that presses into the middle of each patch in turn, again and again.

    Counts of 16 bits, which grow under pressure, of the gain that CySkin has, with white noise.

    Parameters
    ----------
    skin : Skin or Patch
    layer : Layer, optional
    force : float, N
        The greatest.
    period : float, s
        Of one press, from touch to lifting.
    rest : float, s
        Without touch, at first and between two patches.
    rate : float, 1/s
    seed : int
        Of the noise.

    Returns
    -------
    SimulationSource
        With a port for each patch; NaN on channels that no taxel has.
    """
    for name, value in (("period", period), ("rest", rest), ("rate", rate)):
        check_positive(name, value, "of the presses")
    patches = (skin,) if isinstance(skin, Patch) else tuple(skin)
    steps, idle = max(2, round(period * rate)), max(1, round(rest * rate))
    loads = np.zeros((len(patches), len(patches), idle + steps))  # of each patch, turn by turn
    turns = np.arange(len(patches))
    loads[turns, turns, idle:] = force * np.sin(np.pi * np.arange(steps) / steps) ** 2
    rng, forces = np.random.default_rng(seed), np.linspace(0.0, force, LADDER + 1)
    tables = [
        _counts(patch, loads[place].ravel(), forces, rungs, rng)
        for place, (patch, rungs) in enumerate(
            zip(patches, _ladder(layer or Layer(), force, patches), strict=True)
        )
    ]
    ports = tuple(Port(patch.name, patch.n_channels) for patch in patches)
    return SimulationSource(np.hstack(tables), rate, ports)


def _counts(
    patch: Patch, loads: Floats, forces: Floats, rungs: Floats, rng: np.random.Generator
) -> Floats:
    """Counts (T, C) of a patch under loads (T,), between the rungs of its ladder."""
    from skinfield.simulate.electronics import CySkinBoard

    table = np.full((len(loads), patch.n_channels), np.nan)
    for taxel, channel in enumerate(patch.channel):
        table[:, channel] = np.interp(loads, forces, rungs[:, taxel])
    noise = NOISE * rng.standard_normal(table.shape)
    return np.asarray(np.clip(np.rint(REST + CySkinBoard().gain * table + noise), 0.0, 65535.0))


def _ladder(layer: Layer, force: float, patches: Sequence[Patch]) -> list[Floats]:
    """Readings (LADDER + 1, L) of each patch for forces from 0 on, the ball in its middle."""
    from skinfield.simulate import Sphere, press_ladder

    presses = press_ladder(
        layer, Sphere(radius=RADIUS, force=force), np.linspace(0.0, force, LADDER + 1)[1:]
    )
    found = []
    for patch in patches:
        middle = patch.plane[np.argmin(np.sum((patch.plane - patch.plane.mean(0)) ** 2, axis=1))]
        at = patch.plane - middle
        rungs = [press.capacitance(at, patch.pad_diameter) for press in presses]
        found.append(np.array([np.zeros(len(patch)), *rungs]))
    return found
