"""Times of a recording in seconds since its first cycle, and what can be answered of it."""

from bisect import bisect_right
from dataclasses import dataclass
from typing import Self

from skinfield.errors import FileError
from skinfield.live.replay import Replay

SHORTEST = 0.05  # s: spans that are shorter are not worth a word


@dataclass(frozen=True)
class Times:
    """What is when.

    Attributes
    ----------
    first_ns : int, ns
        Of the first cycle, since the epoch.
    begin_s, end_s : float, s
        Of the first cycle that can be answered, and of the last one.
    holes : tuple of pair of float, s
        Spans in which no cycle can be.
    """

    first_ns: int
    begin_s: float
    end_s: float
    holes: tuple[tuple[float, float], ...]

    @classmethod
    def of(cls, replay: Replay) -> Self:
        """Look through a recording.

        Raises
        ------
        FileError
            If none of its cycles can be answered.
        """
        moments, tared, path = replay.moments, replay.tared, replay.recording.path
        first = moments.first_ns
        if tared is None:
            why = "it holds no baseline"
        else:
            spans = tuple(
                ((begin - first) * 1e-9, (end - first) * 1e-9)
                for begin, end in moments.holes(tared.stale_ns)
            )
            end_s = (moments.last_ns - first) * 1e-9
            begin_s = spans[0][1] if spans else 0.0
            if moments.keys and begin_s < end_s:
                holes = tuple(each for each in spans if each[1] - each[0] > SHORTEST)
                return cls(first, begin_s, end_s, holes)
            why = f"none of its {len(moments.keys)} key cycles has all readings before it"
        raise FileError(
            f"{path} cannot be answered again, {why}: it is too short or too damaged; `skinfield "
            "export` still gives its readings"
        )

    def seconds(self, time_ns: int) -> float:
        """Of a time since the epoch, ns; those outside of the recording are at its ends."""
        return min(max((time_ns - self.first_ns) * 1e-9, 0.0), self.end_s)

    def nanoseconds(self, t_s: float) -> int:
        """Since the epoch."""
        return self.first_ns + round(min(max(t_s, 0.0), self.end_s) * 1e9)

    def line(self, t_s: float) -> str:
        """Where it is, and what cannot be answered there or elsewhere."""
        place = bisect_right(self.holes, (t_s, float("inf")))
        if place and self.holes[place - 1][0] <= t_s < self.holes[place - 1][1]:
            begin, end = self.holes[place - 1]
            return (
                f"from {begin:.2f} s to {end:.2f} s nothing can be answered again: readings are "
                "missing, or the engine was starting"
            )
        said = f"{t_s:.2f} s of {self.end_s:.2f} s"
        if not self.holes:
            return said
        spans = ", ".join(f"{begin:.2f} s to {end:.2f} s" for begin, end in self.holes[:4])
        more = f" and {len(self.holes) - 4} more" if len(self.holes) > 4 else ""
        return f"{said}; without answers from {spans}{more}"


def told_events(replay: Replay, times: Times) -> list[tuple[float, str]]:
    """What happened, by the time in s."""
    return sorted(
        (times.seconds(event["wall_ns"]), str(event.get("text") or event.get("kind") or ""))
        for event in replay.moments.events
    )
