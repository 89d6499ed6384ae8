"""A live skin over zenoh: what arrives is what the ring holds, and what is gone is told."""

import json
import time
from collections.abc import Iterator
from contextlib import closing
from types import SimpleNamespace

import numpy as np
import pytest
from live_skins import begin, fill, settings, skin_ring, unique_name, wait_for
from numpy.testing import assert_allclose, assert_array_equal

import skinfield as sf
from skinfield.files.layouts.load import load_layout
from skinfield.loop.client import Live, Stale
from skinfield.loop.model_config import ModelConfig
from skinfield.loop.ring_fields import open_ring
from skinfield.signal import Port
from skinfield.skin import Skin

pytest.importorskip("zenoh")
from zenoh_peers import joined, publishing

from skinfield.bridges.zenoh import publisher as publishers
from skinfield.bridges.zenoh import source as source_module
from skinfield.bridges.zenoh.discovery import ZenohSources
from skinfield.bridges.zenoh.messages import EstimateHead
from skinfield.bridges.zenoh.session import Keys
from skinfield.bridges.zenoh.source import Delay
from skinfield.errors import InputError

LONG = 180.0  # s


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Iterator[SimpleNamespace]:
    """A ring, its publisher in one session, and the sources of another, which are patient."""
    monkeypatch.setattr(source_module, "GONE", LONG)
    rng = np.random.default_rng(3)
    with skin_ring() as ring, joined() as (here, there), closing(ZenohSources(there)) as sources:
        part = Keys("robot", ring.name)
        with publishing(here, ring, part, rate=1e6) as publisher:
            yield SimpleNamespace(
                ring=ring, here=here, there=there, part=part, sources=sources,
                publisher=publisher, rng=rng,
            )  # fmt: skip


def source_of(scene: SimpleNamespace):
    return wait_for(lambda: scene.sources.sources(), LONG)[0]


def arrived(scene: SimpleNamespace, *forces: float, stamp_ns: int | None = None):
    """A snapshot of a new cycle on the other side."""
    source, stamp = source_of(scene), time.time_ns() if stamp_ns is None else stamp_ns
    wait_for(lambda: scene.publisher._outlets.wanted("estimate"), LONG)
    number = fill(scene.ring, scene.rng, stamp, *forces)
    scene.publisher.step()

    def there():
        found = source.latest()
        return found if found is not None and found.number == number else None

    return wait_for(there, LONG)


def published(scene: SimpleNamespace, what: str, *forces: float) -> tuple[int, list]:
    """A cycle's number and what is sent of it: for the whole skin, and for its patch."""
    outlets, got = scene.publisher._outlets, {}
    keys = scene.part.key(what), scene.part.patch_key("hexagon72", what)
    subscribers = [
        scene.there.declare_subscriber(key, lambda s: got.setdefault(str(s.key_expr), s))
        for key in keys
    ]  # each is known here by itself, in any order
    wait_for(lambda: outlets.wanted(what) and outlets.wanted(what, 0), LONG)
    number = fill(scene.ring, scene.rng, 10**18, *forces)
    scene.publisher.step()
    wait_for(lambda: len(got) == 2, LONG)
    for each in subscribers:
        each.undeclare()
    wait_for(lambda: not outlets.wanted(what, 0), LONG)
    return number, [got[key] for key in keys]


def test_a_snapshot_there_is_the_cycle_here_bit_for_bit(scene) -> None:
    found = arrived(scene, 1.5, 0.25)
    with Live(scene.ring.name) as live:
        own = live.latest()
        assert found.number == own.number
        for name in ("head", "counts", "values", "valid", "pressure", "patches"):
            a, b = getattr(found.slot, name), getattr(own.slot, name)
            assert a.tobytes() == b.tobytes(), name
        assert found.contacts.tobytes() == own.contacts.tobytes()
        assert [*found] == [*own] == ["hexagon72"]
        assert_array_equal(found["hexagon72"].pressure, own["hexagon72"].pressure)
        assert_array_equal(found.taxels("hexagon72")[0], own.taxels("hexagon72")[0])
    assert found.force == pytest.approx(1.75)
    source = source_of(scene)
    assert source.name == f"robot/{scene.ring.name}"
    assert source.status()["state"] == "running"
    assert source.refused == 0


def test_age_is_by_the_clock_of_the_sender(scene) -> None:
    """A reading that was 5 s old when it was sent is so there, whatever the clocks say."""
    source = source_of(scene)
    found = arrived(scene, stamp_ns=time.time_ns() - 5_000_000_000)
    assert 5.0 <= found.age < 5.0 + LONG
    head = EstimateHead(1, 1, 10**18, 10**18 + 250_000_000, 0, 0, source.plan.fingerprint)
    source._delay = Delay()  # of a computer whose clock is years off
    source.take_estimate(head.packed(), scene.publisher._octets.tobytes())
    age = (source._received.wall_ns - 10**18) * 1e-9
    assert 0.25 <= age < 0.25 + LONG


def test_a_message_that_took_longer_is_older() -> None:
    delay, years = Delay(), 1e8  # s between two clocks
    assert delay.excess(years + 0.003, 0.0) == 0.0
    assert delay.excess(years + 0.050, 1.0) == pytest.approx(0.047, abs=1e-7)
    assert delay.excess(years + 0.001, 2.0) == 0.0
    assert delay.excess(years + 0.003, 3.0) == pytest.approx(0.002, abs=1e-7)
    assert delay.excess(years + 0.003, 1000.0) == 0.0  # as clocks drift apart


def test_contacts_are_plain_json_of_the_ring(scene) -> None:
    number, samples = published(scene, "contacts", 2.0)
    with Live(scene.ring.name) as live:
        row = live.latest().contacts[0]
    for sample in samples:
        plain = json.loads(sample.payload.to_bytes())
        head = EstimateHead.of(sample.attachment.to_bytes())
        assert (plain["number"], plain["stamp_ns"]) == (number, 10**18)
        assert (head.number, head.stamp_ns) == (number, 10**18)
        assert plain["relative"] is False
        (contact,) = plain["contacts"]
        assert contact["patch"] == "hexagon72"
        assert contact["track"] == 1
        assert (contact["shape"], contact["maybe"], contact["radius"]) == ("other", False, 0.0)
        assert_allclose(contact["position"], row["position"], rtol=0, atol=0)
        assert contact["force"] == [0.0, 0.0, -2.0]  # pressed onto the skin, whose normal is +z
        assert contact["force_std"] == pytest.approx(0.2)
        assert contact["place_std"] is None  # what is not known is null, not NaN


def test_raw_counts_arrive_for_the_whole_and_for_a_patch(scene) -> None:
    _, samples = published(scene, "raw")
    with Live(scene.ring.name) as live:
        for sample in samples:
            counts = np.frombuffer(sample.payload.to_bytes(), "<f4")
            assert_array_equal(counts, live.latest().readings)


def test_layout_status_and_health_answer_queries(scene, tmp_path) -> None:
    def ask(what: str) -> bytes:
        (reply,) = scene.there.get(scene.part.key(what), timeout=LONG)
        return reply.ok.payload.to_bytes()

    source_of(scene)
    path = tmp_path / "layout.toml"
    for what in ("layout", "patch/hexagon72/layout"):
        path.write_bytes(ask(what))
        found = load_layout(path)
        assert [patch.name for patch in found] == ["hexagon72"]
        assert_allclose(found[0].positions, sf.layouts.hexagon72().positions, atol=1e-12)
    assert json.loads(ask("status"))["state"] == "running"
    health = json.loads(ask("health"))
    assert health["tares"] == health["restarts"] == health["lost"] == 0
    assert health["sources"] == {"Ticking": dict.fromkeys(health["sources"]["Ticking"], 0)}
    told = json.loads(ask("description"))
    assert told["ring"]["patches"] == ["hexagon72"]
    assert "source_settings" not in told["ring"]  # how boards are connected stays here


def test_estimates_keep_to_the_rate_and_the_newest_wins() -> None:
    rng, numbers = np.random.default_rng(5), []
    with skin_ring() as ring, joined() as (here, there):
        part = Keys("robot", ring.name)
        with publishing(here, ring, part, rate=1.0 / LONG) as publisher:
            there.declare_subscriber(
                part.key("estimate"),
                lambda s: numbers.append(EstimateHead.of(s.attachment.to_bytes()).number),
            )
            wait_for(lambda: publisher._outlets.wanted("estimate"), LONG)
            for _ in range(5):  # the first goes at once, and the second: one is in hand
                fill(ring, rng, 10**18)
                publisher.step()
            assert publisher._owed

            def newer() -> bool:
                fill(ring, rng, 10**18)  # again and again: a network may drop what is sent
                publisher._next = 0.0  # the time has come
                publisher.step()
                return bool(numbers) and numbers[-1] > 5

            wait_for(newer, LONG)
            assert not {3, 4, 5} & set(numbers)


def test_an_engine_that_ends_is_gone_and_comes_back(scene) -> None:
    assert arrived(scene, 1.0).patches["answer"][0] != 0
    source, ring = source_of(scene), scene.ring
    ring.close()  # as the system does when the engine is killed
    scene.publisher._status = 0.0
    scene.publisher.step()
    wait_for(lambda: source.gone, LONG)
    told = source.status()
    assert told["state"] == "failed"
    assert [(each["answer"], each["stale"]) for each in told["patches"]] == [("missing", True)]
    missing = source.latest()
    assert [*missing] == []
    assert len(missing.contacts) == 0
    with pytest.raises(Stale, match="no answer"):
        missing["hexagon72"]
    made = settings(name=ring.name)
    scene.ring, new = open_ring(made, ModelConfig.of(made, (Port("ticking", 72),)))
    assert not new
    with scene.ring:
        begin(scene.ring, made)
        scene.publisher._status = 0.0
        assert arrived(scene, 2.0).force == 2.0
        assert source_of(scene) is source
        scene.publisher._status = 0.0
        scene.publisher.step()
        wait_for(lambda: source.status()["state"] == "running", LONG)


def test_nothing_for_a_second_is_gone_too(scene) -> None:
    arrived(scene, 1.0)
    source = source_of(scene)
    assert not source.gone
    source._heard -= 2 * LONG
    assert source.gone
    assert source.status()["notes"]["remote"] == "nothing comes from it any more"


def test_another_baseline_brings_its_noise(scene) -> None:
    arrived(scene)
    source, status = source_of(scene), scene.ring.status
    noise = np.linspace(1e-3, 2e-3, 72)
    status["noise_std"][:], status["tares"][0] = noise, 1
    arrived(scene)
    wait_for(lambda: not source.needs_calibration, LONG)
    found = arrived(scene)
    assert_array_equal(found.taxels("hexagon72")[2], noise)


def test_another_skin_under_the_same_name_is_another_source() -> None:
    rng, name = np.random.default_rng(7), unique_name()
    pair = Skin((sf.layouts.hexagon72(), sf.layouts.icub_triangle()), name="pair")
    with joined() as (here, there), closing(ZenohSources(there)) as sources:
        part, seen = Keys("robot", name), []
        for skin in (sf.layouts.hexagon72(), pair):
            made = settings(name=name, skin=skin)
            with skin_ring(made) as ring, publishing(here, ring, part, rate=1e6) as publisher:

                def comes(ring=ring, publisher=publisher):
                    fill(ring, rng, time.time_ns())
                    publisher.step()
                    found = sources.sources()
                    new = found and found[0] not in seen and found[0].latest()
                    return found[0] if new else None

                seen.append(wait_for(comes, LONG))
        assert [len(source.skin) for source in seen] == [1, 2]
        assert sources.sources() == (seen[1],)


def test_what_makes_no_sense_is_refused_and_counted(scene) -> None:
    arrived(scene, 1.0)
    source = source_of(scene)
    head = scene.publisher._head(scene.publisher._taken)
    good = scene.publisher._octets.tobytes()
    bad = bytearray(good)
    patches = source.plan.layout.fields[1].offset
    bad[patches : patches + 4] = (77).to_bytes(4, "little")  # no such answer
    wait_for(lambda: source.latest() is not None, LONG)
    kept = source.latest().number
    for payload, attachment in (
        (good[:-1], head), (good, head[:-1]), (good, None), (b"", head), (bytes(bad), head),
    ):  # fmt: skip
        before = source.refused
        scene.here.put(scene.part.key("estimate"), payload, attachment=attachment)
        wait_for(lambda before=before: source.latest() and source.refused > before, LONG)
        assert source.latest().number == kept
    for text in (b"", b"[]", b'{"state": "fine"}', b"[" * 100_000, b'{"state": NaN}'):
        before = source.refused
        scene.here.put(scene.part.key("status"), text)
        wait_for(lambda before=before: source.refused > before, LONG)
    assert "10 messages" in source.status()["notes"]["refused"]
    assert arrived(scene, 1.0).force == 1.0


def test_two_engines_of_one_name_are_refused(scene, monkeypatch) -> None:
    monkeypatch.setattr(publishers, "TAKEN", 0.0)
    source_of(scene)
    with pytest.raises(InputError, match="published already"):
        publishers.check_free(scene.there, scene.part)
    publishers.check_free(scene.there, Keys("robot", "other"))
