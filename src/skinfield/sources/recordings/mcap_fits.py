"""What a contact fit had found beside the engine, as a recording of a live skin has it."""

from bisect import bisect_right
from collections.abc import Iterator

from skinfield.acquisition.recorded_fit import FITS, FitLayout, FitRecord
from skinfield.errors import FileError, InputError
from skinfield.sources.recordings.mcap_bodies import Damaged, Op, chunk_content
from skinfield.sources.recordings.mcap_live import LiveRecording
from skinfield.sources.recordings.mcap_moments import Moments
from skinfield.sources.recordings.mcap_records import body_of, open_file


def fit_layout_of(recording: LiveRecording) -> FitLayout | None:
    """Fields of the rows of fits; None of a recording without such a channel.

    Raises
    ------
    FileError
        If the channel does not state them.
    """
    for channel in recording.channels.values():
        if channel.topic == FITS:
            try:
                return FitLayout.from_metadata(channel.metadata)
            except InputError as error:
                raise FileError(f"{recording.path}: {error}") from error
    return None


def fits_of(recording: LiveRecording) -> Iterator[FitRecord]:
    """Answers of the fit, in order; what cannot be read is passed over, see `damage`.

    Raises
    ------
    FileError
        If the channel does not state the fields of its rows.
    """
    layout = fit_layout_of(recording)
    if layout is None:
        return
    for _, at, message in recording.messages((FITS,)):
        found = fit_of(recording, layout, at, message.data)
        if found is not None:
            yield found


def fit_of(recording: LiveRecording, layout: FitLayout, at: int, data: bytes) -> FitRecord | None:
    """Answer of a message at byte `at`; None, and a note, if it cannot be read."""
    try:
        return layout.decode(data)
    except InputError as error:
        recording.note(at, str(error))
        return None


class FitTimes:
    """Answers of the fit of a recording by time, for one thread at a time.

    Parameters
    ----------
    recording : LiveRecording
    moments : Moments
        Of that recording.

    Raises
    ------
    FileError
        If the channel does not state the fields of its rows.
    """

    def __init__(self, recording: LiveRecording, moments: Moments) -> None:
        self._recording, self._places = recording, moments.fits
        self._times = [each.time_ns for each in moments.fits]
        self._layout = fit_layout_of(recording)
        self._chunk: tuple[int, bytes] = (-1, b"")  # the record that was read last
        self._newest: tuple[int, FitRecord | None] = (-1, None)

    def before(self, time_ns: int) -> FitRecord | None:
        """The newest answer up to a time, ns since the epoch; None without one.

        Raises
        ------
        FileError
            If the file cannot be read any more.
        """
        place = bisect_right(self._times, time_ns) - 1
        if place < 0 or self._layout is None:
            return None
        if place != self._newest[0]:
            where = self._places[place]
            data = self._content(where.record)[where.start : where.end]
            at = self._recording.outline.records[where.record].start
            self._newest = place, fit_of(self._recording, self._layout, at, data)
        return self._newest[1]

    def _content(self, number: int) -> bytes:
        """Of a record of messages, unpacked; empty where it is damaged by now."""
        if number != self._chunk[0]:
            path, record = self._recording.path, self._recording.outline.records[number]
            try:
                with open_file(path) as file:
                    body = body_of(file, record)
                content = chunk_content(body) if record.opcode == Op.CHUNK else body
            except Damaged:
                content = b""  # which is no answer, and is noted as such
            except OSError as error:
                why = error.strerror or error
                raise FileError(f"{path} cannot be read at byte {record.start}: {why}") from error
            self._chunk = number, content
        return self._chunk[1]
