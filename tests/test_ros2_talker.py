"""When messages are sent: each reading once, none more often than asked for."""

from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ros2_ring import TwoPatches, contact

from skinfield.bridges.ros2 import messages
from skinfield.bridges.ros2.messages import LOOKS, Speaker, Talker
from skinfield.files.ros import RosbagKinds
from skinfield.loop.client import Live, NotRunning
from skinfield.ring import State

TOUCH = [contact(0, 7, 2.0, (0.01, 0.0, 0.0))]
STAMP = 1_700_000_000_000_000_000


@pytest.fixture
def engine():
    with TwoPatches() as made:
        yield made


def talker_of(live, rates, heard):
    return Talker(live, Speaker(live.skin, RosbagKinds()), rates, heard.append)


def test_each_reading_once(engine):
    """Two cycles of three have no new reading; of the palm there is one each time."""
    heard = []
    with Live(engine.ring.name) as live:
        talker = talker_of(live, {"wrench": 1e4, "contacts": 1e4, "taxels": 1e-3}, heard)
        for number in range(30):
            engine.cycle(TOUCH, (STAMP + number // 3, STAMP))
            talker.step(LOOKS if number % 2 else 0.0)
        for _ in range(3):
            talker.step(0.0)
    counts = Counter(out.topic for out in heard)
    assert counts["/skin/left_palm/taxels"] == 1
    assert counts["/skin/patch_2nd_finger/wrench"] == 1
    palm = [out.stamp_ns - STAMP for out in heard if out.topic == "/skin/left_palm/wrench"]
    assert palm == sorted(set(palm))
    assert palm[-1] == 9
    assert len(palm) == counts["/skin/contacts"]


def test_without_answers_only_the_health_is_told(engine):
    heard = []
    with Live(engine.ring.name) as live:
        talker = talker_of(live, {"wrench": 1e4, "diagnostics": 1e4}, heard)
        engine.cycle(TOUCH)
        engine.ring.set_state(State.FAILED)
        for _ in range(3):
            talker.step(0.0)
        assert {out.topic for out in heard} == {"/diagnostics"}
        assert heard[-1].message.status[0].level == 2


def test_it_goes_on_after_a_crash_of_the_engine(engine):
    heard = []
    with Live(engine.ring.name) as live:
        talker = talker_of(live, {"wrench": 1e4, "diagnostics": 1e4}, heard)
        engine.cycle(TOUCH, (STAMP, STAMP))
        talker.step(LOOKS)
        engine.reopen()
        engine.cycle(TOUCH, (STAMP + 1, STAMP + 1))
        talker.step(LOOKS)
    palm = [out.stamp_ns - STAMP for out in heard if out.topic == "/skin/left_palm/wrench"]
    assert palm == [0, 1]
    told = [out.message.status[0] for out in heard if out.topic == "/diagnostics"]
    assert [{v.key: v.value for v in row.values}["restarts"] for row in told] == ["0", "1"]


def test_another_skin_of_that_name(engine):
    with Live(engine.ring.name) as live:
        talker = talker_of(live, {"diagnostics": 1e4}, [])
        talker.step()
        name = engine.ring.name
        engine.close()
        other = TwoPatches(name)
        try:
            with pytest.raises(NotRunning, match="connect again"):
                talker.step()
        finally:
            engine.ring = other.ring  # closed by the fixture


@given(st.lists(st.floats(1e-4, 0.5), min_size=1, max_size=60), st.floats(0.5, 500.0))
def test_pace(steps, rate):
    """Never more than the rate over any time, but for one more; nothing due is forgotten."""
    live = SimpleNamespace(
        reader=SimpleNamespace(replaced=lambda: False), name="n", state=State.STOPPED
    )
    now, done = [100.0], []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(messages, "Observer", lambda *_, **__: SimpleNamespace(look=lambda: None))
        patch.setattr(messages, "FitReader", lambda _: None)
        patch.setattr(messages.time, "monotonic", lambda: now[0])
        speaker = SimpleNamespace(of_status=lambda *_: now[0])
        talker = Talker(live, speaker, {"diagnostics": rate, "wrench": 0.0}, done.append)
        for step in steps:
            assert 0.0 <= talker.wait() <= LOOKS
            talker.step()
            assert now[0] < done[-1] + 1.0 / rate + 1e-9
            now[0] += step
    times = np.array(done)
    for first in range(len(times)):
        passed = times[first:] - times[first]
        assert (np.arange(len(passed)) <= passed * rate + 1 + 1e-6).all()
