"""Recordings of a live skin: one MCAP file that holds all that a replay needs."""

import json
import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

from skinfield.acquisition.recorded import (
    BLOCKS,
    CYCLES,
    EVENTS,
    POSITION,
    PROFILE,
    TIMING,
    CycleLayout,
    Enclosed,
)
from skinfield.acquisition.recorded_fit import FITS, FitLayout
from skinfield.errors import FileError, InputError, check_count
from skinfield.sinks.mcap.compression import Bytes, Compression, Zstd
from skinfield.sinks.mcap.container import Container
from skinfield.sinks.mcap.output import FileOutput, Output
from skinfield.sinks.mcap.schemas import (
    BLOCKS_ENCODING,
    BLOCKS_SCHEMA,
    CYCLE_ENCODING,
    CYCLE_SCHEMA,
    EVENT_SCHEMA,
    FIT_ENCODING,
    FIT_SCHEMA,
    TIMING_SCHEMA,
)
from skinfield.sinks.mcap.views import ViewMessage, Views


@dataclass(frozen=True)
class RecordingSettings:
    """How a recording is written.

    Parameters
    ----------
    compression : Compression
    chunk_bytes : int
        A chunk is closed when it has as many; 256 kB to 1 MB are usual.
    overwrite : bool
        Whether a file of this name may be replaced.
    """

    compression: Compression = field(default_factory=Zstd)
    chunk_bytes: int = 1 << 19
    overwrite: bool = False

    def __post_init__(self) -> None:
        check_count("chunk_bytes", self.chunk_bytes, 1, 1 << 28, "what is compressed together")


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
    fit : FitLayout, optional
        Of the rows of contacts that are fitted beside the engine; `write_fit` writes them.
    settings : RecordingSettings
    output : Output, optional
        Instead of a file of this path.
    views : sequence of Views
        Channels for programs that do not know skinfield; `show` writes them.

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
        enclosed: Iterable[Enclosed] = (),
        *,
        layout: CycleLayout,
        fit: FitLayout | None = None,
        settings: RecordingSettings | None = None,
        output: Output | None = None,
        views: Sequence[Views] = (),
    ) -> None:
        self.path = Path(path)
        self.layout = layout
        settings = settings or RecordingSettings()
        self._output = output or FileOutput(self.path, overwrite=settings.overwrite)
        profile = next((each.profile for each in views if each.profile), PROFILE)
        library = f"skinfield {version('skinfield')}"
        self.container = Container(
            self._output, settings.compression, settings.chunk_bytes, profile, library
        )
        add = self.container.add_channel
        # Readers of ROS 2 bags refuse files with a schema whose language they do not know.
        told = _untyped if profile != PROFILE else _as_is
        self._blocks = add(BLOCKS, BLOCKS_ENCODING, told(BLOCKS_SCHEMA))
        self._cycles = add(CYCLES, CYCLE_ENCODING, told(CYCLE_SCHEMA), self.layout.metadata())
        self._timing = add(TIMING, "json", told(TIMING_SCHEMA))
        self._events = add(EVENTS, "json", told(EVENT_SCHEMA))
        self._fit: int | None = None
        if fit is not None:
            self._fit = add(FITS, FIT_ENCODING, told(FIT_SCHEMA), fit.metadata())
        shown = [channel for each in views for channel in each.channels()]
        self._views = {each.topic: add(*each) for each in shown}
        self.open = True
        for each in enclosed:
            self.enclose(time.time_ns(), each)
        own = [self._blocks, self._cycles, self._timing, self._events]
        own += [] if self._fit is None else [self._fit]
        self._numbers = dict.fromkeys((*own, *self._views.values()), 0)
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
        self._add(self._blocks, time_ns, POSITION.pack(position), data)

    def write_cycle(self, time_ns: int, record: Bytes) -> None:
        """Add a cycle, as `CycleLayout.encode` makes it; raises as `write_blocks`."""
        self._add(self._cycles, time_ns, record)

    def write_fit(self, time_ns: int, record: Bytes) -> None:
        """Add an answer of a fit, as `FitLayout.encode` makes it; raises as `write_blocks`."""
        if self._fit is None:
            raise InputError(f"{self.path} has no channel {FITS}, expected `fit` when it was made")
        self._add(self._fit, time_ns, record)

    def timing(self, time_ns: int, values: Mapping[str, Any]) -> None:
        """Add what was measured of the last second; raises as `write_blocks`."""
        self._add(self._timing, time_ns, _json({"wall_ns": time_ns, **values}))

    def show(self, message: ViewMessage) -> None:
        """Add a message of one of `views`; raises as `write_blocks`."""
        self._add(self._views[message.topic], message.time_ns, message.data)

    def enclose(self, time_ns: int, enclosed: Enclosed) -> None:
        """Add a small file."""
        add = self.container.add_attachment
        add(enclosed.name, enclosed.media_type, enclosed.data, time_ns)

    def event(self, time_ns: int, kind: str, text: str, **values: Any) -> None:
        """Add something that happened; raises as `write_blocks`.

        Parameters
        ----------
        kind : str
            Such as "source_down", for programs.
        text : str
            A sentence.
        values : numbers and texts
            More of it, as JSON can hold it.
        """
        told = {"wall_ns": time_ns, "kind": kind, "text": text, **values}
        self._add(self._events, time_ns, _json(told))

    def flush(self) -> None:
        """Close the chunk and hand everything to the system: a `kill -9` cannot take it any more.

        Raises
        ------
        FileError
            If it could not be written, such as on a full disk. Nothing is lost: call it again.
        """
        try:
            self.container.flush()
        except OSError as error:
            raise self._failure(error) from error

    def sync(self) -> None:
        """Have the system write everything to the disk: not even power loss can take it then."""
        try:
            self.container.sync()
        except OSError as error:
            raise self._failure(error) from error

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
            self.container.finish()
        except OSError as error:
            raise self._failure(error) from error
        finally:
            self._output.close()

    def _add(self, channel: int, time_ns: int, *parts: Bytes) -> None:
        if not self.open:
            raise InputError(f"{self.path} is closed, expected an open recording")
        check_count("time_ns", time_ns, 0, (1 << 63) - 1, "ns since the epoch")
        number = self._numbers[channel]
        self._numbers[channel] = number + 1
        try:
            self.container.add_message(channel, number, time_ns, *parts)
        except OSError as error:
            raise self._failure(error) from error

    def _failure(self, error: OSError) -> FileError:
        return FileError(
            f"{self.path} cannot be written: {error.strerror or error}; "
            f"{self.waiting} bytes wait, {self.bytes_written} are in the file"
        )


def _untyped(schema: tuple[str, str, bytes]) -> tuple[str, str, bytes]:
    name, _, text = schema
    return name, "", text


def _as_is(schema: tuple[str, str, bytes]) -> tuple[str, str, bytes]:
    return schema


def _json(value: Mapping[str, Any]) -> bytes:
    return json.dumps(_plain(value), separators=(",", ":")).encode()


def _plain(value: Any) -> Any:
    """What JSON can hold; null for a number that is not finite, as JSON has none."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if hasattr(value, "tolist"):  # NumPy's
        return _plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, str | int):
        return value
    raise InputError(f"{value!r} cannot be written as JSON, expected numbers and texts")
