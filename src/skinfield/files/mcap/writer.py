"""Writer of recordings of a live skin: one MCAP file that holds all that a reader needs."""

import json
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mcap.records import Attachment, Channel, Schema

from skinfield.errors import FileError, InputError, check_count
from skinfield.files.mcap import schema
from skinfield.files.mcap.container import Bytes, Container, FileOutput
from skinfield.files.pending import plain_json
from skinfield.signal import Calibration
from skinfield.signal.block import __doc__ as _BLOCKS
from skinfield.skin import Skin

NPZ, JSON = "application/x-npz", "application/json"
_KINDS = """\
Kinds, and their payloads: 1, 2, 3: counts as uint8, uint16, float32, one per channel. 4: a bit per
channel, out of range. 5: int64, a source (its number stands for the channel) came up (1) or went
down (0). 6: int64, messages of a source that are known to be lost.
Status bits: 1 no answer, 2 not connected, 4 out of range, 8 invalid.
"""
_MORE = b"What these are is said in the schema of /skin/blocks.\n"


def _object(**kinds: str) -> bytes:
    """Schema of messages that are JSON."""
    described = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "type": "object",
        "properties": {name: {"type": kind} for name, kind in kinds.items()},
    }
    return json.dumps(described).encode()


TEXT, OBJECT = "x-text", "jsonschema"  # encodings of schemas
CHANNELS = {  # encoding of messages; name, encoding and text of their schema
    schema.BLOCKS: (
        "x-skinfield-blocks", "skinfield.Blocks", TEXT,
        f"{schema.__doc__}\n{_BLOCKS}\n{_KINDS}".encode(),
    ),
    schema.CYCLES: ("x-skinfield-cycle", "skinfield.Cycle", TEXT, _MORE),
    schema.FIELDS: ("x-skinfield-field", "skinfield.Field", TEXT, _MORE),
    schema.TIMING: ("json", "skinfield.Timing", OBJECT, _object(
        wall_ns="integer", cycles="integer", late="integer", wake_us="object", latency_us="object",
        counters="array",
    )),
    schema.EVENTS: (
        "json", "skinfield.Event", OBJECT, _object(wall_ns="integer", kind="string", text="string")
    ),
}  # fmt: skip


class RecordingWriter:
    """Writes a recording; what was flushed survives the end of the process.

    Parameters
    ----------
    path : str or Path
        Written to from the beginning under this name, so that a crash leaves a file to recover.
    enclosed : iterable of Enclosed
        Layout, calibrations, configuration.
    layout : CycleLayout
        Of the cycles' rows.
    overwrite : bool
        Whether a file of this name may be replaced.
    output : FileOutput, optional
        Instead of a file of this path.

    Raises
    ------
    InputError
        If there is a file of this name already and `overwrite` is not set.
    FileError
        If it cannot be made.

    Attributes
    ----------
    path : Path
    """

    def __init__(
        self,
        path: str | Path,
        enclosed: Iterable[schema.Enclosed] = (),
        *,
        layout: schema.CycleLayout,
        overwrite: bool = False,
        output: FileOutput | None = None,
    ) -> None:
        self.path = Path(path)
        self._output = output or FileOutput(self.path, overwrite=overwrite)
        self.container = Container(
            self._output, schema.PROFILE, f"skinfield {version('skinfield')}"
        )
        self._channels: dict[str, int] = {}
        for number, (topic, (encoding, name, kind, text)) in enumerate(CHANNELS.items(), 1):
            self._channels[topic] = number
            self.container.put(Schema(number, text, kind, name))
            metadata = layout.metadata() if topic == schema.CYCLES else {}
            self.container.put(Channel(number, topic, encoding, metadata, number))
        self._numbers: Counter[str] = Counter()
        self.open = True
        for each in enclosed:
            self.enclose(time.time_ns(), each)
        self.flush()

    @property
    def bytes_written(self) -> int:
        """Of the file so far."""
        return self._output.end

    @property
    def waiting(self) -> int:
        """Bytes that are not in the file yet."""
        return self.container.waiting

    def write_blocks(self, time_ns: int, position: int, data: Bytes) -> None:
        """Add bytes of the ring's log.

        Parameters
        ----------
        time_ns : int, ns
            When they were taken from the log, since the epoch.
        position : int, bytes
            Of the first of them in the log.
        data : bytes
            Whole blocks.

        Raises
        ------
        FileError
            If a chunk could not be written. Nothing is lost: it waits, see `flush`.
        """
        self.write(schema.BLOCKS, time_ns, schema.POSITION.pack(position) + data)

    def write(self, topic: str, time_ns: int, data: Bytes) -> None:
        """Add a message of a topic, as the record of its kind encodes it; raises `FileError`.

        Parameters
        ----------
        topic : str
            Such as `CYCLES`.
        time_ns : int, ns
            Since the epoch.
        data : bytes
        """
        if not self.open:
            raise InputError(f"{self.path} is closed, expected an open recording")
        if topic not in self._channels:
            known = ", ".join(self._channels)
            raise InputError(f"{self.path} has no channel {topic}, expected one of {known}")
        check_count("time_ns", time_ns, 0, (1 << 63) - 1, "ns since the epoch")
        sequence = self._numbers[topic]
        self._numbers[topic] += 1
        with self._explained():
            self.container.add_message(self._channels[topic], sequence, time_ns, data)

    def timing(self, time_ns: int, values: Mapping[str, Any]) -> None:
        """Add what was measured of the last second; raises as `write`."""
        self.write(schema.TIMING, time_ns, _json({"wall_ns": time_ns, **values}))

    def enclose(self, time_ns: int, enclosed: schema.Enclosed) -> None:
        """Add a small file."""
        name, kind, data = enclosed.name, enclosed.media_type, enclosed.data
        self.container.put(Attachment(time_ns, time_ns, name, kind, data))

    def event(self, time_ns: int, kind: str, text: str, **values: Any) -> None:
        """Add something that happened; raises as `write`.

        Parameters
        ----------
        kind : str
            Such as "source_down", for programs.
        text : str
            A sentence.
        values : numbers and texts
            More of it, as JSON can hold it.
        """
        event = {"wall_ns": time_ns, "kind": kind, "text": text, **values}
        self.write(schema.EVENTS, time_ns, _json(event))

    def flush(self) -> None:
        """Close the chunk and hand everything to the system: a `kill -9` cannot take it any more.

        Raises
        ------
        FileError
            If it could not be written, such as on a full disk. Nothing is lost: call it again.
        """
        with self._explained():
            self.container.flush()

    def sync(self) -> None:
        """Have the system write everything to the disk: not even power loss can take it then."""
        with self._explained():
            self.container.sync()

    def close(self) -> None:
        """Finish the file.

        Raises
        ------
        FileError
            If its end could not be written: `skinfield recover` makes a whole file of it.
        """
        if not self.open:
            return
        self.open = False
        try:
            with self._explained():
                self.container.finish()
        finally:
            self._output.close()

    @contextmanager
    def _explained(self) -> Iterator[None]:
        """Turn what the system says into FileError."""
        try:
            yield
        except OSError as error:
            raise FileError(
                f"{self.path} cannot be written: {error.strerror or error}; "
                f"{self.waiting} bytes wait, {self.bytes_written} are in the file"
            ) from error


def _json(value: Mapping[str, Any]) -> bytes:
    return json.dumps(plain_json(value, "event"), separators=(",", ":")).encode()


def enclosures(
    skin: Skin | None = None,
    calibrations: Mapping[str, Calibration] | None = None,
    description: Mapping[str, Any] | None = None,
) -> Iterator[schema.Enclosed]:
    """Layout, calibrations and the ring's description as the files that a recording encloses.

    Parameters
    ----------
    skin : Skin, optional
        As skinfield's own NPZ layout: nothing of it is lost.
    calibrations : mapping of str to Calibration, optional
        By patch.
    description : mapping, optional
        Of the ring, as JSON can hold it.
    """
    from skinfield.files.layouts import own_npz
    from skinfield.signal import save_calibration

    with TemporaryDirectory() as folder:
        path = Path(folder) / "enclosed.npz"
        if skin is not None:
            own_npz.write(skin, path)
            yield schema.Enclosed(schema.LAYOUT, NPZ, path.read_bytes())
        for patch, calibration in (calibrations or {}).items():
            save_calibration(calibration, path)
            yield schema.Enclosed(schema.CALIBRATION.format(patch=patch), NPZ, path.read_bytes())
    if description is not None:
        yield schema.Enclosed(schema.DESCRIPTION, JSON, json.dumps(description, indent=1).encode())
