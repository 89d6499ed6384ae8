"""Calibrations on disk: NPZ for programs, TOML for people."""

import struct
import tomllib
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.conditioning.calibration import Calibration
from skinfield.errors import FileError, InputError
from skinfield.layout import Patch

FORMAT = "skinfield-calibration"
VERSION = 1
_COLUMNS = ("baseline", "gain", "noise_std", "alive", "uid")
_TEXTS = ("patch_name", "unit", "basis")
_BROKEN_NPZ = (  # what zipfile, zlib and NumPy's header reader raise on garbage
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    RuntimeError,
    SyntaxError,
    TypeError,
    ValueError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
)


def save_calibration(calibration: Calibration, path: Path | str) -> None:
    """Write `calibration` to `path`, ``.npz`` or ``.toml`` by its ending.

    Raises
    ------
    FileError
        If the ending is another, or the file cannot be written.
    """
    path = Path(path)
    try:
        if _ending(path) == ".npz":
            columns = {name: getattr(calibration, name) for name in (*_COLUMNS, *_TEXTS)}
            with path.open("wb") as file:
                np.savez(file, format=FORMAT, version=VERSION, **columns)
        else:
            path.write_text(_toml_from_calibration(calibration), encoding="utf-8")
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror or error}") from error


def load_calibration(path: Path | str, patch: Patch | None = None) -> Calibration:
    """Read a calibration; with `patch`, one that must be that patch's, by uid.

    Raises
    ------
    FileError
        If the file is missing, of another format or version, broken, or of another patch.
    """
    path = Path(path)
    read = _read_npz if _ending(path) == ".npz" else _read_toml
    try:
        content = read(path)
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror or error}") from error
    _check_head(path, content)
    missing = [name for name in (*_COLUMNS, *_TEXTS) if name not in content]
    if missing:
        raise FileError(f"{path} lacks {', '.join(missing)}: expected as save_calibration writes")
    try:
        columns = {name: _column(name, content[name]) for name in _COLUMNS}
        patch_name, unit, basis = (str(content[name]) for name in _TEXTS)
        calibration = Calibration(**columns, patch_name=patch_name, unit=unit, basis=basis)
        if patch is not None:
            calibration.check_patch(patch)
    except (InputError, ValueError, TypeError, OverflowError) as error:
        raise FileError(f"{path}: {error}") from error
    return calibration


def _ending(path: Path) -> str:
    if path.suffix not in (".npz", ".toml"):
        raise FileError(f"{path} ends in {path.suffix!r}, expected .npz or .toml")
    return path.suffix


def _check_head(path: Path, content: Mapping[str, Any]) -> None:
    if str(content.get("format")) != FORMAT:
        raise FileError(
            f"{path} has format {str(content.get('format'))[:40]!r}, expected {FORMAT!r}: "
            "this is not a calibration"
        )
    if str(content.get("version")) != str(VERSION):
        raise FileError(
            f"{path} has version {str(content.get('version'))[:40]}, expected {VERSION}: "
            "it was written by another release"
        )


def _column(name: str, values: Any) -> Any:
    if name == "uid":
        # hexadecimal text, as TOML's integers end at 63 bits
        return np.array([_uid(value) for value in np.asarray(values).tolist()], dtype=np.uint64)
    array = np.asarray(values)
    wanted = "b" if name == "alive" else "if"
    if array.dtype.kind not in wanted:
        raise InputError(
            f"{name} holds {str(values)[:40]}, expected "
            f"{'true or false' if name == 'alive' else 'numbers'}, one per taxel"
        )
    return array


def _uid(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int | str):
        raise InputError(f"uid holds {value!r}, expected whole numbers or hexadecimal text")
    return int(value, 16) if isinstance(value, str) else value


def _read_npz(path: Path) -> Mapping[str, Any]:
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except _BROKEN_NPZ as error:
        raise FileError(f"{path} is not an NPZ file that can be read: {error}") from error


def _read_toml(path: Path) -> Mapping[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise FileError(f"{path} is not TOML: {error}") from error


def _toml_from_calibration(calibration: Calibration) -> str:
    lines = [f'format = "{FORMAT}"', f"version = {VERSION}"]
    lines += [f"{name} = {_toml_text(getattr(calibration, name))}" for name in _TEXTS]
    lines += ["", "# counts = baseline + gain * relative change of capacitance; a row per taxel"]
    for name in ("baseline", "gain", "noise_std"):
        lines.append(_toml_list(name, [repr(float(v)) for v in getattr(calibration, name)]))
    lines.append(_toml_list("alive", ["true" if v else "false" for v in calibration.alive]))
    lines.append(_toml_list("uid", [f'"{int(v):#x}"' for v in calibration.uid]))
    return "\n".join(lines) + "\n"


def _toml_list(name: str, items: list[str]) -> str:
    rows = (", ".join(items[i : i + 12]) for i in range(0, len(items), 12))
    return f"{name} = [\n  " + ",\n  ".join(rows) + ",\n]"


def _toml_text(text: str) -> str:
    """Basic string of TOML: quotes, backslashes and control characters escaped."""
    safe = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c >= " " and c != "\x7f" else f"\\u{ord(c):04x}" for c in safe) + '"'
