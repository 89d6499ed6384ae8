"""Flat tables of results in files: one mapping per row, the unit in each key's name."""

import csv
import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from skinfield.sinks import write_summary
from skinfield.sinks.pending import write_bytes

Row = dict[str, Any]


def write_csv(rows: Sequence[Row], path: str | Path) -> None:
    """Write rows under the keys of all of them, whole or not at all; NaN and None stay empty.

    Raises
    ------
    FileError
        If the file cannot be written.
    """
    keys = list(dict.fromkeys(key for row in rows for key in row))
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, keys, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({key: _shown(value) for key, value in row.items()})
    write_bytes(path, buffer.getvalue().encode())


def write_json(rows: Sequence[Row], path: str | Path, **about: Any) -> None:
    """Write rows as a list under "rows", beside what else is said; NaN becomes null.

    Raises
    ------
    FileError
        If the file cannot be written.
    """
    write_summary(path, {**about, "rows": list(rows)})


def _shown(value: Any) -> Any:
    if isinstance(value, float):
        return f"{value:.6g}" if math.isfinite(value) else ""
    return "" if value is None else value
