"""Sessions of zenoh: certificates, that denied is denied, and engines in their own processes."""

import os
import re
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from live_skins import fill, skin_ring, unique_name, wait_for

from skinfield.bridges.launch import bridge_settings, bridges
from skinfield.bridges.settings import BridgeSettings
from skinfield.errors import InputError
from skinfield.ring import Ring
from skinfield.settings import from_plain, json_from_value, value_from_json

pytest.importorskip("zenoh")
from zenoh_peers import free_port, listening

from skinfield.bridges.zenoh import session as sessions
from skinfield.bridges.zenoh.discovery import ZenohSources
from skinfield.bridges.zenoh.session import ZenohSettings, open_session

TESTS = Path(__file__).resolve().parent
FILES = TESTS.parent / "examples" / "zenoh"
KEY = "skinfield/robot/part/estimate"
ASKED = "skinfield/robot/part/description"
TOKEN = "skinfield/robot/part/alive"
OTHER = "elsewhere/robot"
LONG, QUIET = 600.0, 0.4  # s: on a busy machine, and what is long enough otherwise


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Certificates, made by the example, and one of a name that nobody lets in."""
    if shutil.which("openssl") is None or shutil.which("sh") is None:
        pytest.skip("no program openssl here to make certificates with")
    made = tmp_path_factory.mktemp("certificates")
    script = ["sh", FILES / "certificates.sh", "engine", "viewer", "stranger"]
    subprocess.run(script, cwd=made, check=True, capture_output=True)
    return made


def made_by_the_example(folder: Path, who: str, of: str, port: int) -> ZenohSettings:
    """The example's file for an engine or a viewer, with somebody's certificate, at a port."""
    text = (FILES / f"{who}.json5").read_text()
    text = text.replace("7447", str(port)).replace(f"{who}.", f"{of}.")
    path = folder / f"{who}-{of}-{port}.json5"
    path.write_text(re.sub(r'"([a-z]+\.(?:pem|key))"', rf'"{folder}/\1"', text))
    return ZenohSettings(config=path)


class Reader:
    """What a reader gets."""

    def __init__(self, session: Any) -> None:
        import zenoh

        self.session = session
        self.got: list[tuple[str, bytes]] = []
        self.ears = [
            session.declare_subscriber(key, self._take, allowed_origin=zenoh.Locality.REMOTE)
            for key in ("skinfield/*/*/estimate", "elsewhere/**")
        ]

    def _take(self, sample: Any) -> None:
        self.got.append((str(sample.key_expr), sample.payload.to_bytes()))

    def seen(self) -> set[str]:
        return {key for key, _ in self.got}

    def answers(self) -> list[bytes]:
        replies = self.session.get(ASKED, timeout=1.0)
        return [reply.ok.payload.to_bytes() for reply in replies if reply.ok]

    def tokens(self) -> list[str]:
        replies = self.session.liveliness().get("skinfield/*/*/alive", timeout=1.0)
        return [str(reply.ok.key_expr) for reply in replies if reply.ok]


@contextmanager
def engine(folder: Path, of: str = "engine") -> Iterator[tuple[list[bytes], int]]:
    """What a publisher does, on a session of its own: what it hears meanwhile, and its port."""
    port, stop, heard = free_port(), threading.Event(), []
    with open_session(made_by_the_example(folder, "engine", of, port)) as session:

        def answer(query: Any) -> None:
            with query:
                query.reply(ASKED, b"described")

        def publish() -> None:
            while not stop.wait(0.02):
                session.put(KEY, of)
                session.put(OTHER, of)

        _declared = (
            session.liveliness().declare_token(TOKEN),
            session.declare_queryable(ASKED, answer),
            session.declare_subscriber(
                "skinfield/**", lambda s: heard.append(s.payload.to_bytes())
            ),
        )
        thread = threading.Thread(target=publish)
        thread.start()
        try:
            yield heard, port
        finally:
            stop.set()
            thread.join()


@contextmanager
def reader(settings: ZenohSettings) -> Iterator[Reader]:
    with open_session(settings) as session:
        yield Reader(session)


def test_the_right_certificate_gets_all_that_is_allowed(folder) -> None:
    with (
        engine(folder) as (heard, port),
        reader(made_by_the_example(folder, "viewer", "viewer", port)) as found,
    ):
        wait_for(lambda: KEY in found.seen(), LONG)
        wait_for(lambda: found.answers() == [b"described"], LONG)
        wait_for(lambda: found.tokens() == [TOKEN], LONG)
        time.sleep(QUIET)
        assert found.seen() == {KEY}  # and no other key
        heard.clear()
        found.session.put(KEY, b"forged")  # a reader has no right to write
        time.sleep(QUIET)
        assert set(heard) == {b"engine"}


def test_without_the_right_certificate_there_is_nothing(folder) -> None:
    with engine(folder) as (_, port), ExitStack() as ends:
        stranger = made_by_the_example(folder, "viewer", "stranger", port)
        text = stranger.config.read_text()
        bare = folder / "bare.json5"
        bare.write_text(re.sub(r"connect_(certificate|private_key):.*\n", "", text))
        plain = ZenohSettings(connect=(f"tcp/localhost:{port}",))
        found = [
            ends.enter_context(reader(each))
            for each in (stranger, ZenohSettings(config=bare), plain)
        ]
        wait_for(found[0].session.info.peers_zid, LONG)  # is let in, and denied all
        time.sleep(QUIET)  # long enough for it to arrive, if it could
        for each in found:
            assert (each.got, each.answers(), each.tokens()) == ([], [], [])
        assert [len(each.session.info.peers_zid()) for each in found] == [1, 0, 0]


def test_only_who_may_write_is_believed(folder) -> None:
    """Beside an engine, somebody with a certificate of ours that is no engine's."""
    with engine(folder) as (_, port), engine(folder, "stranger") as (_, other):
        settings = made_by_the_example(folder, "viewer", "viewer", port)
        both = tuple(f"tls/localhost:{each}" for each in (port, other))
        with reader(replace(settings, connect=both)) as found:
            wait_for(lambda: len(found.session.info.peers_zid()) == 2, LONG)
            wait_for(lambda: found.got, LONG)
            time.sleep(QUIET)
            assert set(found.got) == {(KEY, b"engine")}


def test_without_an_address_programs_of_this_machine_meet(monkeypatch) -> None:
    monkeypatch.setattr(sessions, "MEETING", f"tcp/127.0.0.1:{free_port()}")
    got: list[bytes] = []
    with (
        open_session(ZenohSettings()) as first,
        open_session(ZenohSettings()) as second,
        open_session(ZenohSettings()) as third,
    ):
        second.declare_subscriber(KEY, lambda sample: got.append(sample.payload.to_bytes()))

        def both() -> bool:
            first.put(KEY, b"first")
            third.put(KEY, b"third")
            return {b"first", b"third"} <= set(got)

        wait_for(both, LONG)
        for session in (first, second, third):
            for link in session.info.links():
                assert {str(end).split(":")[0] for end in (link.src, link.dst)} == {"tcp/127.0.0.1"}
        first.close()  # where the others met: those that are there still know each other
        got.clear()
        wait_for(lambda: third.put(KEY, b"third") or got, LONG)
        with open_session(ZenohSettings()) as fourth:
            wait_for(lambda: fourth.put(KEY, b"fourth") or b"fourth" in got, LONG)


def test_settings_go_through_json(tmp_path) -> None:
    (file := tmp_path / "zenoh.json5").touch()
    made = ZenohSettings(connect=("robot:7447",), config=file)
    assert made.connect == ("tcp/robot:7447",)
    assert value_from_json(ZenohSettings, json_from_value(made)) == made


@pytest.mark.parametrize(
    ("values", "match"),
    [
        ({"listen": ("7447",)}, "expected an address such as"),
        ({"connect": ("tcp/a b:1",)}, "expected an address such as"),
        ({"listen": "tcp/robot:1"}, "expected a tuple"),
        ({"config": Path("nowhere.json5")}, "expected a file of zenoh's settings"),
    ],
)
def test_settings_that_cannot_be_say_why(values, match) -> None:
    with pytest.raises(InputError, match=match):
        ZenohSettings(**values)


def test_a_name_that_is_not_known_is_refused() -> None:
    with pytest.raises(InputError, match=r"'lisen' is not known, .*did you mean listen"):
        from_plain(ZenohSettings, {"lisen": []})


def test_strange_files_and_an_address_in_use_are_refused(tmp_path) -> None:
    bad = tmp_path / "bad.json5"
    bad.write_text("{mode: 7}")
    with listening() as (_, address):
        for wrong in (ZenohSettings(config=bad), ZenohSettings(listen=(address,))):
            with pytest.raises(InputError, match="zenoh cannot start"), open_session(wrong):
                pass


ROS2 = {"ros2": True}


@contextmanager
def engine_process(name: str, address: str) -> Iterator["subprocess.Popen[bytes]"]:
    command = [sys.executable, str(TESTS / "zenoh_peers.py"), name, "robot", address]
    child = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, env=os.environ | {"OMP_NUM_THREADS": "1"}
    )
    try:
        yield child
    finally:
        child.terminate()
        child.wait()
        with suppress(InputError):  # it is there only after a SIGKILL
            Ring.remove(name)


def states(sources: ZenohSources) -> list[str]:
    return [source.status()["state"] for source in sources.sources()]


def test_three_engines_are_one_skin_and_one_may_die() -> None:
    names = sorted(unique_name() for _ in range(3))
    with ExitStack() as ends:
        session, address = ends.enter_context(listening())
        sources = ZenohSources(session)
        ends.callback(sources.close)
        children = [ends.enter_context(engine_process(name, address)) for name in names]
        wait_for(lambda: states(sources) == ["running"] * 3, LONG)
        wait_for(
            lambda: [f.latest() and f.latest().force for f in sources.sources()] == [1.5] * 3, LONG
        )
        one = sources.sources()[1]
        assert one.name == f"robot/{names[1]}"
        children[1].kill()
        killed = time.monotonic()
        wait_for(lambda: one.status()["state"] == "failed", LONG)
        took = time.monotonic() - killed
        assert [*one.latest()] == []  # none of its patches has an answer
        assert one.latest().force == 0.0
        before = [source.latest().number for source in sources.sources()]
        others = [0, 2]
        wait_for(lambda: all(
            sources.sources()[k].latest().number > before[k] + 3 for k in others
        ), LONG)  # fmt: skip
        children[1].wait()
        Ring.remove(names[1])
        ends.enter_context(engine_process(names[1], address))
        wait_for(lambda: one.status()["state"] == "running" and one.latest().force == 1.5, LONG)
        assert took < LONG  # usually at once, as the system says that the connection ended
        assert sources.sources()[1] is one
        assert sources.notes == {}


def test_a_bridge_that_dies_is_started_again() -> None:
    rng = np.random.default_rng(2)
    with (
        skin_ring() as ring,
        listening() as (session, address),
        closing(ZenohSources(session)) as sources,
    ):
        given = BridgeSettings(zenoh=True, zenoh_connect=(address,))
        with bridges(given, ring.name) as made:
            (bridge,) = made
            assert bridge.facts["key"] == f"skinfield/robot/{ring.name}/**"
            (source,) = wait_for(sources.sources, LONG)

            def comes() -> bool:
                fill(ring, rng, time.time_ns(), 2.0)
                found = source.latest()
                return found is not None and found.force == 2.0

            wait_for(comes, LONG)
            bridge.child.kill()
            wait_for(lambda: source.status()["state"] == "failed", LONG)
            wait_for(lambda: bridge.restarts == 1 and not bridge.failure, LONG)
            said = "the bridge to zenoh ended with signal SIGKILL; it is started again"
            assert bridge.notices() == [said]
            assert bridge.notices() == []
            wait_for(lambda: source.status()["state"] == "running", LONG)
            wait_for(comes, LONG)
        wait_for(lambda: source.status()["state"] == "failed", LONG)


def test_a_bridge_that_cannot_start_says_why() -> None:
    with skin_ring() as ring, listening() as (_, address):
        given = BridgeSettings(zenoh=True, zenoh_listen=(address,))
        match = "bridge to zenoh did not start: zenoh cannot start"
        with pytest.raises(InputError, match=match), bridges(given, ring.name):
            pass


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"zenoh_listen": ("tcp/0.0.0.0:1",)}, "expected zenoh or ros2"),
        ({"ros_domain": 3}, "expected ros2"),
        ({"robot": "a/b"}, "robot is 'a/b'"),
        ({"zenoh": True, "zenoh_connect": ("robot",)}, "expected an address such as"),
        (ROS2 | {"ros_rate": ("wrench",)}, "such as wrench=500"),
        (ROS2 | {"ros_rate": ("force=5",)}, "expected one of contact_wrench, contacts"),
        (ROS2 | {"ros_rate": ("wrench=nan",)}, "messages a second"),
        ({"ros_rate": ("wrench=5",)}, "expected ros2 with it"),
        (ROS2 | {"robot": 80 * "a" + "b", "ros_domain": 3}, "robot is"),
    ],
)
def test_options_that_cannot_be_are_refused_before_anything_starts(given, match) -> None:
    bridge_settings(BridgeSettings(ros2=True, ros_rate=("wrench=500", "taxels=0"), ros_domain=3))
    with pytest.raises(InputError, match=match):
        bridge_settings(BridgeSettings(**given))


def test_a_missing_package_is_named(monkeypatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install 'skinfield\[zenoh\]'"):
        bridge_settings(BridgeSettings(zenoh=True))


def test_no_bridge_is_no_process() -> None:
    with bridges(BridgeSettings(), "nobody") as made:
        assert made == []
