"""Logs of contact lists: what yarpdatadumper wrote of skinManager's `skin_events:o`.

Each line is a sequence number, one or two times and skinDynLib's list of contacts as a bottle's
text, see `contacts`: nothing where nothing touches. One more list round all contacts is taken as
well. The dumper writes a line twice now and then, while the next is lost: a stamp that repeats, or
runs backwards, is passed over.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from skinfield.errors import FileError, InputError, check_positive
from skinfield.estimate import ContactList
from skinfield.estimate.contact_list import SPACING
from skinfield.files.recordings.head import read_head
from skinfield.files.recordings.lines import WORST, Doubts, Progress, ns_from_text
from skinfield.files.recordings.open import file_of
from skinfield.files.recordings.yarp import info_of, is_contact_list, preamble_of
from skinfield.wire.yarp.carriers import Value, values_from_text
from skinfield.wire.yarp.contacts import SkinContact

EXPECTED = "a sequence number, one or two times and a list of contacts"
SECOND = 10**9  # ns
PER_COUNT = 0.05  # of skinManager's force: compensator.cpp, getContacts, icub-main 2.11.1
SAME = 1e-5  # of a force
OFTEN = 1000  # lines between calls of `progress`


def is_contact_log(path: str | Path) -> bool:
    """Whether a log, or the folder that it lies in, is of contact lists.

    Raises
    ------
    FileError
        If it cannot be read.
    """
    return is_contact_list(read_head(file_of(Path(path))))


def open_contact_log(
    path: str | Path, *, spacing: float = SPACING, progress: Progress | None = None
) -> "ContactLog":
    """Open a log of contact lists.

    Parameters
    ----------
    path : str or Path
        The folder, or its `data.log`.
    spacing : float, m
        Between taxels; without it that of iCub's triangles.
    progress : callable, optional
        Called with bytes done and bytes in all.

    Raises
    ------
    FileError
        If it is no such log.
    """
    check_positive("spacing", spacing, "of taxels, in metres")
    head = read_head(file_of(Path(path)))
    if not is_contact_list(head):
        raise FileError(
            f"{head.path} holds no lists of contacts, expected a yarpdatadumper log of "
            "skin_events:o; readings of taxels are read by skinfield.files.open_recording"
        )
    port = info_of(head)[0]
    return ContactLog(
        path=head.path,
        source=f"{head.path} (port {port})" if port else str(head.path),
        spacing=spacing,
        skip=preamble_of(head),
        progress=progress,
    )


@dataclass(kw_only=True)
class ContactLog:
    """Contact lists of a log, one by one; see `open_contact_log`.

    Attributes
    ----------
    path : Path
    source : str
        The file, and the port where it is known.
    spacing : float, m
    skip : int
        Lines before the data.
    progress : callable, optional
    notes : tuple of str
        What was skipped, passed over and lost, and what the forces are; once `readings` is
        exhausted, as the next two.
    skipped : int
        Damaged lines.
    passed : int
        Lines whose stamps are not after the one before.
    """

    path: Path
    source: str
    spacing: float = SPACING
    skip: int = 0
    progress: Progress | None = None
    notes: tuple[str, ...] = field(default=(), init=False)
    skipped: int = field(default=0, init=False)
    passed: int = field(default=0, init=False)

    def readings(self) -> Iterator[ContactList]:
        """Lists in the order of time, once.

        Raises
        ------
        FileError
            If the file cannot be read; at the end, if more than a fifth of the lines are damaged,
            or of the stamps not later.
        """
        doubts, content = Doubts(self.path), Content()
        late: list[int] = []  # lines
        before = -1
        for number, line in self._lines(doubts):
            try:
                sequence, stamp, contacts = contacts_of(line)
                listed = tuple(each.listed(self.spacing) for each in contacts)
            except (InputError, ValueError) as error:
                doubts.skip(number, str(error)[:200])
                continue
            if stamp <= before:
                late.append(number)
                continue
            before = stamp
            doubts.add(
                np.array([stamp]), np.zeros((1, 1)), np.array([number]), np.array([sequence])
            )
            content.add(contacts)
            yield ContactList(stamp_ns=stamp, contacts=listed, spacing=self.spacing)
        doubts.check_lines(EXPECTED)
        self.skipped, self.passed = doubts.skipped, len(late)
        if self.passed > WORST * doubts.lines:
            raise FileError(
                f"{self.path}:{late[0]}: {self.passed} of {doubts.lines} stamps are not later than "
                f"those before, expected at most {WORST:.0%}: was the clock set back? Cut the log "
                "there, and give each part as a log of its own"
            )
        self.notes = (*content.notes(), *self._passed(late), *doubts.notes())
        if not doubts.skipped:
            self.notes += doubts.lost()

    def _passed(self, late: list[int]) -> tuple[str, ...]:
        """A sentence on lines that were passed over."""
        if not late:
            return ()
        where = f"{self.path.name}:{late[0]}"
        return (f"{len(late)} stamps repeat or run backwards, first at {where}: passed over",)

    def _lines(self, doubts: Doubts) -> Iterator[tuple[int, str]]:
        """Lines that hold data, with their numbers from 1; a last one that is cut is skipped."""
        try:
            total = self.path.stat().st_size
            with self.path.open("rb") as file:
                for number, data in enumerate(file, 1):
                    # latin-1 never fails: a byte that is no text makes its own line bad
                    line = data.removeprefix(b"\xef\xbb\xbf").decode("latin-1").strip()
                    if number <= self.skip or not line or line.startswith("#"):
                        continue
                    doubts.lines += 1
                    if not data.endswith(b"\n") and not line.endswith(")"):
                        doubts.skip(number, "the file ends within the line")
                        doubts.cut += 1
                        continue
                    yield number, line
                    if self.progress is not None and number % OFTEN == 0:
                        self.progress(file.tell(), max(total, file.tell()))
        except OSError as error:
            why = error.strerror or error
            raise FileError(f"{self.path} cannot be read to its end: {why}") from error


class Content:
    """What all contacts of a log have in common."""

    def __init__(self) -> None:
        self._all = self._counted = self._nowhere = 0

    def add(self, contacts: list[SkinContact]) -> None:
        """Take in those of a reading."""
        for each in contacts:
            self._all += 1
            self._nowhere += not each.normal.any()
            scale = PER_COUNT * len(each.taxels) * each.pressure
            off = np.linalg.norm(each.force + scale * each.normal)
            self._counted += bool(off <= SAME * abs(scale))

    def notes(self) -> tuple[str, ...]:
        """Sentences on forces and places."""
        notes: tuple[str, ...] = ()
        if self._all and self._counted == self._all:
            notes += (
                f"forces are relative, no newtons: all are skinManager's {PER_COUNT} for each "
                "count of each taxel, along the mean normal",
            )
        if self._nowhere:
            notes += (
                f"{self._nowhere} of {self._all} contacts have no normal: their sender does not "
                "know where these taxels are, so place and force are as it sends them",
            )
        return notes


def contacts_of(line: str) -> tuple[float, int, list[SkinContact]]:
    """Sequence number, stamp in ns and contacts of a line.

    Raises
    ------
    InputError, ValueError
        If it is not as expected.
    """
    lead, bracket, rest = line.partition("(")
    tokens = lead.split()
    if not 2 <= len(tokens) <= 3 or not tokens[0].isdecimal():
        raise InputError(f"begins with {lead!r:.60}, expected {EXPECTED}")
    values = values_from_text(bracket + rest)
    return (
        float(tokens[0]),
        ns_from_text(tokens[1], SECOND),
        [SkinContact.of(v) for v in flat(values)],
    )


def flat(values: list[Value]) -> list[Value]:
    """Contacts of a bottle that has them itself, or in one more list; () is none."""
    inner = values[0] if len(values) == 1 else None
    if isinstance(inner, list) and all(
        isinstance(each, list) and each and isinstance(each[0], list) for each in inner
    ):
        return inner
    return values
