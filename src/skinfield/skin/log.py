"""Settings of a log: columns and units of what a skin of one's own writes."""

from dataclasses import dataclass
from typing import Annotated, Literal

from skinfield.settings import Positive, Section

TimeUnit = Literal["s", "ms", "us", "ns"]
Unit = Literal["count", "dC/C0", "Pa", "1"]
BoardName = Literal["auto", "icub", "cyskin", "plain", "plain-falling"]
NS = {"s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1}


@dataclass(frozen=True, kw_only=True)
class LogSettings(Section):
    """How logs of a skin are read; without columns, as their format says.

    Parameters
    ----------
    time : str, optional
        Column of the times. Without one, readings come at `rate_hz`.
    time_unit : str
        Of the times: s, ms, us or ns.
    rate_hz : float, 1/s, optional
        Readings per second, of a log without times.
    columns : tuple of str
        Of the taxels, in the order of their channels: names, patterns such as ch*, or numbers from
        1 such as 3-66.
    unit : str
        Of the values: count, dC/C0, Pa or 1.
    board : str
        Whose counts they are; plain: each taxel rests at its own and rises when pressed;
        plain-falling: falls.
    gain : float, optional
        Counts per unit of ΔC/C₀, a guess; forces stay relative by it.
    load_cell : str, optional
        Column of the force that presses.
    """

    time: str | None = None
    time_unit: TimeUnit = "s"
    rate_hz: Annotated[float | None, Positive("readings per second")] = None
    columns: tuple[str, ...] = ()
    unit: Unit = "count"
    board: BoardName = "auto"
    gain: float | None = None
    load_cell: str | None = None

    def check(self) -> None:
        """See `Section`."""
        if self.columns and (self.time is None) == (self.rate_hz is None):
            raise self.wrong("time", "a column of times, or rate_hz without one")
        if self.gain is not None and not 0.0 < abs(self.gain) < float("inf"):
            raise self.wrong("gain", "counts per unit of ΔC/C₀, not 0")
