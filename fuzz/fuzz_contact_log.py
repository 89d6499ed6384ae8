"""Contact lists: any bytes are a log of them, followed, or refused; a bottle's text comes back."""

import tempfile
from contextlib import suppress
from pathlib import Path

import skinfield as sf
from skinfield.errors import FileError, InputError
from skinfield.wire.yarp import open_contact_log, text_from_bottle, values_from_text
from skinfield.wire.yarp.carriers import from_octets

PLACE = "(0.01 0.07 -0.03) (-0.5 0.1 0.75) (0.0 0.0 0.0) (0.011 0.07 -0.031)"
ONE = f"((70000 4 4 5) {PLACE} (0.5 -0.1 -0.75) (30 31) 9.5)"
SEEDS = [
    f"500 1700000000.250000 \n501 1700000000.270 {ONE}\n501 1700000000.270 {ONE}\n".encode(),
    f"1 2.5 2.6 ({ONE} {ONE})\r\n2 2.6 2.7 ()\n3 2.7 2.8 {ONE.replace('4 4 5', '0 -1 0')}".encode(),
    b'("a b" 1 [2.5] (nan -inf 1e400)) \\" word',
]
FILE = Path(tempfile.mkdtemp(prefix="fuzz-")) / "data.log"


def one_input(data: bytes) -> None:
    """Read and follow it; read it as a bottle, and what is written of that again."""
    FILE.write_bytes(data)
    tracker = sf.Tracker.for_lists()
    with suppress(FileError):
        before = -1
        for reading in open_contact_log(FILE).readings():
            assert reading.stamp_ns > before
            before = reading.stamp_ns
            found = [each for each in tracker(reading) if not each.is_coasting]
            assert len(found) == min(len(reading.contacts), 128)
    with suppress(InputError):
        values = values_from_text(from_octets(data))
        again = text_from_bottle(values)
        assert text_from_bottle(values_from_text(again)) == again
