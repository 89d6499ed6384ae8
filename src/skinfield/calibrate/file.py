"""Calibration files of every kind: what `skinfield calibrate` writes, and what all doors read."""

from dataclasses import fields
from pathlib import Path
from typing import Any, get_args

import numpy as np

from skinfield.calibrate.by_force import ForceCalibration
from skinfield.calibrate.by_pressure import PressureCalibration
from skinfield.calibrate.by_touch import TouchCalibration
from skinfield.errors import FileError, InputError
from skinfield.signal import Calibration
from skinfield.signal import calibration as counts
from skinfield.signal.calibration_file import read_file, write_file
from skinfield.skin import Patch

KINDS: dict[str, type[Any]] = {
    "force": ForceCalibration,
    "pressure": PressureCalibration,
    "touch": TouchCalibration,
}
AnyCalibration = Calibration | ForceCalibration | PressureCalibration | TouchCalibration


def save_calibration(calibration: AnyCalibration, path: Path | str) -> None:
    """Write a calibration of any kind to `path`, ``.npz`` or ``.toml`` by its ending.

    Raises
    ------
    FileError
        If the ending is another, or the file cannot be written.
    """
    if isinstance(calibration, Calibration):
        counts.save_calibration(calibration, path)
        return
    kind = next((kind for kind, its in KINDS.items() if type(calibration) is its), None)
    if kind is None:
        raise InputError(f"calibration is {calibration!r:.60}, expected one of skinfield.calibrate")
    write_file(path, kind, _table(calibration), f"calibration by {kind}: {calibration.verdict}")


def load_calibration(path: Path | str, patch: Patch | None = None) -> Any:
    """Read a calibration of any kind; with `patch`, one that must have its taxels.

    Returns
    -------
    Calibration, PressureCalibration, ForceCalibration or TouchCalibration
        By what the file says that it is.

    Raises
    ------
    FileError
        If the file is missing, of another format, version or kind, broken, or of another patch.
    """
    kind, table = read_file(path)
    if kind == counts.KIND:
        return counts.load_calibration(path, patch)
    if kind not in KINDS:
        raise FileError(
            f"{path} is a calibration by {kind!r}, expected counts or {', '.join(KINDS)}: it was "
            "written by another release"
        )
    try:
        made = _made(KINDS[kind], table)
        if patch is not None and len(made) != len(patch):
            raise InputError(f"it has {len(made)} taxels, expected {len(patch)} of {patch.name!r}")
    except (InputError, ValueError, TypeError, OverflowError) as error:
        raise FileError(f"{path} is no calibration by {kind}: {error}") from error
    return made


def _table(calibration: Any) -> dict[str, Any]:
    table = {each.name: getattr(calibration, each.name) for each in fields(calibration)}
    return {
        name: counts.table_from_calibration(value) if isinstance(value, Calibration) else value
        for name, value in table.items()
        if value is not None
    }


def _made(kind: type[Any], table: dict[str, Any]) -> Any:
    known = {each.name: each.type for each in fields(kind)}
    optional = {name for name, its in known.items() if type(None) in get_args(its)}
    missing = [name for name in known if name not in table and name not in optional]
    if missing:
        raise InputError(f"{', '.join(missing)} is missing")
    return kind(**{name: _value(its, table.get(name)) for name, its in known.items()})


def _value(kind: Any, value: Any) -> Any:
    """What a file holds, as a field has it."""
    if value is None:
        return None
    if Calibration in get_args(kind):
        if not isinstance(value, dict):
            raise InputError("counts is no table, expected one of a calibration of counts")
        return counts.calibration_from_table(value)
    if float in get_args(kind):
        kind = float
    if kind in (float, int, bool, str):
        return kind(np.asarray(value).item())
    if kind == tuple[str, ...]:
        return tuple(map(str, value))
    return np.array(value, np.float64)
