"""Tracker state in fixed arrays: Kalman filters, absorbed contacts, events, and room to work in."""

from typing import Any, NamedTuple

import numpy as np

from skinfield.errors import Floats, Ints

TRACK = np.dtype(
    [
        ("number", np.int64),
        ("made", np.int64),  # ns, as all times here
        ("slipped", np.int64),  # when it moved last
        ("slips", np.int64),
        ("state", np.int64),
        ("last", np.int64),  # when it was seen, or absorbed
        ("readings", np.int64),  # that have seen it
        ("parent", np.int64),  # place of what it split from, until confirmed, or merged into
        ("pair", np.int64),  # contact of this reading that is to be its, and that is; -1: none
        ("column", np.int64),
        ("whole", np.float64),  # N: of an absorbed one, with that of the one that stayed
        ("mean", np.float64, (6,)),  # x, y m in the developed plane, force N, and their rates per s
        ("covariance", np.float64, (6, 6)),  # both of an absorbed one: of the difference
    ]
)
FREE, TENTATIVE, CONFIRMED, ABSORBED = range(4)  # of `state`
MEASURED = np.dtype(
    [
        ("mean", np.float64, (3,)),  # x, y m in the developed plane, force N
        ("covariance", np.float64, (3, 3)),
        ("origin", np.int64),  # the caller's place of a sorted contact
        ("free", np.int64),
    ]
)
EVENT = np.dtype(
    [
        ("kind", np.int64),
        ("time", np.int64),
        ("ids", np.int64, (2,)),  # the second is -1 where there is one
        ("place", np.float64, (2,)),
    ]
)
RULES = np.dtype(
    [
        (name, np.float64)
        for name in (
            *("place_push", "force_push", "speed_variance", "force_rate_variance", "top_speed"),
            *("false_onsets", "gate", "floor", "reach", "period_ns", "coast_ns"),
            *("memory_ns", "pause_ns"),
            *("strong", "weak_readings", "near", "slip_speed", "slip_sigmas"),
        )
    ]
)
NOW, STARTED, TOP, EVENTS = range(4)  # of `words`: ns; whether; places in use end here; how many
FLOORS = np.diag([1e-5, 1e-5, 1e-3]) ** 2  # m, m, N: no solver is surer than this


class TrackMemory(NamedTuple):
    """All that a tracker of one patch knows, of up to N contacts, and room to work in.

    Attributes
    ----------
    tracks : (N,) array of TRACK
    events : (4 N,) array of EVENT
        A ring: the newest are in place `words[EVENTS] - 1` and before, modulo its length.
    words : (4,) int array
    ids : (1,) int array
        The last number of a contact, which may be shared between patches.
    rules : (1,) array of RULES
    contacts : (N + 1,) array of MEASURED
        Of a reading: `mean` and `covariance` are the caller's. The last one is room.
    gains, work, lists : (N, N), (6, N + 1) and (4, N + 1) arrays
        Room.
    """

    tracks: Any
    events: Any
    words: Ints
    ids: Ints
    rules: Any
    contacts: Any
    gains: Floats
    work: Floats
    lists: Ints

    @classmethod
    def of(cls, most: int, rules: Any, ids: Ints) -> "TrackMemory":
        """Room for so many contacts, those that coast included."""
        known = np.zeros(most, TRACK), np.zeros(4 * most, EVENT), np.zeros(4, np.int64)
        room = np.zeros((most, most)), np.zeros((6, max(most + 1, 6)))
        contacts, lists = np.zeros(most + 1, MEASURED), np.zeros((4, most + 1), np.int64)
        return cls(*known, ids, rules, contacts, *room, lists)

    def reset(self) -> None:
        """Know of no contact."""
        self.tracks["state"], self.words[:] = FREE, 0
