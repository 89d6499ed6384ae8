"""Data sets: small recordings of simulated skins with their truth, made when they are loaded."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from skinfield.elastic import Layer
from skinfield.errors import Floats, check_choice, check_count
from skinfield.plot import Pictured, Place, number, plural
from skinfield.signal import Calibration
from skinfield.simulate.electronics.array import (
    Electronics,
    cyskin_electronics,
    ideal_electronics,
    recording,
)
from skinfield.simulate.electronics.noise import Noise
from skinfield.simulate.habits import habits_by_name
from skinfield.simulate.indenters.body import Indenter
from skinfield.simulate.indenters.shapes import Cylinder, Sphere
from skinfield.simulate.pressing.press import press_ladder
from skinfield.simulate.rig.run import run_rig
from skinfield.simulate.rig.scenario import At, ContactAccuracy, LoadProfile, Loads, Scenario, Tool
from skinfield.skin import Patch
from skinfield.skin.generators import hexagon72, rectangular
from skinfield.skin.reading import Recording

__all__ = ["Dataset", "load", "names"]

RUNGS = 4  # forces that are solved, by their roots; between them readings are lines over the root
SECOND = (3 / RUNGS) ** 2  # part of the highest force that is solved, too
ROOM = 293.15  # K


@dataclass(frozen=True, eq=False, repr=False)
class Dataset(Pictured):
    """A recording of T readings that was simulated, and what truly happened.

    Attributes
    ----------
    name, about : str
    patch : Patch
    layer : Layer
        As stated: what a solver is told.
    recording : Recording
        ΔC/C₀, or counts of `real_habits`: (T, L), a column for each taxel of the patch.
    calibration : Calibration
        The true one of the electronics.
    force : (T, P) array, N
        Of each of P bodies into the skin; 0 where it does not touch.
    place : (T, P, 2) array, m
        Where each presses, in the patch's plane.
    """

    name: str
    about: str
    patch: Patch
    layer: Layer
    recording: Recording
    calibration: Calibration
    force: Floats
    place: Floats

    def __len__(self) -> int:
        return len(self.recording)

    def __repr__(self) -> str:
        return f"Dataset({self.name!r}, {self._bodies()}, {self.recording!r})"

    def _bodies(self) -> str:
        highest = number(float(self.force.sum(axis=1).max()))
        bodies = plural(self.force.shape[1], "body", "bodies")
        return f"{bodies}, up to {highest} N"

    @property
    def peak(self) -> int:
        """Row in the middle of the readings under the highest force in all."""
        total = self.force.sum(axis=1)
        highest = np.flatnonzero(total >= 0.999 * total.max())
        return int(highest[len(highest) // 2])

    def truth(self, row: int) -> list[tuple[Floats, float, float]]:
        """What presses at a reading: (place (2,) m, force N, radius 0 m), as `Estimate.plot` takes.

        Raises
        ------
        InputError
            For a reading that is not there.
        """
        check_count("row", row, -len(self), len(self) - 1, "a reading of the recording")
        pairs = zip(self.place[row], self.force[row].tolist(), strict=True)
        return [(place, force, 0.0) for place, force in pairs if force > 0.0]

    def plot(self, ax: Place = None) -> Any:
        """Draw the recording; see `Recording.plot`."""
        return self.recording.plot(ax)

    def _facts(self) -> Mapping[str, str]:
        return {
            "Dataset": self.name,
            "about": self.about,
            "truth": self._bodies(),
            "patch": repr(self.patch),
            "layer": repr(self.layer),
            "recording": repr(self.recording),
        }


@dataclass(frozen=True, eq=False)
class _Touch:
    """Force (T,) N of a body at times (T,) s, and its place (T, 2) m then."""

    force: "Over"
    place: "Over"


def _felt(
    body: Indenter,
    touches: list[_Touch],
    patch: Patch,
    layer: Layer,
    time: Floats,
    instants: Floats,
) -> Floats:
    """ΔC/C₀ (T, L) at instants (T, L) s of cycles that begin at times (T,) s, of equal bodies.

    They lie so far from each other that each is solved alone, and their readings add up.
    """
    force = np.stack([touch.force(instants) for touch in touches])
    every = np.stack([touch.place(time) for touch in touches]).round(5)
    places, row = np.unique(every.reshape(-1, 2), axis=0, return_inverse=True)
    points = (patch.plane[None] - places[:, None]).reshape(-1, 2)
    forces = force.max() * (np.arange(1, RUNGS + 1) / RUNGS) ** 2
    rungs = np.zeros((RUNGS + 1, len(places), len(patch)))
    for rung, one in enumerate(press_ladder(layer, body, forces), start=1):
        rungs[rung] = one.capacitance(points, patch.pad_diameter).reshape(rungs.shape[1:])
    step = RUNGS * np.sqrt(force / force.max())
    low = np.minimum(step.astype(np.int64), RUNGS - 1)
    at, taxel, part = row.reshape(len(touches), -1, 1), np.arange(len(patch)), step - low
    felt = (1.0 - part) * rungs[low, at, taxel] + part * rungs[low + 1, at, taxel]
    return np.asarray(felt.sum(axis=0))


Over = Callable[[Floats], Floats]  # time


def _held(start: float, end: float, newtons: float, ramp: float = 0.4) -> Over:
    """Force that rises, is held and falls."""
    times = [start, start + ramp, end - ramp, end]
    return lambda time: newtons * np.interp(time, times, [0.0, 1.0, 1.0, 0.0])


def _at(x: float, y: float) -> Over:
    return lambda time: np.broadcast_to([x, y], (len(time), 2)).astype(np.float64)


def _along(start: float, end: float, first: Floats, last: Floats) -> Over:
    """Place that goes from the first to the last at one speed."""
    return lambda time: first + np.interp(time, [start, end], [0.0, 1.0])[:, None] * (last - first)


def _touched(
    name: str,
    body: Indenter,
    touches: list[_Touch],
    seed: int,
    *,
    patch: Patch,
    layer: Layer,
    seconds: float,
) -> Dataset:
    """Recording of equal bodies."""
    made, clock, noise = np.random.default_rng([seed, NAMES.index(name)]).spawn(3)
    skin = _good_electronics().manufacture(patch, made)
    sampling = skin.sample_times(seconds, clock)
    instants = sampling.time[:, None] + sampling.skew
    change = _felt(body, touches, patch, layer, sampling.time, instants)
    warmth = np.full(len(sampling), ROOM)
    sent = recording(skin, sampling, change, warmth, noise, source=f"skinfield.datasets {name}")
    time = sampling.time[sampling.logged[0]]
    force = np.column_stack([touch.force(time) for touch in touches])
    place = np.stack([touch.place(time) for touch in touches], axis=1)
    parts = patch, layer, sent, skin.calibration, force, place
    return Dataset(name, ABOUT[name], *parts)


def _rigged(name: str, scenario: Scenario) -> Dataset:
    """Recording of the rig, one press after the other."""
    run = run_rig(scenario)
    truth, time = run.truth, run.truth.reading_time_s
    last = np.maximum(np.searchsorted(truth.press_start_s, time, side="right") - 1, 0)
    place = np.column_stack([truth.press_x_m, truth.press_y_m])[last]
    force = truth.reading_force_N[:, None]
    parts = scenario.patch, scenario.layer, run.recording, run.skin.calibration
    return Dataset(name, ABOUT[name], *parts, force, place[:, None])


def _two_presses(seed: int) -> Dataset:
    first = _Touch(_held(1.0, 5.0, 2.0), _at(-12e-3, 5e-3))
    second = _Touch(_held(2.0, 4.0, 2.0 * SECOND), _at(11e-3, -8e-3))
    skin: dict[str, Any] = {"patch": hexagon72(), "layer": Layer(), "seconds": 6.0}
    return _touched("two_presses", Sphere(radius=6e-3), [first, second], seed, **skin)


def _stroke(seed: int) -> Dataset:
    way = _along(1.5, 4.5, np.array([-16e-3, -6e-3]), np.array([16e-3, 8e-3]))
    touch = _Touch(_held(1.0, 5.0, 1.5), way)
    skin: dict[str, Any] = {"patch": hexagon72(), "layer": Layer(), "seconds": 6.0}
    return _touched("stroke", Sphere(radius=6e-3), [touch], seed, **skin)


def _light_touches(seed: int) -> Dataset:
    places = At(positions=((0.0, 7e-3), (-13e-3, -6e-3)))
    return _rigged("light_touches", _scenario(seed, places, (0.05, 0.2), _good_electronics()))


def _foot_step(seed: int) -> Dataset:
    ball = _Touch(_held(1.6, 3.4, 80.0, 0.7), _at(-6e-3, 45e-3))
    heel = _Touch(_held(1.0, 2.6, 80.0 * SECOND, 0.5), _at(0.0, -60e-3))
    skin: dict[str, Any] = {
        "patch": rectangular(rows=16, columns=7, pitch=12e-3, pad_diameter=6e-3),
        "layer": Layer(thickness=3e-3, young_modulus=400e3),
        "seconds": 4.5,
    }
    sole = Cylinder(radius=16e-3, edge_radius=4e-3)
    return _touched("foot_step", sole, [heel, ball], seed, **skin)


def _real_habits(seed: int) -> Dataset:
    places = At(positions=((0.0, 7e-3), (13e-3, -6e-3)))
    stated = _scenario(seed, places, (1.0,), cyskin_electronics())
    scenario = stated.with_habits(habits_by_name("real"))
    return _rigged("real_habits", next(scenario.runs())[1])


def _good_electronics() -> Electronics:
    """A board of the laboratory: gains spread by 5 %, noise of 5e-4 in ΔC/C₀, none clipped."""
    return replace(ideal_electronics(), gain_spread=0.05, noise=Noise(white=5e-4))


def _scenario(
    seed: int, places: At, forces: tuple[float, ...], electronics: Electronics
) -> Scenario:
    return Scenario(
        seed=seed,
        patch=hexagon72(),
        tools=(Tool(name="ball", indenter=Sphere(radius=6e-3)),),
        places=(places,),
        loads=Loads(forces=forces),
        electronics=electronics,
        profile=LoadProfile(rest=1.0, approach=0.2, ramp=0.3, hold=0.8, release=0.3, pause=0.4),
        solving=ContactAccuracy(rungs=4),
    )


MAKERS: Mapping[str, Callable[[int], Dataset]] = {
    "two_presses": _two_presses,
    "stroke": _stroke,
    "light_touches": _light_touches,
    "foot_step": _foot_step,
    "real_habits": _real_habits,
}
NAMES = tuple(MAKERS)
ABOUT = {
    "two_presses": "balls of 6 mm radius press with 2 N and 1.125 N, 26 mm apart",
    "stroke": "a ball of 6 mm radius goes 35 mm over the skin with 1.5 N",
    "light_touches": "a ball of 6 mm radius touches two places with 0.05 and 0.2 N",
    "foot_step": "a step on a sole of 7 x 16 taxels: heel with 45 N, then ball with 80 N",
    "real_habits": "a soft finger presses two places with 1 N; the skin has habits of real ones: "
    "noise, gains, creep, faults, tolerances",
}


def names() -> list[str]:
    """Names of the data sets, which `load` takes.

    Examples
    --------
    >>> import skinfield as sf
    >>> sf.datasets.names()
    ['two_presses', 'stroke', 'light_touches', 'foot_step', 'real_habits']
    """
    return list(NAMES)


@lru_cache(maxsize=16)
def _made(name: str, seed: int) -> Dataset:
    return MAKERS[name](seed)


def load(name: str, *, seed: int = 0) -> Dataset:
    """Make a data set, the same one for a name and a seed; some tenths of a second to 2 s.

    Parameters
    ----------
    name : str
        One of `names`.
    seed : int
        Of the skin as made and of its noise.

    Returns
    -------
    Dataset
        Not to be changed: the next call gives the same object.

    Raises
    ------
    InputError
        For another name; the message lists those that there are.

    Examples
    --------
    >>> import skinfield as sf
    >>> pressed = sf.datasets.load("two_presses")
    >>> rec = sf.Reconstructor(pressed.patch, pressed.layer, calibration=pressed.calibration)
    >>> est = rec(pressed.recording.counts[pressed.peak])
    >>> ax = est.plot(truth=pressed.truth(pressed.peak))
    """
    check_choice("name", name, NAMES, "of a data set")
    check_count("seed", seed, 0, 2**31 - 1, "of all that is random")
    return _made(name, seed)


def __dir__() -> list[str]:
    return [*__all__]
