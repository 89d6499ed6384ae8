"""Hardware of a virtual skin: schedules of boards, what becomes of messages, faults of boards."""

import random
from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import numpy as np

from skinfield.emulator.electronics import Converters, starts_of
from skinfield.emulator.scenes import patch_index
from skinfield.emulator.settings import KINDS, VirtualSettings, numbers_of
from skinfield.skin import Skin

NEVER = 1 << 62
LATEST = 0.9  # of a period, that jitter can make a reading late
MISHAPS = ("lose", "duplicate", "swap")
COUNTED = ("messages", "lost", "duplicated", "swapped", "refused", "withheld")
MessageT = TypeVar("MessageT")


@dataclass
class BoardGroup:
    """Boards that send together.

    Attributes
    ----------
    members : tuple
        Their numbers.
    period_ns, phase_ns : int
    number : int
        Of the next reading, which is made at `number` periods and the phase since the epoch.
    due_ns : int
        When it is sent, jitter included.
    """

    members: tuple[int, ...]
    period_ns: int
    phase_ns: int
    number: int = 0
    due_ns: int = NEVER


@dataclass
class Schedule:
    """Groups of boards with their next times.

    A reading that is late by more than a period is skipped and counted: a device that cannot keep
    up loses readings, it does not send them in a heap.

    Parameters
    ----------
    spread : bool
        Each board has a phase of its own.
    jitter : float, s
        Mean of the exponential delay.
    rng : numpy Generator

    Attributes
    ----------
    skipped : int
        Readings of boards.
    """

    spread: bool
    jitter: float
    rng: np.random.Generator
    skipped: int = 0
    groups: list[BoardGroup] = field(default_factory=list)
    _key: Hashable = None

    def set(self, periods: dict[int, int], boards: int, now_ns: int) -> None:
        """Tell which of `boards` send, with which period, ns; the others are silent."""
        key = tuple(sorted(periods.items()))
        if key == self._key:
            return
        self._key = key
        if self.spread:
            self.groups = [BoardGroup((b,), p, p * b // boards) for b, p in periods.items()]
        else:
            alike: dict[int, list[int]] = {}
            for board, period in periods.items():
                alike.setdefault(period, []).append(board)
            self.groups = [
                BoardGroup(tuple(members), period, 0) for period, members in alike.items()
            ]
        self.begin(now_ns)

    def begin(self, now_ns: int) -> None:
        """Aim all groups at their next times, as if nothing had been due before."""
        for group in self.groups:
            self._aim(group, -(-(now_ns - group.phase_ns) // group.period_ns))

    def _aim(self, group: BoardGroup, number: int) -> None:
        late = self.rng.exponential(self.jitter) * 1e9 if self.jitter > 0.0 else 0.0
        group.number = number
        group.due_ns = number * group.period_ns + group.phase_ns
        group.due_ns += int(min(late, LATEST * group.period_ns))

    @property
    def next_ns(self) -> int:
        """When the next group is due."""
        return min((group.due_ns for group in self.groups), default=NEVER)

    def due(self, now_ns: int) -> list[BoardGroup]:
        """Groups to send now; each is aimed at its next time."""
        found = [group for group in self.groups if group.due_ns <= now_ns]
        for group in found:
            following = group.number + 1
            newest = max((now_ns - group.phase_ns) // group.period_ns, following)
            self.skipped += (newest - following) * len(group.members)
            self._aim(group, newest)
        return found


class Wire(Generic[MessageT]):
    """One bus as the boards see it, and what becomes of messages on it.

    What is sent over it lies in a store of the subclass.

    Parameters
    ----------
    settings : VirtualSettings
    number : int
        Of the bus.

    Attributes
    ----------
    address : str
        Where a host finds it.
    chances : dict of str to float
        Of `MISHAPS`; may be written at any time.
    counts : Counter
        Of `COUNTED`: messages that went out, were lost, duplicated, swapped, that the system did
        not take, and that met a bus that was off.
    waiting : list
        The message that waits for the next one, if there is one.
    off : bool
    """

    address: str

    def __init__(self, settings: VirtualSettings, number: int) -> None:
        self.chances = {name: float(getattr(settings.wires, name)) for name in MISHAPS}
        self.chances["lose"] = max(self.chances["lose"], settings.its_habits.lost_messages)
        self.counts: Counter[str] = Counter()
        self.waiting: list[MessageT] = []
        self.off = False
        self._random = random.Random(f"{settings.seed} {number}").random

    def draw(self, messages: Iterable[MessageT]) -> list[MessageT]:
        """Messages in the order in which they go out, as chance has it."""
        lose, duplicate, swap = self.chances.values()
        order: list[MessageT] = []
        for message in messages:
            if lose and self._random() < lose:
                self.counts["lost"] += 1
                continue
            if swap and not self.waiting and self._random() < swap:
                self.waiting.append(message)
                continue
            order.append(message)
            if duplicate and self._random() < duplicate:
                order.append(message)
                self.counts["duplicated"] += 1
            if self.waiting:
                order.append(self.waiting.pop())
                self.counts["swapped"] += 1
        return order

    def send(self, count: int) -> None:
        """Send the first `count` messages that were made."""
        if self.off:
            self.counts["withheld"] += count
        elif not self.waiting and not any(self.chances.values()):
            self._put_all(count)
        else:
            self._put(self.draw(self._message(row) for row in range(count)))

    def filenos(self) -> Sequence[int]:
        """File descriptors that become readable when a host says something."""
        raise NotImplementedError

    def _message(self, row: int) -> MessageT:
        """A copy of a message that was made."""
        raise NotImplementedError

    def _put_all(self, count: int) -> None:
        """Send the first `count` messages as they are."""
        self._put([self._message(row) for row in range(count)])

    def _put(self, messages: Sequence[MessageT]) -> None:
        """Send copies of messages."""
        raise NotImplementedError

    def _let_go(self) -> None:
        raise NotImplementedError

    def close(self) -> None:
        """Send what waits, which then is not swapped, and close the bus."""
        if self.waiting and not self.off:
            self._put(self.waiting)
        self._let_go()


class Hardware:
    """Boards on their buses.

    Parameters
    ----------
    skin : Skin
    settings : VirtualSettings
    parts : sequence of int
        Triangles or modules of each board.
    converters : Converters
        Its first channels are the taxels of all patches.
    wires : sequence of Wire

    Attributes
    ----------
    schedule : Schedule
    readings, commands, reboots : int
        Of boards, that were made, obeyed and undergone so far.
    quiet : set of int
        Boards that are booting.
    unplugged : set of (int, int)
        Boards, and their parts that are not there.
    """

    part = "module"

    def __init__(
        self,
        skin: Skin,
        settings: VirtualSettings,
        parts: Sequence[int],
        converters: Converters,
        wires: Sequence[Wire[Any]],
    ) -> None:
        self.skin, self.converters, self.wires = skin, converters, tuple(wires)
        self._starts = starts_of(skin)
        rng = np.random.default_rng([settings.seed, 2])
        self.schedule = Schedule(settings.spread, settings.wires.jitter_us * 1e-6, rng)
        self._parts, self._boards, self._rate = tuple(parts), len(parts), settings.rate
        self.unplugged: set[tuple[int, int]] = set()
        self.readings = self.commands = self.reboots = 0
        self.quiet: set[int] = set()

    @property
    def addresses(self) -> list[str]:
        """Where a host finds each bus."""
        return [wire.address for wire in self.wires]

    def filenos(self) -> list[int]:
        """File descriptors that become readable when a host says something."""
        return [number for wire in self.wires for number in wire.filenos()]

    def listen(self, now_ns: int, warmth: float) -> None:
        """Take in what hosts say, and answer; never waits."""
        raise NotImplementedError

    def listen_late(self, now_ns: int, warmth: float) -> None:
        """Take in what hosts said while this process was held up."""
        self.listen(now_ns, warmth)

    def send(self, members: Sequence[int], now_ns: int) -> None:
        """Send the counts of now from some boards."""
        raise NotImplementedError

    def _period(self, board: int) -> float | None:
        """Seconds between the readings of a board; None while it sends none."""
        raise NotImplementedError

    def _reset(self, board: int) -> None:
        """Make a board as it is after switching on."""
        raise NotImplementedError

    def _awake(self, board: int, warmth: float) -> None:
        """Begin anew as a board that has booted."""

    def reschedule(self, now_ns: int) -> None:
        """Send from now on what is to be sent."""
        periods = {}
        for board in set(range(self._boards)) - self.quiet:
            period = self._period(board)
            if period is not None:
                periods[board] = round(1e9 * (1.0 / self._rate if self._rate else period))
        self.schedule.set(periods, self._boards, now_ns)

    def begin(self, kind: str, what: str, now_ns: int) -> None:
        """Begin a fault."""
        for place, part in self.places(kind, what):
            if kind == "unplug":
                self.unplugged.add((place, part))
            elif kind == "bus-off":
                self.wires[place].off = True
            elif kind == "reboot":
                self.quiet.add(place)
                self._reset(place)
                self.reboots += 1
            else:
                self.converters.set_fault(kind, place)
        self.reschedule(now_ns)

    def end(self, kind: str, what: str, now_ns: int, warmth: float) -> None:
        """End it."""
        for place, part in self.places(kind, what):
            if kind == "unplug":
                self.unplugged.discard((place, part))
            elif kind == "bus-off":
                self.wires[place].off = False
            elif kind == "reboot":
                self.quiet.discard(place)
                self._awake(place, warmth)
            else:
                self.converters.clear_fault(kind, place)
        self.reschedule(now_ns)

    def places(self, kind: str, what: str) -> list[tuple[int, int]]:
        """Numbers of boards, buses, or taxels of all patches; of boards with those of their parts.

        Parts are ``"1.3"`` or, of board 0, ``"3"``; taxels ``"palm/7"`` or, of the first patch,
        ``"7"``.

        Raises
        ------
        InputError
            If there is no such triangle, board, bus or taxel.
        """
        level = KINDS[kind]
        if level == "taxel":
            name, slash, rest = what.rpartition("/")
            key: str | int = int(name) if name.isdecimal() and len(name) < 6 else name
            patch = patch_index(self.skin, key) if slash else 0
            rows = numbers_of(rest, len(self.skin.patches[patch]), level)
            return [(int(self._starts[patch]) + row, 0) for row in rows]
        if level != "triangle":
            count = len(self.wires) if level == "bus" else self._boards
            return [(number, 0) for number in numbers_of(what, count, level)]
        board, dot, part = what.rpartition(".")
        return [
            (number, place)
            for number in (numbers_of(board, self._boards, "board") if dot else [0])
            for place in numbers_of(part, self._parts[number], self.part)
        ]

    def counts(self) -> dict[str, Any]:
        """What was sent and what was done to it: whole numbers."""
        counted = {name: sum(wire.counts[name] for wire in self.wires) for name in COUNTED}
        return {**counted, "commands": self.commands, "reboots": self.reboots}

    def close(self) -> None:
        """Let go of the buses."""
        for wire in self.wires:
            wire.close()
