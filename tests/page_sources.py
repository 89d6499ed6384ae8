"""Feeds and desks in memory, for tests of the page's server."""

import json
import struct
import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from live_skins import REST, cycle_of, pressed_counts, settings

from skinfield.errors import InputError
from skinfield.loop.model_config import ModelConfig, Models
from skinfield.loop.slots import CycleSlot
from skinfield.loop.snapshot import Snapshot
from skinfield.page.controller import Controller
from skinfield.page.presser import PressRequest
from skinfield.signal import Blocks, Channels, Kind
from skinfield.skin import Skin


def unpacked(message: bytes) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Head and arrays of a binary message, as the page reads it."""
    magic, size = struct.unpack_from("<4sI", message)
    assert magic == b"SKF1"
    head, start = json.loads(message[8 : 8 + size]), 8 + size
    assert start % 8 == 0
    kinds = {"u8": "<u1", "u16": "<u2", "u32": "<u4", "f32": "<f4"}
    assert all(each["at"] % 4 == 0 for each in head["arrays"])
    return head, [
        np.frombuffer(message, kinds[each["type"]], each["length"], start + each["at"])
        for each in head["arrays"]
    ]


class StillSource:
    """A skin of one hexagon that is answered when it is told to."""

    def __init__(self, name: str = "still", relative: bool = False) -> None:
        self._name = name
        self._cycle = cycle_of(settings(relative=relative))
        self._models = Models(self._cycle.model_config, np.full(72, 0.004))
        self._channels, self._number = Channels(72), 0
        self._newest: Snapshot | None = None
        self.state, self.closed = "running", False

    def read(self, force: float | None = None) -> None:
        """Answer a reading, of an untouched skin or of a press with so many newtons."""
        counts = np.full(72, REST) if force is None else pressed_counts(force)
        self._number += 1
        now, blocks = time.time_ns(), Blocks(1 << 12)
        blocks.put(now, 0, counts, Kind.BYTES)
        self._channels.apply(blocks)
        slot = CycleSlot.empty(self._cycle.sizes)
        self._cycle.answer(self._channels, now, slot, reset=True, budget=0.05)
        self._newest = Snapshot(slot, self._number, self._models, now)

    def miss(self) -> None:
        """A cycle in which the newest reading is too old."""
        self._number += 1
        slot, now = CycleSlot.empty(self._cycle.sizes), time.time_ns()
        self._newest = Snapshot(slot, self._number, self._models, now)

    @property
    def name(self) -> str:
        return self._name

    @property
    def skin(self) -> Skin:
        return self.model_config.skin

    @property
    def model_config(self) -> ModelConfig:
        return self._cycle.model_config

    def latest(self) -> Snapshot | None:
        return self._newest

    def status(self) -> dict[str, Any]:
        return {"name": self._name, "state": self.state}

    def close(self) -> None:
        self.closed = True


class NotingController(Controller):
    """Notes what is ordered; `press` is refused beyond 2 N."""

    mode = "live"

    def __init__(self) -> None:
        super().__init__()
        self.orders: list[tuple[str, Any]] = []
        self.left: list[str] = []

        self.presser = self.recordings = self  # type: ignore[assignment]

    def hello(self) -> dict[str, Any]:
        return {"press": {"shapes": ["ball"]}, "record": True, "recordings": []}

    def controls(self) -> dict[str, Any]:
        return {"off": {}, "busy": None, "orders": len(self.orders)}

    def truth(self) -> Sequence[Mapping[str, Any]]:
        return [
            {
                "id": "1-a", "patch": "hexagon72", "x": 0.0, "y": 7.5e-3, "force": 1.0,
                "shape": "ball", "radius": 6e-3, "contact_radius": 2e-3,
                "position": [0.0, 7.5e-3, 0.0],
            }
        ]  # fmt: skip

    def press(self, press: PressRequest) -> dict[str, Any]:
        if press.force is not None and press.force > 2.0:
            raise InputError(f"force is {press.force:g} N, expected 2 N at most")
        self.orders.append(("press", press))
        return {"x": press.x, "y": press.y}

    def set(self, what: str, value: Any) -> dict[str, Any]:
        self.orders.append((what, value))
        return {}

    def record(self, on: bool) -> dict[str, Any]:
        raise OSError("no room")

    def prepare(self) -> None:
        pass

    def prepare_common(self) -> None:
        pass

    def leave(self, browser: str) -> None:
        self.left.append(browser)
