"""Boards on CAN buses in software: schedules, what becomes of messages, listening to hosts."""

import random
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from skinfield.emulator.electronics import Converters
from skinfield.emulator.settings import VirtualSettings, Wires, numbers_of
from skinfield.errors import Floats, InputError, Ints
from skinfield.signal import CanMessages
from skinfield.wire.can import Bus, BusSettings, open_bus
from skinfield.wire.can.bus import can_interface, host_and_port

NEVER = 1 << 62
LATEST = 0.9  # of a period, that jitter can make a reading late
WAITING, NONE_WAITING = -1, -2
FAULTS = ("lost", "duplicated", "swapped")


@dataclass
class Group:
    """Boards that send together.

    Attributes
    ----------
    members : tuple
        Their numbers.
    period_ns, phase_ns : int
    due_ns : int
        When the next reading is sent, jitter included.
    """

    members: tuple[int, ...]
    period_ns: int
    phase_ns: int
    due_ns: int = NEVER
    _grid_ns: int = 0


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
    groups: list[Group] = field(default_factory=list)
    _key: Hashable = None

    def set(self, periods: dict[int, int], boards: int, now_ns: int) -> None:
        """Tell which of `boards` send, with which period, ns; the others are silent."""
        key = tuple(sorted(periods.items()))
        if key == self._key:
            return
        self._key = key
        each: list[tuple[tuple[int, ...], int, int]]
        if self.spread:
            each = [((b,), p, p * b // boards) for b, p in periods.items()]
        else:
            alike: dict[int, list[int]] = {}
            for board, period in periods.items():
                alike.setdefault(period, []).append(board)
            each = [(tuple(members), period, 0) for period, members in alike.items()]
        self.groups = [Group(members, period, phase) for members, period, phase in each]
        self.begin(now_ns)

    def begin(self, now_ns: int) -> None:
        """Aim all groups at their next times, as if nothing had been due before."""
        for group in self.groups:
            self._aim(group, -(-(now_ns - group.phase_ns) // group.period_ns))

    def _aim(self, group: Group, number: int) -> None:
        group._grid_ns = number * group.period_ns + group.phase_ns
        late = self.rng.exponential(self.jitter) * 1e9 if self.jitter > 0.0 else 0.0
        group.due_ns = group._grid_ns + int(min(late, LATEST * group.period_ns))

    @property
    def next_ns(self) -> int:
        """When the next group is due."""
        return min((group.due_ns for group in self.groups), default=NEVER)

    def due(self, now_ns: int) -> list[Group]:
        """Groups to send now; each is aimed at its next time."""
        found = [group for group in self.groups if group.due_ns <= now_ns]
        for group in found:
            number = (group._grid_ns - group.phase_ns) // group.period_ns + 1
            behind = (now_ns - number * group.period_ns - group.phase_ns) // group.period_ns
            if behind > 0:
                self.skipped += behind * len(group.members)
                number += behind
            self._aim(group, number)
        return found


class Fates:
    """Draws what happens to each message of one bus.

    Attributes
    ----------
    chances : (3,) array
        Of being lost, doubled, swapped; may be written at any time.
    counts : (3,) int64 array
        How many were.
    order : (N,) int64 array
        See `draw`.
    waiting : (1,) int64 array
        The message that waits for the next one: its index, `WAITING` of the burst before, or
        `NONE_WAITING`.
    """

    def __init__(self, room: int, wires: Wires, rng: np.random.Generator) -> None:
        self.chances: Floats = np.array([wires.lose, wires.duplicate, wires.swap])
        self.counts: Ints = np.zeros(len(FAULTS), np.int64)
        self.order: Ints = np.zeros(2 * room + 2, np.int64)
        self._random = random.Random(int(rng.integers(0, 1 << 63))).random
        self.waiting: Ints = np.full(1, NONE_WAITING, np.int64)

    def draw(self, count: int) -> int:
        """Put the order of messages 0 to `count` - 1 into `order`; how many go out.

        An entry is the index of a message, or `WAITING` for the one that the burst before left.
        """
        lose, duplicate, swap = self.chances.tolist()
        waiting, order, lost, swapped = int(self.waiting[0]), list[int](), 0, 0
        doubled = 0
        for message in range(count):
            if lose and self._random() < lose:
                lost += 1
                continue
            if swap and waiting == NONE_WAITING and self._random() < swap:
                waiting = message
                continue
            order.append(message)
            if duplicate and self._random() < duplicate:
                order.append(message)
                doubled += 1
            if waiting != NONE_WAITING:
                order.append(waiting)
                waiting = NONE_WAITING
                swapped += 1
        self.waiting[0], self.order[: len(order)] = waiting, order
        self.counts += lost, doubled, swapped
        return len(order)

    @property
    def idle(self) -> bool:
        """Whether nothing can happen to the next messages."""
        return not self.chances.any() and int(self.waiting[0]) == NONE_WAITING


def chances_of(fates: Fates) -> dict[str, float]:
    """Probabilities by their names."""
    lose, duplicate, swap = (float(each) for each in fates.chances)
    return {"lose": lose, "duplicate": duplicate, "swap": swap}


class CanWire:
    """One CAN bus as the boards see it.

    Attributes
    ----------
    sent, refused, withheld : int
        Messages that went out, that the system did not take, and that met a bus that was off.
    """

    def __init__(self, bus: Bus, room: int, wires: Wires, rng: np.random.Generator) -> None:
        self.bus, self.fates = bus, Fates(room, wires, rng)
        self.made = CanMessages(room)
        self._out = CanMessages(2 * room + 2)
        self._waiting = CanMessages(1)
        self.sent = self.refused = self.withheld = 0
        self.off = False

    def send(self, count: int) -> None:
        """Send the first `count` of `made`."""
        if self.off:
            self.withheld += count
            return
        if self.fates.idle:
            self._send(self.made, count)
            return
        going = self.fates.draw(count)
        self._gather(going)
        waiting = int(self.fates.waiting[0])
        if waiting >= 0:
            self._waiting.ids[0] = self.made.ids[waiting]
            self._waiting.lengths[0] = self.made.lengths[waiting]
            self._waiting.data[0] = self.made.data[waiting]
            self.fates.waiting[0] = -1
        self._send(self._out, going)

    def _send(self, messages: CanMessages, count: int) -> None:
        if not self.bus.up and not self.bus.reopen():
            self.refused += count
            return
        taken = self.bus.send_many(messages, count)
        self.sent += taken
        self.refused += count - taken

    def _gather(self, count: int) -> None:
        """Copy messages in the order of their fates."""
        order, made, waiting, out = self.fates.order[:count], self.made, self._waiting, self._out
        before = order == WAITING
        out.ids[:count] = np.where(before, waiting.ids[0], made.ids[order])
        out.lengths[:count] = np.where(before, waiting.lengths[0], made.lengths[order])
        out.data[:count] = np.where(before[:, None], waiting.data[0], made.data[order])

    def close(self) -> None:
        """Send what was kept back, which then is not swapped, and close the bus."""
        if self.fates.waiting[0] == -1 and not self.off:
            self._send(self._waiting, 1)
        self.bus.close()


HEARD = 256  # messages of hosts that are taken at once
ROUNDS = 16  # of them in one poll of a bus


def bus_settings(settings: VirtualSettings, count: int) -> list[BusSettings]:
    """Settings of `count` CAN buses, one per channel that is named, the rest by default.

    Raises
    ------
    InputError
        If more channels are named than the boards need, or fewer than there must be.
    """
    channels = settings.channels
    if len(channels) > count or (channels and len(channels) < count):
        raise InputError(
            f"channels are {list(channels)}, expected {count}, one for each bus: the boards of "
            f"this skin need {count} of them, with sixteen boards each"
        )
    first = settings.port
    return [
        _bus(settings.bus, channels[i] if channels else "", i, first + i if first else 0)
        for i in range(count)
    ]


def _bus(interface: str, channel: str, number: int, port: int) -> BusSettings:
    if interface == "udp":
        host, port = host_and_port(channel, "127.0.0.1", port)
        return BusSettings(interface, host, port)
    return can_interface(interface, channel, number)


def address_of(bus: Bus) -> str:
    """Where a host finds a bus."""
    place = getattr(bus, "address", None)
    if place is not None:
        return f"{place[0]}:{place[1]}"
    known = getattr(bus, "settings", None)
    if not isinstance(known, BusSettings):
        return ""
    port = dict(known.options).get("port")
    return known.channel if port is None else f"{known.channel}:{port}"


def open_buses(settings: VirtualSettings, count: int) -> list[Bus]:
    """The buses of the settings.

    Raises
    ------
    InputError
        If one cannot be opened; none is open then.
    """
    buses: list[Bus] = []
    try:
        for where in bus_settings(settings, count):
            bus = open_bus(where)
            buses.append(bus)
            if not bus.up:
                raise InputError(
                    f"bus cannot be opened: {bus.fault}, expected one that is free: choose "
                    "another with --channel"
                )
    except BaseException:
        for bus in buses:
            bus.close()
        raise
    return buses


class State(Protocol):
    """What a board of any kind was set to by its host."""

    @property
    def sending(self) -> bool:
        """Whether it sends by itself."""
        ...

    @property
    def period_ms(self) -> int:
        """Between its readings."""
        ...


StateT = TypeVar("StateT", bound=State)


@dataclass
class Playing(Generic[StateT]):
    """A board while it is played.

    Attributes
    ----------
    state : State
    fresh : State
        As after switching on.
    quiet : bool
        While it boots.
    """

    state: StateT
    fresh: StateT
    quiet: bool = False


class CanBoards(Generic[StateT]):
    """Boards on CAN; see `skin.Hardware`.

    Parameters
    ----------
    fresh : sequence of State
        Of the boards, as after switching on.
    converters : Converters
    schedule : Schedule
    wires : sequence of CanWire
        One for each bus.
    rate : float, 1/s, or None
        Of readings, whatever the host says.
    """

    def __init__(
        self,
        fresh: Sequence[StateT],
        converters: Converters,
        schedule: Schedule,
        wires: Sequence[CanWire],
        rate: float | None,
    ) -> None:
        self.converters, self.schedule, self.wires = converters, schedule, tuple(wires)
        self._playing = [Playing(state, state) for state in fresh]
        self._rate = rate
        self._heard = CanMessages(HEARD)
        self.readings = self.commands = self.reboots = 0

    @property
    def addresses(self) -> list[str]:
        """See `Hardware`."""
        return [address_of(wire.bus) for wire in self.wires]

    @property
    def chances(self) -> Mapping[str, float]:
        """See `Hardware`."""
        return chances_of(self.wires[0].fates)

    def filenos(self) -> list[int]:
        """See `Hardware`."""
        return [number for wire in self.wires for number in wire.bus.filenos()]

    def listen(self, now_ns: int, warmth: float) -> None:
        """See `Hardware`."""
        changed = False
        for number, wire in enumerate(self.wires):
            heard = self._heard
            for _ in range(ROUNDS):
                count = wire.bus.receive(heard)
                for row in range(0 if wire.off else count):
                    data = heard.data[row, : int(heard.lengths[row])].tobytes()
                    changed |= self._obey(number, int(heard.ids[row]), data, warmth)
                if count < HEARD:
                    break
        if changed:
            self._reschedule(now_ns)

    def _obey(self, bus: int, identifier: int, data: bytes, warmth: float) -> bool:
        """Obey one message; whether a board of ours was meant."""
        raise NotImplementedError

    def _plug(self, what: str, plugged: bool | None) -> None:
        """Plug parts of boards in or out; None: only look whether they are there."""
        raise NotImplementedError

    def _awake(self, number: int, warmth: float) -> None:
        """Begin anew as a board that has booted."""

    def _reschedule(self, now_ns: int) -> None:
        rate = self._rate
        periods = {
            number: round(1e9 / rate if rate else 1e6 * playing.state.period_ms)
            for number, playing in enumerate(self._playing)
            if playing.state.sending and not playing.quiet
        }
        self.schedule.set(periods, len(self._playing), now_ns)

    def check(self, kind: str, what: str) -> None:
        """See `Hardware`."""
        if kind == "unplug":
            self._plug(what, None)
        elif kind == "bus-off":
            numbers_of(what, len(self.wires), "bus")
        else:
            numbers_of(what, len(self._playing), "board")

    def begin(self, kind: str, what: str, now_ns: int) -> None:
        """See `Hardware`."""
        if kind == "unplug":
            self._plug(what, False)
        elif kind == "bus-off":
            for number in numbers_of(what, len(self.wires), "bus"):
                self.wires[number].off = True
        else:
            for number in numbers_of(what, len(self._playing), "board"):
                playing = self._playing[number]
                playing.quiet, playing.state = True, playing.fresh
                self.reboots += 1
            self._reschedule(now_ns)

    def end(self, kind: str, what: str, now_ns: int, warmth: float) -> None:
        """See `Hardware`."""
        if kind == "unplug":
            self._plug(what, True)
        elif kind == "bus-off":
            for number in numbers_of(what, len(self.wires), "bus"):
                self.wires[number].off = False
        else:
            for number in numbers_of(what, len(self._playing), "board"):
                self._playing[number].quiet = False
                self._awake(number, warmth)
            self._reschedule(now_ns)

    def start(self, now_ns: int) -> None:
        """See `Hardware`."""
        self._reschedule(now_ns)

    def set_chances(self, lose: float, duplicate: float, swap: float) -> None:
        """See `Hardware`."""
        for wire in self.wires:
            wire.fates.chances[:] = lose, duplicate, swap

    def counts(self) -> dict[str, Any]:
        """See `Hardware`."""
        return {
            "messages": sum(wire.sent for wire in self.wires),
            **{
                name: int(sum(wire.fates.counts[i] for wire in self.wires))
                for i, name in enumerate(FAULTS)
            },
            "refused": sum(wire.refused for wire in self.wires),
            "withheld": sum(wire.withheld for wire in self.wires),
            "commands": self.commands,
            "reboots": self.reboots,
        }

    def close(self) -> None:
        """See `Hardware`."""
        for wire in self.wires:
            wire.close()
