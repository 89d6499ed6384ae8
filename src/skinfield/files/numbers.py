"""Tables of numbers by any column names: CSV, MATLAB, HDF5 and NumPy files of labels and readings.

force.csv                              columns by the line of names above them
trial.mat, trial.mat:experiment.C      the one matrix in it, or that of a name; any version
trial.h5:experiment.C                  a dataset C of the group experiment
pokes.npz:normal_force_n               an array of a name; force.npy
"""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, InputError

TIMES = {"time_s": 1.0, "t": 1.0, "time": 1.0, "stamp_ns": 1e-9, "time_ms": 1e-3}  # s
ENDINGS = (".csv", ".txt", ".mat", ".h5", ".hdf5", ".npz", ".npy")
SHOWN = 6  # names in a message


@dataclass(frozen=True, eq=False)
class Numbers:
    """Columns of numbers.

    Attributes
    ----------
    names : tuple of str
        Of the columns; their numbers, from 1, where the file names none.
    values : (T, C) array
        NaN where a place is empty.
    source : str
    texts : tuple of str
        Names of columns that hold words, and no numbers: NaN.
    """

    names: tuple[str, ...]
    values: Floats
    source: str
    texts: tuple[str, ...] = ()

    def column(self, wanted: str) -> Floats:
        """Values (T,) of a column by its name, or by its number from 1.

        Raises
        ------
        InputError
            If there is none.
        """
        return self.values[:, self._place(wanted)]

    def _place(self, wanted: str) -> int:
        if wanted in self.texts:
            raise InputError(f"column {wanted!r} of {self.source} holds words, expected numbers")
        if wanted in self.names:
            return self.names.index(wanted)
        if wanted.isdecimal() and 1 <= int(wanted) <= len(self.names):
            return int(wanted) - 1
        known = ", ".join(self.names[:SHOWN]) + (", ..." if len(self.names) > SHOWN else "")
        raise InputError(
            f"column {wanted!r} is not in {self.source}, expected one of its {len(self.names)}: "
            f"{known}"
        )

    def columns(self, wanted: str) -> Floats:
        """Values (T, N) of columns such as "force_z", "fx,fy,fz" or "3-282"."""
        return self.values[:, self._places(wanted)]

    def names_of(self, wanted: str) -> list[str]:
        """Names of such columns."""
        return [self.names[place] for place in self._places(wanted)]

    @property
    def numeric(self) -> tuple[str, ...]:
        """Names of the columns that hold numbers."""
        return tuple(name for name in self.names if name not in self.texts)

    def _places(self, wanted: str) -> list[int]:
        found: list[int] = []
        for each in wanted.split(","):
            first, dash, last = each.partition("-")
            if dash and first.isdecimal() and (last.isdecimal() or not last):
                end = int(last) if last else len(self.names)
                found += [self._place(str(number)) for number in range(int(first), end + 1)]
            else:
                found.append(self._place(each.strip()))
        return found

    def time(self, wanted: str | None = None) -> Floats | None:
        """Seconds (T,) of a column, or of the one that is named like a time; None without any.

        Raises
        ------
        InputError
            If the column is none, or its times do not rise as those of a skin do.
        """
        name = wanted or next((name for name in self.names if name in TIMES), None)
        if name is None:
            return None
        seconds = self.column(name) * TIMES.get(name, 1.0)
        step = float(np.nanmedian(np.diff(seconds))) if len(seconds) > 1 else 1e-2
        if not 1e-5 <= step <= 10.0:
            raise InputError(
                f"column {name!r} of {self.source} goes on by {step:g} from row to row, expected "
                "seconds of a sensor, 0.00001 to 10 s: are they milliseconds? name it time_ms"
            )
        return seconds


def delimiter_of(line: str) -> tuple[str | None, str]:
    """Delimiter of a table and its decimal sign, told by a line of numbers; None is any space.

    A comma beside semicolons or tabs is a decimal one, as spreadsheets of many countries write.
    """
    delimiter = next((each for each in (";", "\t", ",") if each in line), None)
    return delimiter, "," if delimiter in (";", "\t") and "," in line else "."


def is_numbers(text: str) -> bool:
    """Whether a file's name is one of `read_numbers`."""
    return Path(_parted(text)[0]).suffix.lower() in ENDINGS


def read_numbers(text: str) -> Numbers:
    """Read a table of numbers; see above for how files and what is in them are named.

    Raises
    ------
    FileError
        If it cannot be read, or holds no table of numbers.
    """
    name, inside = _parted(text)
    path = Path(name)
    kind = path.suffix.lower()
    if kind not in ENDINGS:
        raise FileError(f"{name} ends in {kind!r}, expected one of {', '.join(ENDINGS)}")
    try:
        if kind in (".csv", ".txt"):
            return _of_text(path)
        values = _of_arrays(_arrays(path, kind), inside, name)
    except FileError:
        raise
    except OSError as error:
        why = error.strerror or error
        raise FileError(f"{name} cannot be read: {why}; expected a table of numbers") from error
    except Exception as error:  # SciPy, NumPy and zipfile raise all kinds on garbage
        raise FileError(f"{name} holds no numbers that can be read: {error}") from error
    return Numbers(tuple(str(k + 1) for k in range(values.shape[1])), values, text)


def _parted(text: str) -> tuple[str, str]:
    """A file's name, and the name of what is in it."""
    head, colon, inside = text.rpartition(":")
    return (head, inside) if colon and Path(head).suffix.lower() in ENDINGS else (text, "")


def _of_text(path: Path) -> Numbers:
    every = [line for line in path.read_text("utf-8-sig").splitlines() if line.strip()]
    lines = [line for line in every if not line.lstrip().startswith(("#", "%"))]
    if not lines:
        raise FileError(f"{path} is empty, expected a line of names above lines of numbers")
    delimiter, decimal = delimiter_of(lines[-1])
    rows = list(csv.reader(lines, delimiter=delimiter)) if delimiter else [r.split() for r in lines]
    head = [each.strip() for each in rows[0]]
    rows = [[each.replace(decimal, ".") for each in row] for row in rows]
    named = not all(map(_is_number, rows[0]))
    above = every[every.index(lines[0]) - 1] if every[0] != lines[0] else ""
    said = tuple(each.strip() for each in above.lstrip("#% ").split(delimiter))  # as NumPy writes
    unnamed = said if len(said) == len(head) else tuple(str(k + 1) for k in range(len(head)))
    names = tuple(head) if named else unnamed
    if len(rows) == named:
        raise FileError(f"{path} holds a line of names only, expected lines of numbers below it")
    words = {k for k, each in enumerate(rows[named]) if each.strip() and not _is_number(each)}
    values = np.full((len(rows) - named, len(names)), np.nan)
    for place, row in enumerate(rows[named:]):
        if len(row) != len(names):
            raise FileError(
                f"{path}: row {place + 1} has {len(row)} values, expected {len(names)} as its "
                "first line"
            )
        for column, each in enumerate(row):
            if column in words:
                continue
            if each.strip() and not _is_number(each):
                raise FileError(f"{path}: row {place + 1} holds {each[:20]!r}, expected a number")
            values[place, column] = float(each) if each.strip() else np.nan
    return Numbers(names, values, str(path), tuple(names[k] for k in sorted(words)))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _arrays(path: Path, kind: str) -> Mapping[str, Any]:
    if kind == ".npy":
        return {"": np.load(path, allow_pickle=False)}
    if kind == ".npz":
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    if kind != ".mat":
        return _of_hdf5(path)
    with path.open("rb") as file:
        head = file.read(516)
    if b"\x89HDF" in (head[:4], head[512:]):  # version 7.3 has a header of 512 bytes before it
        return {name: value.T.squeeze() for name, value in _of_hdf5(path).items()}
    from scipy.io import loadmat

    content = loadmat(path, squeeze_me=True, struct_as_record=False)
    return {name: value for name, value in content.items() if not name.startswith("__")}


def _of_hdf5(path: Path) -> dict[str, NDArray[Any]]:
    """Datasets of numbers by their names, those in groups as group.dataset."""
    try:
        import h5py
    except ImportError as error:
        raise FileError(
            f"{path} is HDF5, which needs h5py: pip install 'skinfield[hdf5]'; or in MATLAB, "
            "save(name, '-v7')"
        ) from error
    found: dict[str, NDArray[Any]] = {}

    def take(name: str, item: Any) -> None:
        text = item.attrs.get("MATLAB_class") == b"char"
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "iufb" and item.ndim and not text:
            found[name.replace("/", ".")] = item[()]

    with h5py.File(path, "r") as file:
        file.visititems(take)
    return found


def _of_arrays(content: Mapping[str, Any], inside: str, name: str) -> Floats:
    """The array of a name, or the only one, as (T, C)."""
    found = _flat(content)
    if inside in found:
        chosen = found[inside]
    elif not inside and len(found) == 1:
        chosen = next(iter(found.values()))
    else:
        known = ", ".join(sorted(found)[:SHOWN])
        raise FileError(
            f"{name} holds {known or 'no array'}, expected "
            + (f"{inside!r} among them" if inside else f"one named so: {name}:NAME")
        )
    return np.array(chosen.reshape(len(chosen), -1), np.float64)


def _flat(content: Mapping[str, Any], before: str = "") -> dict[str, NDArray[Any]]:
    """Arrays of numbers by their names, those in structs as struct.field."""
    found: dict[str, NDArray[Any]] = {}
    for name, value in content.items():
        if hasattr(value, "_fieldnames"):
            fields = {each: getattr(value, each) for each in value._fieldnames}
            found |= _flat(fields, f"{before}{name}.")
        elif isinstance(value, np.ndarray) and value.dtype.kind in "iufb" and value.ndim >= 1:
            found[f"{before}{name}"] = value
    return found
