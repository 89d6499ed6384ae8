"""Messages to the page that hold arrays: a head in JSON, and the numbers as they are."""

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAGIC = b"SKF1"
VERSION = 1
PREFIX = struct.Struct("<4sI")
TYPES = {"u1": "u8", "u2": "u16", "u4": "u32", "f4": "f32"}
STEP = 4  # bytes: where an array may begin in the payload
Array = NDArray[Any]


def packed(head: dict[str, Any], arrays: Sequence[tuple[str, Array]] = ()) -> bytes:
    """A binary message: magic, size of the head, head, arrays.

    The payload begins at a multiple of 8 bytes, each array in it at a multiple of 4, so that the
    page reads them where they are.

    Parameters
    ----------
    head : dict
        Plain values; `arrays` is added: name, type, place in the payload and length of each.
    arrays : sequence of (name, array)
        Of 8, 16 or 32 bit unsigned numbers, or float32.
    """
    entries, parts, at = [], [], 0
    for name, array in arrays:
        data = np.ascontiguousarray(array).tobytes()
        kind = TYPES[array.dtype.str[1:]]
        entries.append({"name": name, "type": kind, "at": at, "length": int(array.size)})
        pad = -len(data) % STEP
        parts.append(data + b"\0" * pad)
        at += len(data) + pad
    text = json.dumps({**head, "arrays": entries}, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-(PREFIX.size + len(text)) % 8)
    return b"".join([PREFIX.pack(MAGIC, len(text)), text, *parts])


def scaled(values: Array, low: float, high: float) -> Array:
    """Values as 16 bits between two bounds; those beyond them as the nearer one, NaN as 0."""
    span = high - low
    if span <= 0.0:
        return np.zeros(values.shape, np.uint16)
    return np.asarray(
        np.nan_to_num((values - low) * (65535.0 / span)).clip(0, 65535).round(), np.uint16
    )
