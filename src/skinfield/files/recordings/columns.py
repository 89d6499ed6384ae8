"""Which columns of a file are wanted."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError


def chosen(columns: Sequence[int | str] | None, width: int, path: Path) -> NDArray[np.int64]:
    """Rows of the chosen value columns, all of them for None.

    Raises
    ------
    InputError
        If a column is chosen that is not there.
    """
    if columns is None:
        return np.arange(width)
    for column in columns:
        if isinstance(column, str) or not 0 <= int(column) < width:
            raise InputError(
                f"columns holds {column!r}, expected whole numbers from 0 to {width - 1}: "
                f"{path} has {width} columns of values without names"
            )
    if not len(columns):
        raise InputError("columns is empty, expected one column or more: leave it out for all")
    return np.array([int(column) for column in columns], np.int64)
