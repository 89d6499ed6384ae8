"""Arguments are checked here and nowhere else: name, what came, what was expected, why."""

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from operator import index
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class SkinfieldError(Exception):
    """Base of every error that skinfield raises on purpose."""


class InputError(SkinfieldError, ValueError):
    """A value that cannot be used: the message holds name, value, expectation and remedy."""


class FileError(InputError):
    """A file that cannot be used: the message holds file, line where known, and expectation."""


def check_positive(name: str, value: float, why: str) -> None:
    """Raise InputError unless `value` is finite and greater than zero."""
    if isinstance(value, bool | np.bool_) or not _holds(lambda: 0.0 < value < float("inf")):
        raise InputError(f"{name} is {value!r}, expected a finite number above 0: {why}")


def check_range(name: str, value: float, low: float, high: float, why: str) -> None:
    """Raise InputError unless `low` <= `value` <= `high`."""
    if not _holds(lambda: low <= value <= high):
        raise InputError(f"{name} is {value!r}, expected a number from {low:g} to {high:g}: {why}")


def _holds(comparison: Callable[[], bool]) -> bool:
    """Whether so; not where a value has no order, as None and text have none."""
    try:
        return bool(comparison())
    except (TypeError, ValueError):
        return False


def check_count(name: str, value: int, low: int, high: int, why: str) -> None:
    """Raise InputError unless `value` is a whole number and `low` <= `value` <= `high`."""
    try:
        good = low <= index(value) <= high and not isinstance(value, bool | np.bool_)
    except TypeError:
        good = False
    if not good:
        raise InputError(
            f"{name} is {_short(value)}, expected a whole number from {low} to {high}: {why}"
        )


def check_type(name: str, value: object, kind: type | tuple[type, ...], why: str) -> None:
    """Raise InputError unless `value` is a `kind`, or one of them; `why` says what to hand in."""
    if not isinstance(value, kind):
        kinds = " or ".join(map(_a, kind if isinstance(kind, tuple) else (kind,)))
        raise InputError(f"{name} is {_short(value)}, expected {kinds}: {why}")


@contextmanager
def needs(package: str, install: str, what: str) -> Iterator[None]:
    """Context of an import of a package that may be missing; InputError then says how to get it.

    Parameters
    ----------
    package : str
        That is imported inside.
    install : str
        What pip is to install for it, such as "skinfield[plot]".
    what : str
        That needs it, in the plural: "figures".
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != package:
            raise
        raise InputError(
            f'{what} need {package}, which is not installed: pip install "{install}"'
        ) from error


def check_offers(name: str, value: object, members: Iterable[str], why: str) -> None:
    """Raise InputError unless `value` is an object with all `members`; `why` says which to take.

    For what any class may be: solvers, quantities, models of the elastomer. Of a string the
    message names the class in `why` that is nearest.
    """
    if isinstance(value, str):
        known = re.findall(r"\w+(?=\(\))", why)
        close = {each.lower(): each for each in known}
        word = re.sub(r"\W|_", "", value).lower()
        found = next((each for each in close if word and each.startswith(word)), None)
        found = found or next(iter(get_close_matches(word, list(close), n=1)), None)
        one = f"sf.{close[found]}()" if found else why
        raise InputError(f"{name} is {value!r}, a string; hand in an object: {one}")
    if isinstance(value, type):
        raise InputError(
            f"{name} is the class {value.__name__}, expected an object: give {value.__name__}()"
        )
    missing = [member for member in members if not hasattr(value, member)]
    if missing:
        raise InputError(f"{name} is {_short(value)}, which has no {missing[0]}, expected {why}")


def _short(value: object) -> str:
    """A value on one line that can be read."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 80 else f"{text[:77]}..."


def _a(kind: type) -> str:
    return f"{'an' if kind.__name__[0] in 'AEIOUaeiou' else 'a'} {kind.__name__}"


def check_shape(name: str, array: NDArray[Any], shape: tuple[int | None, ...], why: str) -> None:
    """Raise InputError unless `array` has `shape`, where None stands for any length."""
    fits = array.ndim == len(shape) and all(
        want is None or n == want for n, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        pattern = "(" + ", ".join("any" if n is None else str(n) for n in shape) + ")"
        raise InputError(f"{name} has shape {array.shape}, expected {pattern}: {why}")


def check_finite(name: str, array: Floats, why: str) -> None:
    """Raise InputError, naming the first offender, if `array` holds a NaN or an infinity."""
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        where = tuple(int(i) for i in bad[0])
        index = where[0] if len(where) == 1 else where
        raise InputError(
            f"{name}[{index}] is {array[where]}, expected finite numbers "
            f"({len(bad)} of {array.size} are not): {why}"
        )


def check_choice(name: str, value: str, choices: Iterable[str], why: str) -> None:
    """Raise InputError unless `value` is one of `choices`."""
    known = sorted(choices)
    if value not in known:
        raise InputError(f"{name} is {value!r}, expected one of {', '.join(known)}: {why}")


def as_floats(name: str, values: ArrayLike) -> Floats:
    """Convert to a float64 array, or raise InputError that names the argument.

    What a masked array hides becomes NaN.
    """
    try:
        if values is None:  # which NumPy takes for NaN
            raise TypeError("nothing was handed in")
        if np.iscomplexobj(values):
            raise TypeError("complex numbers have no order")
        if isinstance(values, np.ma.MaskedArray):
            return np.asarray(np.ma.filled(values.astype(np.float64), np.nan))
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        why = "hand in its .counts" if hasattr(values, "counts") else error  # of a recording
        raise InputError(f"{name} is {values!r:.80}, expected numbers: {why}") from error


def as_stamps(name: str, values: ArrayLike) -> Ints:
    """Convert to int64, or raise InputError that names the argument."""
    try:
        return np.asarray(values, dtype=np.int64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name} is {values!r:.80}, expected whole nanoseconds") from error
