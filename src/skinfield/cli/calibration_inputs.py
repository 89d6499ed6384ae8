"""Recordings and labels of a calibration, side by side: columns, times, units, delay."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, InputError
from skinfield.skin import Patch
from skinfield.skin.log import NS, LogSettings

if TYPE_CHECKING:
    from skinfield.cli.reconstruct_jobs import JobPlan
    from skinfield.elastic import Layer
    from skinfield.files.numbers import Numbers
    from skinfield.reconstruct.diagnostics import Conditioning
    from skinfield.signal import Calibration

UNITS = {  # of labels, by what they are in SI
    "Pa": {"Pa": 1.0, "kPa": 1e3, "bar": 1e5, "mbar": 100.0, "psi": 6894.757, "MPa": 1e6},
    "N": {"N": 1.0, "kN": 1e3, "mN": 1e-3,  # and what standard gravity pulls at a mass with
          "kg": 9.80665, "kgf": 9.80665, "g": 9.80665e-3, "gf": 9.80665e-3,
          "lb": 4.4482216, "lbs": 4.4482216, "lbf": 4.4482216},
}  # fmt: skip
LATE, STEP = 1.0, 0.025  # s: delays that are tried
BETTER = 0.02  # of a correlation, by which a delay must be better than none
CLEAR = 0.6  # correlation, from which on a delay is believed
FEWEST = 50  # rows that both have


class Series(NamedTuple):
    """Numbers (T, C), their seconds (T,) if they have any, and notes."""

    values: Floats
    seconds: Floats | None
    notes: tuple[str, ...] = ()


def skin_series(
    name: str,
    patch: Patch | None,
    time: str | None,
    columns: str | None,
    log: LogSettings | None = None,
) -> Series:
    """Counts (T, L) of a recording; without a patch, of its columns in their order.

    Columns that are not given are those of a skin's file, if it has them.
    """
    from skinfield.files import open_recording
    from skinfield.files.numbers import is_numbers, read_numbers
    from skinfield.files.recordings.matching import readings_for

    inside = is_numbers(name) and not Path(name).exists()  # FILE:NAME
    if not (columns or time or inside or Path(name).suffix.lower() in (".mat", ".npy")):
        recording = open_recording(name, log=log)
        if patch is not None:
            recording = readings_for(recording, patch)
        return Series(recording.counts, recording.stamp_ns / 1e9, recording.notes)
    table = read_numbers(name)
    values = table.columns(columns) if columns else table.values
    if patch is not None and values.shape[1] != len(patch):
        if values.shape[1] != patch.n_channels:
            raise InputError(
                f"{name} has {values.shape[1]} columns, expected {len(patch)}, one per taxel of "
                f"{patch.name!r}, or {patch.n_channels}, its channels: choose them with --columns"
            )
        values = values[:, patch.channel]
    return Series(values, table.time(time))


def factor_of(unit: str | None, si: str, names: Sequence[str]) -> float:
    """From a unit to `si`: as given, else as columns are named, such as p_kPa, else that itself.

    Raises
    ------
    InputError
        If it is a unit of something else, or the columns say another.
    """
    known = UNITS[si]
    if unit is not None and unit not in known:
        raise InputError(f"--unit is {unit!r}, expected one of {', '.join(known)}")
    every = {each for its in UNITS.values() for each in its}
    for name in names:
        bracketed = re.fullmatch(r".*[(\[]\s*([^)\]]+?)\s*[)\]]\s*", name)
        own = bracketed[1] if bracketed else re.split(r"[^A-Za-z]+", name)[-1]
        if bracketed and own not in every and unit is None:
            raise InputError(
                f"column {name!r} is in {own}, expected {', '.join(known)}: name it by one of "
                f"them, such as {name.split()[0].rstrip('([')}_{si}"
            )
        if own != name and own in every and (own not in known or own != (unit or own)):
            raise InputError(
                f"column {name!r} is in {own}, expected {unit or ' or '.join(known)}: give "
                "--unit as it is, and choose columns with --labels"
            )
        if own != name and own in known:
            unit = own
    return known[unit or si]


def label_series(
    name: str,
    labels: str | None,
    unit: str | None,
    si: str,
    offset: str | None = None,
    log: LogSettings | None = None,
) -> Series:
    """Labels (T, N) in `si`, N or Pa: of a force log its fx, fy and fz, else of columns by name.

    Times of a log of the skin's own are those of `log`, and its load cell's column is the label.
    `offset` is what their sensor reads without load, in their unit, to be taken off.
    """
    from skinfield.files import open_recording
    from skinfield.files.numbers import is_numbers, read_numbers

    factor = factor_of(unit, si, ())  # refuses what it must before files are read
    if labels is None:
        try:
            sensor = open_recording(name)
        except (FileError, InputError):
            sensor = None  # then it is a table
        if sensor is not None and sensor.unit == "N, N m":
            if si != "N":
                raise InputError(f"{name} is of a force sensor, expected pressures, in Pa")
            values = _without(name, sensor.counts[:, :3], offset)
            return Series(values * factor, sensor.stamp_ns / 1e9, sensor.notes)
        if not is_numbers(name):
            open_recording(name)  # says what is wrong with it
            raise InputError(f"{name} is of a skin, expected labels: the skin's recording is first")
    table = read_numbers(name)
    seconds = _seconds(table, log)
    if labels is None and log is not None and log.load_cell in table.names:
        labels = log.load_cell
    if labels is None:
        chosen = [column for column in table.numeric if not _is_time(column)]
        labels = ",".join(chosen)
    factor = factor_of(unit, si, table.names_of(labels))
    return Series(_without(name, table.columns(labels), offset) * factor, seconds)


def _seconds(table: "Numbers", log: LogSettings | None) -> Floats | None:
    """Times (T,) of a table, s: as a skin's file has them, if it is a log of that skin."""
    if log is not None and log.columns:
        if log.time in table.names:
            return table.column(log.time) * (NS[log.time_unit] * 1e-9)
        if log.rate_hz is not None and log.load_cell in table.names:
            return np.arange(len(table.values)) / log.rate_hz
    return table.time()


def _without(name: str, values: Floats, offset: str | None) -> Floats:
    """Labels (T, N) in their unit, less what their sensor reads without load."""
    if offset is None:
        return values
    width = values.shape[1]
    try:
        taken = [float(each) for each in offset.split(",")]
    except ValueError:
        taken = []
    if len(taken) != width or not np.isfinite(taken).all():
        raise InputError(
            f"--offset is {offset!r}, expected {width} number{'s' * (width > 1)} in the unit "
            f"of the labels, one per column of {name}, such as {','.join(['1.5'] * width)}"
        )
    return values - taken


def forces_of(name: str, values: Floats) -> Floats:
    """Labels (T, N) as forces (T,) or (T, 3)."""
    width = values.shape[1]
    if width not in (1, 3):
        raise InputError(
            f"{name} has {width} columns of labels, expected one force or three axes: choose them "
            "with --labels"
        )
    return values if width == 3 else values[:, 0]


def forces_together(
    files: Sequence[str],
    patch: Patch,
    *,
    time: str | None,
    columns: str | None,
    labels: str | None,
    unit: str | None,
    offset: str | None,
    log: LogSettings | None = None,
) -> tuple[Floats, Floats, tuple[str, ...]]:
    """Counts (T, L) and forces (T,) or (T, 3) of recordings one after another, and notes.

    `files` are a recording, its labels, another, its labels, and so on.
    """
    from skinfield.calibrate import force

    if len(files) % 2:
        raise InputError(f"{files[-1]} has no labels, expected RECORDING LABELS in pairs")
    tables, forces, notes, signs = [], [], [], set()
    for recording, its in zip(files[::2], files[1::2], strict=True):
        label = label_series(its, labels, unit, "N", offset, log)
        forces_of(its, label.values)  # refuses what it must before the skin is read
        counts, values, said = together(skin_series(recording, patch, time, columns, log), label)
        tables.append(counts)
        forces.append(forces_of(its, values))
        if len(files) > 2:
            try:
                made = force(patch, counts, forces[-1])
            except InputError as error:  # a dead sensor hides among others
                raise InputError(f"{its}: {error}") from error
            signs |= {made.sign} if made.sign_is_sure else set()
            if len(signs) > 1:
                raise InputError(
                    f"{its} goes the other way than the labels before it as the skin is pressed, "
                    "expected labels of one sign: turn those of the file"
                )
        notes += [f"{its}: {note}" if len(files) > 2 else note for note in said]
    if len({force.ndim for force in forces}) > 1:
        raise InputError(f"labels {', '.join(files[1::2])} have one axis and three, expected alike")
    return np.concatenate(tables), np.concatenate(forces), tuple(notes)


def _is_time(name: str) -> bool:
    from skinfield.files.numbers import TIMES

    return name in TIMES


def together(skin: Series, label: Series) -> tuple[Floats, Floats, tuple[str, ...]]:
    """Counts (T, L) and labels (T, N) of the same instants, and what was done to that end.

    Raises
    ------
    InputError
        If they have too little in common.
    """
    counts, values, notes = skin.values, label.values, skin.notes + label.notes
    if skin.seconds is None or label.seconds is None:
        rows = min(len(counts), len(values))
        if len(counts) != len(values):
            notes += (
                f"{len(counts)} readings and {len(values)} labels, without common times: taken "
                f"as begun together, the first {rows} of both",
            )
        counts, values = counts[:rows], values[:rows]
    else:
        late = delay_of(skin, label)
        if late:
            notes += (f"labels are {late * 1e3:+.0f} ms late: taken back",)
        at = skin.seconds + late
        inside = (at >= label.seconds[0]) & (at <= label.seconds[-1])
        counts = counts[inside]
        values = np.column_stack([np.interp(at[inside], label.seconds, v) for v in values.T])
    if len(counts) < FEWEST:
        raise InputError(
            f"recording and labels have {len(counts)} readings in common, expected {FEWEST} or "
            "more: are both of one experiment, by one clock?"
        )
    return counts, values, notes


def delay_of(skin: Series, label: Series) -> float:
    """How late labels are, s: where they follow the sum of counts best, if clearly so."""
    assert skin.seconds is not None
    assert label.seconds is not None
    rest = np.nan_to_num(np.nanmedian(skin.values, axis=0))
    load = np.nan_to_num(skin.values - rest).sum(axis=1)
    strongest = int(np.argmax(np.nanvar(label.values, axis=0)))
    best, late, usual = -1.0, 0.0, -1.0
    delays = np.arange(-LATE, LATE + STEP / 2.0, STEP)
    for delay in sorted(delays, key=abs):
        at = skin.seconds + delay
        inside = (at >= label.seconds[0]) & (at <= label.seconds[-1])
        if inside.sum() < FEWEST:
            continue
        wanted = np.interp(at[inside], label.seconds, label.values[:, strongest])
        if not (np.ptp(wanted) > 0.0 and np.ptp(load[inside]) > 0.0):
            continue
        follows = abs(float(np.corrcoef(load[inside], wanted)[0, 1]))
        usual = follows if usual < 0.0 else usual
        if follows > best:
            best, late = follows, float(delay)
    within = abs(late) < LATE - STEP / 2.0  # one at the end of what was tried is none
    return late if within and best > max(usual + BETTER, CLEAR) else 0.0


class TouchReadings(NamedTuple):
    """Readings (T, L) above the rest of their recording, and notes.

    And their stamps (T,), ns; of the first recording how many there are, its rest (L,), and the
    calibration of counts, if any.
    """

    readings: Floats
    notes: tuple[str, ...]
    stamps: NDArray[np.int64]
    first: int
    rest: Floats
    calibration: "Calibration | None"


def presses_in(
    recordings: tuple[str, ...], plan: "JobPlan", layer: "Layer", how: "Conditioning"
) -> TouchReadings:
    """Presses of all recordings, one after the other.

    Raises
    ------
    InputError
        If there is no recording, or one that does not go with the skin.
    """
    from skinfield.calibrate.touch_presses import between, noise_of_differences
    from skinfield.elastic import Capacitance
    from skinfield.files import open_recording
    from skinfield.files.recordings.matching import readings_for
    from skinfield.reconstruct.diagnostics import condition

    if not recordings:
        raise InputError("RECORDING is missing, expected one or more of presses")
    found = [readings_for(open_recording(each, log=plan.log), plan.patch) for each in recordings]
    every = [condition(each, plan.patch, layer, Capacitance(), how) for each in found]
    readings, each = np.concatenate([values for values, _ in every]), how.noise_std
    noise = noise_of_differences(readings) if each is None else np.full(len(plan.patch), each)
    rests = [between(values, noise) for values, _ in every]
    readings -= np.repeat(rests, [len(values) for values, _ in every], axis=0)
    notes = tuple(dict.fromkeys(note for _, survey in every for note in survey.notes))
    calibration = every[0][1].conditioner.calibration
    stamps = np.concatenate([each.stamp_ns for each in found])
    return TouchReadings(readings, notes, stamps, len(found[0].stamp_ns), rests[0], calibration)
