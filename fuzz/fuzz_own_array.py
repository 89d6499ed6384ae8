"""Own arrays: any bytes are positions, or a picture of them, a log by its columns, or refused."""

import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np

from skinfield.errors import FileError, InputError
from skinfield.files.layouts.positions import positions_in_picture, read_positions
from skinfield.files.recordings.columns import (
    guess_columns,
    guess_load_cell,
    guess_time,
    read_table,
    time_unit_of,
)
from skinfield.files.recordings.head import read_head
from skinfield.files.recordings.open import collected, stream_recording
from skinfield.skin.log import LogSettings

SEEDS = [
    b"id,px_mm,py_mm\nch0,-2.0,0\nch1,2.0,0\nch2,2,4\n",
    b"id;x;y;nx;ny;nz\n0;0,5;0;0;0;1\n1;4,5;0;0;0;1\n",
    b"# made today\n# t,ch0,ch1\n0,2001,1999\n10,2002,2000\n20,2003,2000\n",
    b"t;ch0;ch1;state\n0,5;2001;1999;ok\n10,5;2002,5;2000;ok\n20,5;2003;;a b\n",
    b"P5 2 2 255\n\0\xff\xff\0",
    b"t [ms],ch0,ch1,force_N\n0,2001,1999,0.1\n10,2002,2000,nan\n20,,1,2\n",
]
FOLDER = Path(tempfile.mkdtemp(prefix="fuzz-"))


def one_input(data: bytes) -> None:
    """Read it as positions, and as a log with the columns that are guessed."""
    file = FOLDER / "table.csv"
    file.write_bytes(data)
    with suppress(FileError, InputError):
        found = read_positions(file)
        assert found.positions.shape == (len(found.positions), 3)
        assert np.isfinite(found.positions).all()
        assert len(found.names) in (0, len(found.positions))
    with suppress(FileError, InputError):
        assert np.isfinite(positions_in_picture(file, 5e-3).positions).all()
    with suppress(FileError, InputError):
        table = read_table(read_head(file))
        time, cell = guess_time(table), guess_load_cell(table)
        pattern = guess_columns(table, (time, cell))
        if pattern is None:
            return
        columns = table.columns([pattern], (time, cell))
        unit = "s" if time is None else time_unit_of(time, table.numbers(time))[0]
        rate = 100.0 if time is None else None
        log = LogSettings(
            time=time, time_unit=unit, rate_hz=rate, columns=columns, load_cell=cell
        )  # fmt: skip
        read = stream_recording(file, log=log)
        assert collected(read).counts.shape[1] == len(columns)  # type: ignore[arg-type]
