"""Rings and sessions for tests of zenoh: each test at a port of its own."""

import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import numpy as np
from live_skins import settings

from skinfield.bridges.zenoh.publisher import Publisher
from skinfield.bridges.zenoh.session import ZenohSettings, open_session
from skinfield.errors import InputError
from skinfield.loop.client import Live
from skinfield.loop.model_config import ModelConfig
from skinfield.loop.ring_fields import open_ring
from skinfield.loop.runtime_parameters import Tuning
from skinfield.loop.settings import LiveSettings
from skinfield.loop.slots import Head, Slot
from skinfield.reconstruct.engine.state import Answer
from skinfield.ring import Ring, State
from skinfield.signal import Port


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


@contextmanager
def listening(**values: Any) -> Iterator[tuple[Any, str]]:
    """A session that listens, and its address; another port if one was taken meanwhile."""
    protocol = "tls" if "tls" in values else "tcp"
    with ExitStack() as ends:
        for attempt in range(20):
            address = f"{protocol}/localhost:{free_port()}"
            try:
                made = ends.enter_context(open_session(ZenohSettings(listen=(address,), **values)))
                break
            except InputError:
                if attempt == 19:
                    raise
        yield made, address


@contextmanager
def joined() -> Iterator[tuple[Any, Any]]:
    """Two sessions that are connected."""
    with (
        listening() as (first, address),
        open_session(ZenohSettings(connect=(address,))) as second,
    ):
        yield first, second


@contextmanager
def skin_ring(made: LiveSettings | None = None) -> Iterator[Ring]:
    """A ring of a live skin, which tests fill."""
    made = settings() if made is None else made
    taxels = sum(len(patch) for patch in made.skin)
    ring, _ = open_ring(made, ModelConfig.of(made, (Port("ticking", taxels),)))
    try:
        with ring:
            begin(ring, made)
            yield ring
    finally:
        Ring.remove(made.name)


def begin(ring: Ring, made: LiveSettings) -> None:
    """What an engine says when it starts to answer."""
    tuning = Tuning(deadline=made.time_to_answer)
    ring.status["tuning"][:] = tuning.numbers([patch.name for patch in made.skin])
    ring.set_state(State.RUNNING)


def fill(
    ring: Ring, rng: np.random.Generator, stamp_ns: int, *forces: float, fresh: int = 1
) -> int:
    """A cycle with these contacts and a pressure by chance."""
    slot = Slot.of(ring.begin())
    slot.head[:] = 0
    slot.head[Head.FRESH], slot.head[Head.CONTACTS] = fresh, len(forces)
    slot.head[Head.WALL_NS] = stamp_ns
    rows = slot.patches
    rows["answer"], rows["rung"], rows["stamp_ns"] = int(Answer.LINEAR), 20, stamp_ns
    rows["contacts"], rows["force"], rows["gap"] = len(forces), sum(forces), np.nan
    for k, force in enumerate(forces):
        row = slot.contacts[0][k]
        row["track"], row["patch"], row["normal_force"] = k + 1, 0, force
        row["position"], row["normal"] = rng.normal(size=3), (0.0, 0.0, 1.0)
        row["x"], row["y"] = row["position"][:2]
        row["force_std"], row["place_std"], row["area"] = 0.1 * force, np.nan, 1e-4
    slot.counts[:] = rng.normal(200.0, 10.0, slot.counts.shape)
    slot.values[:] = rng.normal(0.0, 0.01, slot.values.shape)
    slot.valid[:] = 1
    slot.pressure[:] = rng.uniform(0.0, 1e4, slot.pressure.shape)
    return ring.publish()


@contextmanager
def publishing(session: Any, ring: Ring, part: Any, **values: Any) -> Iterator[Publisher]:
    with Live(ring.name) as live:
        publisher = Publisher(session, live, part, **values)
        with publisher.there():
            yield publisher
