"""A recording as the engine lived it: each cycle with the readings that came before it."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from skinfield.acquisition.recorded import BLOCKS, CYCLES, Cycle
from skinfield.sources.recordings.mcap_bodies import Logged
from skinfield.sources.recordings.mcap_live import LiveRecording


class Step(NamedTuple):
    """One cycle and its readings.

    Attributes
    ----------
    cycle : Cycle
    data : bytes
        Blocks of the ring's log from the step before to `cycle.log_position`.
    missing : int, bytes
        Of the log that the recording lacks in between; 0 of an unbroken recording.
    """

    cycle: Cycle
    data: bytes
    missing: int


@dataclass
class Steps:
    """Cycles of a recording with their readings, in order.

    What was logged before the first cycle of the file comes with that cycle. A replay applies all
    data from the beginning on, and can answer from a cycle with `CycleFlag.KEY` on, once older
    readings would not count any more; and so again where something is missing or a cycle's number
    was passed over.

    Attributes
    ----------
    recording : LiveRecording
    left : int
        Cycles at the end whose readings are not in the file any more; known at the end.
    first : int
        Record to begin with, as if the file began there.
    """

    recording: LiveRecording
    left: int = 0
    first: int = 0

    def __iter__(self) -> Iterator[Step]:
        tape, waiting = Tape(), deque[Cycle]()
        for topic, at, message in self.recording.messages((BLOCKS, CYCLES), self.first):
            if topic == BLOCKS:
                logged = self.recording.logged_of(at, message)
                if logged is not None:
                    tape.add(logged)
            else:
                cycle = self.recording.cycle_of(at, message)
                if cycle is not None:
                    waiting.append(cycle)
            while waiting and waiting[0].log_position <= tape.end:
                yield tape.step(waiting.popleft())
        self.left = len(waiting)


@dataclass
class Tape:
    """Pieces of the log that no cycle has taken yet."""

    pieces: deque[Logged] = field(default_factory=deque)
    start: int = -1  # of what the next step takes
    end: int = -1

    def add(self, logged: Logged) -> None:
        """Append a piece; what is there already is passed over."""
        if self.start < 0:
            self.start = self.end = logged.position
        known = max(self.end - logged.position, 0)
        if known < len(logged.data):
            piece = Logged(logged.position + known, logged.time_ns, logged.data[known:])
            self.pieces.append(piece)
            self.end = piece.position + len(piece.data)

    def step(self, cycle: Cycle) -> Step:
        """Take all up to the cycle's position."""
        parts, have = [], 0
        while self.pieces and self.pieces[0].position < cycle.log_position:
            piece = self.pieces.popleft()
            keep = cycle.log_position - piece.position
            parts.append(piece.data[:keep])
            have += len(parts[-1])
            if keep < len(piece.data):
                rest = Logged(cycle.log_position, piece.time_ns, piece.data[keep:])
                self.pieces.appendleft(rest)
        missing = max(cycle.log_position - self.start, 0) - have
        self.start = max(self.start, cycle.log_position)
        return Step(cycle, b"".join(parts), missing)
