"""Summary of a run, as JSON."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import InputError
from skinfield.files.pending import write_bytes


def write_summary(path: str | Path, summary: Mapping[str, Any]) -> None:
    """Write numbers, texts, lists and arrays under their names; NaN and infinities become null.

    Raises
    ------
    InputError
        If a value is none of these.
    FileError
        If the file cannot be written.
    """
    text = json.dumps(plain_json(summary, "summary"), indent=2, ensure_ascii=False, allow_nan=False)
    write_bytes(path, (text + "\n").encode())


def plain_json(value: Any, name: str) -> Any:
    """The value in types that JSON knows; NaN and infinities become None.

    Raises
    ------
    InputError
        If it is no number, text, list, array or mapping; `name` is what the error calls it.
    """
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, np.ndarray | np.generic):
        return plain_json(value.tolist(), name)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain_json(item, f"{name}[{key!r}]") for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain_json(item, f"{name}[{k}]") for k, item in enumerate(value)]
    raise InputError(f"{name} is {value!r}, expected a number, text, list, array or mapping")
