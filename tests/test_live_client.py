"""What a reader of a ring gets, cycle by cycle; the ring is filled here."""

import sys
import threading
from collections.abc import Iterator

import numpy as np
import pytest
from live_skins import settings
from numpy.testing import assert_array_equal

from skinfield.acquisition import Port
from skinfield.live.client import Live
from skinfield.live.recipe import Recipe
from skinfield.live.ring_fields import open_ring
from skinfield.live.slots import Head, Slot
from skinfield.ring import Ring

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")


@pytest.fixture
def ring() -> Iterator[Ring]:
    made = settings()
    found, _ = open_ring(made, Recipe.of(made, (Port("ticking", 72),)))
    try:
        with found:
            yield found
    finally:
        Ring.remove(made.name)


def publish(ring: Ring, *forces: float, fresh: int = 1) -> int:
    """A cycle with contacts of these forces."""
    slot = Slot.of(ring.begin())
    slot.head[Head.FRESH], slot.head[Head.CONTACTS] = fresh, len(forces)
    slot.patches["contacts"], slot.patches["answer"] = len(forces), 3
    slot.contacts[0]["normal_force"][: len(forces)] = forces
    slot.counts[:] = ring.number
    return ring.publish()


def test_the_cycle_of_the_contact_is_the_one_that_is_returned(ring: Ring) -> None:
    publish(ring)
    found = []
    with Live(ring.name) as live:
        waiting = threading.Thread(target=lambda: found.append(live.wait_contact(60.0, force=1.0)))
        waiting.start()
        publish(ring, 0.5)
        wanted = publish(ring, 0.25, 1.5)
        waiting.join()
    (snapshot,) = found
    assert snapshot is not None
    assert snapshot.number == wanted
    assert_array_equal(snapshot.contacts["normal_force"], [0.25, 1.5])


def test_what_was_returned_does_not_change_later(ring: Ring) -> None:
    publish(ring, 2.0)
    with Live(ring.name) as live:
        first = live.wait_contact(60.0)
        assert first is not None
        readings = first.readings.copy()
        publish(ring, 3.0)
        second = live.wait_contact(60.0)
        assert second is not None
        assert_array_equal(first.readings, readings)
        assert first.patches["contacts"][0] == 1
        assert first.contacts["normal_force"][0] == 2.0
        assert second.contacts["normal_force"][0] == 3.0
        assert not np.array_equal(second.readings, readings)


def test_a_loop_passes_over_cycles_without_a_new_reading(ring: Ring) -> None:
    first = publish(ring)
    with Live(ring.name) as live:
        loop = iter(live)
        assert next(loop).number == first
        publish(ring, fresh=0)
        found = []
        waiting = threading.Thread(target=lambda: found.append(next(loop)))
        waiting.start()
        third = publish(ring)
        waiting.join()
    assert [each.number for each in found] == [third]
