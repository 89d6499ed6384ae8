"""Contact lists of other programs on the command line: followed, and written as a table."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.cli import options, report
from skinfield.cli.report import Column
from skinfield.errors import FileError, InputError
from skinfield.plot import plural

if TYPE_CHECKING:
    from skinfield.estimate import ContactList, TrackedContact
    from skinfield.wire.yarp import ContactLog

OPTIONS = ("layout", "patch", "output", "summary", "force", "as_json")  # that apply
MOST = 12  # tracks that are shown
TRACKS = (
    Column("track", "track", decimals=0), Column("link", "body_part"),
    Column("skin", "skin_part"), Column("from s", "first_s", decimals=2),
    Column("to s", "last_s", decimals=2), Column("readings", "readings", decimals=0),
    Column("highest force", "highest_force_N", decimals=2),
    Column("moved mm", "moved_m", 1e3, 1),
)  # fmt: skip


def are_contact_lists(recording: str) -> bool:
    """Whether a recording is a log of contact lists; what cannot be read is none."""
    from skinfield.wire.yarp import is_contact_log

    try:
        return is_contact_log(recording)
    except FileError:
        return False


@dataclass
class Summary:
    """What there is to say of the contacts of a log."""

    readings: int = 0
    touched: int = 0
    left_out: int = 0
    start_ns: int = 0
    stamp_ns: int = 0
    tracks: dict[int, dict[str, Any]] = field(default_factory=dict)
    places: dict[int, Any] = field(default_factory=dict)  # where each began

    @property
    def seconds(self) -> float:
        """From the first reading to the latest."""
        return (self.stamp_ns - self.start_ns) / 1e9

    def add(self, reading: "ContactList", tracked: Sequence["TrackedContact"]) -> None:
        """Take in a reading and the tracks that it gave."""
        self.start_ns = self.start_ns if self.readings else reading.stamp_ns
        self.stamp_ns = reading.stamp_ns
        self.readings += 1
        self.touched += bool(reading.contacts)
        self.left_out += len(reading.contacts)
        for one in tracked:
            if not one.is_coasting and one.track_id is not None:
                self.left_out -= 1
                self._add_to(one.track_id, one.measured)

    def _add_to(self, track: int, sent: Any) -> None:
        row = self.tracks.setdefault(
            track,
            {
                "track": track, "body_part": f"{sent.body} {sent.link}", "skin_part": sent.skin,
                "first_s": self.seconds, "readings": 0, "highest_force_N": 0.0, "moved_m": 0.0,
            },
        )  # fmt: skip
        off = sent.position - self.places.setdefault(track, sent.position)
        row["readings"] += 1
        row["last_s"] = self.seconds
        row["highest_force_N"] = max(row["highest_force_N"], sent.normal_force)
        row["moved_m"] = max(row["moved_m"], float(np.linalg.norm(off)))


def follow_contacts(
    recording: str,
    skin: tuple[str | None, str | None],
    output: Sequence[str],
    summary: str | None,
    force: bool,
    as_json: bool,
) -> None:
    """Follow the contacts of a log, and write each reading's with the numbers of their tracks.

    `skin` is a layout and the name of a patch in it, whose taxels' distance counts.
    """
    from skinfield.estimate.contact_list import SPACING
    from skinfield.files import write_summary
    from skinfield.wire.yarp import open_contact_log

    for name in output:
        report.check_output("--output", name, force, ".csv", ".parquet")
    report.check_output("--summary", summary, force, ".json")
    layout, patch = skin
    spacing = SPACING
    if layout is not None:
        spacing = options.patch_of(options.skin_from_text(layout), patch).pitch
    with report.progress("following contacts") as step:
        log = open_contact_log(recording, spacing=spacing, progress=step)
        found = _follow(log, output)
    notes = list(log.notes)
    if found.left_out:
        notes.append(f"{found.left_out} contacts were left out: of very many the strongest count")
    report.say_notes(notes)
    tracks = list(found.tracks.values())
    plain = {
        "recording": log.source,
        "readings": found.readings,
        "readings_with_contact": found.touched,
        "duration_s": found.seconds,
        "skipped_lines": log.skipped,
        "passed_over": log.passed,
        "spacing_m": spacing,
        "tracks": tracks,
        "notes": notes,
    }
    if summary:
        write_summary(summary, plain)
    line = (
        f"{log.source}: {plural(found.readings, 'reading')} in {found.seconds:.2f} s, "
        f"{found.touched} with contact, {log.skipped} lines skipped, {log.passed} passed over"
    )
    report.finish(as_json, plain, [*output, summary], [line, *_table(tracks)])


def _follow(log: "ContactLog", output: Sequence[str]) -> Summary:
    """Follow all contacts of a log into tables; InputError if there is no reading."""
    from skinfield import Tracker
    from skinfield.estimate.contact_table import LISTED_KINDS, rows_from_tracks
    from skinfield.files.tables import TableFile

    tracker, found = Tracker.for_lists(), Summary()
    with ExitStack() as files:
        tables = [files.enter_context(TableFile(name, LISTED_KINDS)) for name in output]
        for reading in log.readings():
            tracked = tracker(reading)
            found.add(reading, tracked)
            place = found.readings - 1, reading.stamp_ns, found.start_ns
            rows = list(rows_from_tracks(tracked, *place)) if reading.contacts else []
            for each in tables if rows else ():
                each.add(list(zip(*rows, strict=True)), len(rows))
        if not found.readings:
            raise InputError(f"{log.source} holds no list of contacts, expected one or more")
    return found


def _table(rows: list[dict[str, Any]]) -> list[report.Shown]:
    """The tracks, those first that lasted longest where there are too many."""
    if not rows:
        return ["no contact"]
    longest = sorted(rows, key=lambda row: -row["readings"])[:MOST]
    made = report.table_of(
        plural(len(rows), "track"), sorted(longest, key=lambda row: row["track"]), TRACKS
    )
    if len(rows) > MOST:
        made.caption = f"and {len(rows) - MOST} shorter ones"
    return [made]
