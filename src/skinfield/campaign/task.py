"""What is to be done, and the hash that tells whether it has been done."""

import hashlib
import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from pathlib import PurePath
from typing import Any

import numpy as np

from skinfield.errors import InputError

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+=,-]{0,119}", re.ASCII)


@dataclass(frozen=True)
class Task:
    """A function and its arguments.

    Parameters
    ----------
    name : str
        Of its folder: letters, digits and ``._+=,-``.
    function : callable
        ``function(folder, *arguments)`` of the module level; returns what JSON can hold, or None.
    arguments : tuple
        Of what `fingerprint` knows.
    version : str
        Another one makes earlier results void.
    """

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    version: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not NAME.fullmatch(self.name):
            raise InputError(
                f"name is {self.name!r}, expected up to 120 letters, digits and ._+=,- that begin "
                "with a letter or digit: it becomes the name of a folder"
            )
        if "<" in _qualified(self.function):
            raise InputError(
                f"function of {self.name} is {_qualified(self.function)}, expected one of the "
                "module level: other processes must be able to import it"
            )

    @property
    def fingerprint(self) -> str:
        """Of function, arguments and version; the name is not in it."""
        return fingerprint((_qualified(self.function), self.arguments, self.version))


def fingerprint(value: Any) -> str:
    """Hash of a value that is the same in every process, 32 hexadecimal digits.

    Parameters
    ----------
    value : object
        Of None, bool, int, float, complex, str, bytes, paths, enums, NumPy arrays and numbers,
        functions and classes (by name), dataclasses, and tuples, lists, sets and mappings of those.

    Raises
    ------
    InputError
        For anything else: what it holds cannot be seen.
    """
    digest = hashlib.blake2b(digest_size=16)
    for part in _parts(value):
        digest.update(len(part).to_bytes(8, "little") + part)
    return digest.hexdigest()


def _qualified(function: Callable[..., Any]) -> str:
    return f"{function.__module__}.{function.__qualname__}"


def _parts(value: Any) -> Iterator[bytes]:
    """The value's types and contents, such that two values differ where their parts do."""
    if isinstance(value, np.generic):
        value = value.item()
    yield type(value).__qualname__.encode()
    if value is None or isinstance(value, bool | int | complex):
        yield repr(value).encode()
    elif isinstance(value, float):
        yield (value.hex() if math.isfinite(value) else repr(value)).encode()
    elif isinstance(value, str):
        yield value.encode("utf-8", "surrogatepass")
    elif isinstance(value, bytes):
        yield value
    elif isinstance(value, Enum | PurePath):
        yield str(value).encode("utf-8", "surrogatepass")
    elif isinstance(value, np.ndarray) and value.dtype != object:
        yield f"{value.dtype.str}{value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            yield field.name.encode()
            yield from _parts(getattr(value, field.name))
    else:
        yield from _parts_of_many(value)


def _parts_of_many(value: Any) -> Iterator[bytes]:
    if isinstance(value, tuple | list):
        yield str(len(value)).encode()
        for item in value:
            yield from _parts(item)
    elif isinstance(value, Mapping):
        yield from sorted(f"{fingerprint(k)}{fingerprint(value[k])}".encode() for k in value)
    elif isinstance(value, set | frozenset):
        yield from sorted(fingerprint(item).encode() for item in value)
    elif callable(value) and hasattr(value, "__qualname__"):
        yield _qualified(value).encode()
    else:
        raise InputError(
            f"an argument is {value!r} of {type(value).__name__}, expected numbers, texts, arrays, "
            "dataclasses, or collections of them: what else it holds cannot be hashed"
        )
