"""Any file: any bytes are a layout, a calibration, a recording or a table of contacts, or refused.

Of what has other targets, what tells the kinds of files; tables of contacts as a whole.
"""

import io
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import SkinfieldError
from skinfield.estimate.contact_table import COLUMNS, LISTED, ContactTable
from skinfield.files import read


def _npz(**arrays: Any) -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)
    return file.getvalue()


HEAD = ",".join(COLUMNS).encode()
ROW = b"1,1000,0.1,0.7,Auto,20,0,0,0,0,0.001,0,0,0.7,0.7,,2e-5,1e4,3e-3,2e-3,0,other,3e-3,newtons"
SEEDS = [
    HEAD + b"\n" + ROW + b"\n",
    b"# by hand\n" + ",".join(LISTED).encode() + b"\n" + ROW + b",7,right_arm,4,r_forearm\n",
    b"# unit = count\ntime_s,taxel_0\n0,1\n1,2\n",
    b"skinfield_layout = 1\n[[patch]]\npositions_mm = [[0, 0], [4, 0]]\n",
    b'format = "skinfield-calibration"\nversion = 1\nkind = "counts"\n',
    b"\x89MCAP0\r\nskinfield_layout = 1\n",
    b"PAR1skinfield",
    _npz(format="skinfield-calibration", version=1, kind="counts"),
    _npz(stamp_ns=[0, 10], counts=[[1.0], [2.0]]),
]
FILE = Path(tempfile.mkdtemp(prefix="fuzz-")) / "any.toml"


def one_input(data: bytes) -> None:
    """Read it; a table of contacts has as many values in each column."""
    FILE.write_bytes(data)
    with suppress(SkinfieldError):
        found = read(FILE)
        if isinstance(found, ContactTable):
            assert {len(values) for values in found.columns.values()} == {len(found)}
