"""Tracker state in fixed arrays: Kalman filters, absorbed contacts, events, and room to work in."""

from typing import Any, NamedTuple

import numpy as np

from skinfield.errors import Floats, Ints

IDENTITY: list[Any] = [("number", np.int64), ("made", np.int64), ("slipped", np.int64)]
IDENTITY += [("slips", np.int64)]  # what goes with a contact when tracks are exchanged; times in ns
TRACK = np.dtype(
    [
        *IDENTITY,
        ("alive", np.int64),
        ("confirmed", np.int64),
        ("last", np.int64),  # ns, when it was seen
        ("readings", np.int64),
        ("parent", np.int64),  # place of the track that it split from, until it is confirmed
        ("column", np.int64),  # contact of this reading; -1: none
        ("mean", np.float64, (6,)),  # x, y m in the developed plane, force N, and their rates per s
        ("covariance", np.float64, (6, 6)),
    ]
)
ABSORBED = np.dtype(
    [
        *IDENTITY,
        ("owner", np.int64),  # place of the track that it merged into; -1: free
        ("time", np.int64),  # ns
        ("apart", np.float64, (6,)),  # state of the absorbed one less that of the one that stayed
        ("forces", np.float64, (2,)),  # N: of the absorbed one, and of the one that stayed
        ("variances", np.float64, (2,)),  # m² and m²/s²: of the distance and its rate, on each axis
    ]
)
EVENT = np.dtype(
    [
        ("kind", np.int64),
        ("time", np.int64),  # ns
        ("ids", np.int64, (2,)),  # the second is -1 where there is one
        ("x", np.float64),
        ("y", np.float64),
    ]
)
RULES = np.dtype(
    [
        (name, np.float64)
        for name in (
            *("place_push", "force_push", "speed_variance", "force_rate_variance", "top_speed"),
            *("surprise", "gate", "floor", "reach", "period_ns", "coast_ns", "memory_ns"),
            *("strong", "weak_readings", "near", "slip_speed", "slip_sigmas"),
        )
    ]
)
NOW, STARTED, TOP, EVENTS = range(4)  # of `words`: ns; whether; places in use end here; how many
PAIR, ORIGIN, FREE, LISTED, MATCH, WAY, USED = range(7)  # of `lists`
FLOORS = np.diag([1e-5, 1e-5, 1e-3]) ** 2  # m, m, N: no solver is surer than this


class TrackMemory(NamedTuple):
    """All that a tracker of one patch knows, of up to N contacts, and room to work in.

    Attributes
    ----------
    tracks : (N,) array of TRACK
    absorbed : (N,) array of ABSORBED
    events : (4 N,) array of EVENT
        A ring: the newest are in place `words[EVENTS] - 1` and before, modulo its length.
    words : (4,) int array
    value : (N, 3) array
        Contacts of a reading, written by the caller: x and y m in the developed plane, force N.
    noise : (N, 3, 3) array
        Their covariances.
    gains, work : (N, N) and (12, N + 1) arrays
        Room.
    lists : (7, N + 1) int array
        Room; `lists[ORIGIN]` has the caller's places of the sorted contacts.
    """

    tracks: Any
    absorbed: Any
    events: Any
    words: Ints
    value: Floats
    noise: Floats
    gains: Floats
    work: Floats
    lists: Ints

    @classmethod
    def of(cls, most: int) -> "TrackMemory":
        """Room for so many contacts, those that coast included."""
        memory = cls(
            np.zeros(most, TRACK),
            np.zeros(most, ABSORBED),
            np.zeros(4 * most, EVENT),
            np.zeros(4, np.int64),
            np.zeros((most, 3)),
            np.zeros((most, 3, 3)),
            np.zeros((most, most)),
            np.zeros((12, max(most + 1, 6))),
            np.zeros((7, most + 1), np.int64),
        )
        memory.reset()
        return memory

    def reset(self) -> None:
        """Know of no contact."""
        self.tracks["alive"] = 0
        self.absorbed["owner"] = -1
        self.words[:] = 0

    def take(self, other: "TrackMemory") -> None:
        """Know what another one does, which has no more room."""
        self.reset()
        for mine, its in zip(self[:3], other[:3], strict=True):
            mine[: len(its)] = its
        self.words[:] = other.words
