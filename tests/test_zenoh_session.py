"""Sessions of zenoh: addresses, certificates, and that denied is denied."""

import re
import shutil
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from live_skins import wait_for

from skinfield.errors import InputError
from skinfield.settings import from_plain, json_from_value, value_from_json

pytest.importorskip("zenoh")
from zenoh_peers import free_port, listening

from skinfield.bridges.zenoh import session as sessions
from skinfield.bridges.zenoh.session import Access, Tls, ZenohSettings, open_session

DOCS = Path(__file__).resolve().parents[1] / "docs" / "zenoh.md"
KEY = "skinfield/robot/part/estimate"
ASKED = "skinfield/robot/part/description"
TOKEN = "skinfield/robot/part/alive"
OTHER = "elsewhere/robot"
LONG, QUIET = 60.0, 0.4  # s


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Certificates, made by what the docs say, and one of a name that nobody lets in."""
    if shutil.which("openssl") is None or shutil.which("sh") is None:
        pytest.skip("no program openssl here to make certificates with")
    made = tmp_path_factory.mktemp("certificates")
    (block,) = re.findall(r"```sh\n(openssl.*?)```", DOCS.read_text(), re.DOTALL)
    script = block.replace("engine viewer", "engine viewer stranger")
    subprocess.run(["sh", "-e", "-c", script], cwd=made, check=True, capture_output=True)
    return made


def tls(folder: Path, name: str | None, **values: Any) -> Tls:
    own = {} if name is None else {
        "certificate": folder / f"{name}.pem", "key": folder / f"{name}.key",
    }  # fmt: skip
    return Tls(ca=folder / "ca.pem", **own, **values)


class Engine:
    """What a publisher does, on a session."""

    def __init__(self, session: Any) -> None:
        self.session = session
        self.heard: list[bytes] = []
        self.token = session.liveliness().declare_token(TOKEN)
        self.answers = session.declare_queryable(ASKED, self._answer)
        self.ear = session.declare_subscriber(
            "skinfield/**", lambda sample: self.heard.append(sample.payload.to_bytes())
        )
        self.stop = threading.Event()
        self.thread = threading.Thread(target=self._publish)
        self.thread.start()

    def _answer(self, query: Any) -> None:
        with query:
            query.reply(ASKED, b"described")

    def _publish(self) -> None:
        while not self.stop.wait(0.02):
            self.session.put(KEY, b"mine")
            self.session.put(OTHER, b"mine")

    def end(self) -> None:
        self.stop.set()
        self.thread.join()


class Reader:
    """What a reader gets."""

    def __init__(self, session: Any) -> None:
        self.session = session
        self.got: list[tuple[str, bytes]] = []
        self.ears = [
            session.declare_subscriber(key, self._take, allowed_origin=_remote())
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


def _remote() -> Any:
    import zenoh

    return zenoh.Locality.REMOTE


@contextmanager
def engine(**values: Any) -> Iterator[tuple[Engine, str]]:
    with listening(**values) as (session, address):
        made = Engine(session)
        try:
            yield made, address
        finally:
            made.end()


@contextmanager
def reader(settings: ZenohSettings) -> Iterator[Reader]:
    with open_session(settings) as session:
        yield Reader(session)


def gets_nothing(found: Reader) -> None:
    """Long enough for it to arrive, if it could."""
    time.sleep(QUIET)
    assert found.got == []
    assert found.answers() == []
    assert found.tokens() == []


def test_the_right_certificate_gets_all_that_is_allowed(folder) -> None:
    with (
        engine(tls=tls(folder, "engine"), access=Access(read=("viewer",))) as (made, address),
        reader(ZenohSettings(connect=(address,), tls=tls(folder, "viewer"))) as found,
    ):
        wait_for(lambda: KEY in found.seen(), LONG)
        wait_for(lambda: found.answers() == [b"described"], LONG)
        wait_for(lambda: found.tokens() == [TOKEN], LONG)
        time.sleep(QUIET)
        assert found.seen() == {KEY}  # and no other key
        made.heard.clear()
        found.session.put(KEY, b"forged")  # a reader has no right to write
        time.sleep(QUIET)
        assert set(made.heard) == {b"mine"}


@pytest.mark.parametrize("who", ["none", "plain", "stranger"])
def test_without_the_right_certificate_there_is_nothing(folder, who) -> None:
    access = Access(read=("viewer",))
    with engine(tls=tls(folder, "engine"), access=access) as (_, address):
        if who == "plain":
            settings = ZenohSettings(connect=(address.replace("tls/", "tcp/"),))
        else:
            its = tls(folder, None if who == "none" else who)
            settings = ZenohSettings(connect=(address,), tls=its)
        with reader(settings) as found:
            others = found.session.info.peers_zid
            if who == "stranger":
                wait_for(others, LONG)  # is let in, and denied all
            gets_nothing(found)
            assert len(others()) == (who == "stranger")


def test_only_who_may_write_is_believed(folder) -> None:
    """A viewer that listens, an engine, and one with a certificate that is no engine's."""
    access = Access(write=("engine",))
    with listening(tls=tls(folder, "viewer"), access=access) as (session, address):
        found = Reader(session)
        there = {"connect": (address,)}
        with open_session(ZenohSettings(**there, tls=tls(folder, "stranger"))) as stranger:
            for _ in range(20):
                stranger.put(KEY, b"forged")
                time.sleep(0.02)
            with open_session(ZenohSettings(**there, tls=tls(folder, "engine"))) as own:

                def comes() -> bool:
                    own.put(KEY, b"true")
                    stranger.put(KEY, b"forged")
                    return bool(found.got)

                wait_for(comes, LONG)
                time.sleep(QUIET)
        assert set(found.got) == {(KEY, b"true")}


def test_the_files_of_the_docs_do_the_same(folder) -> None:
    port = free_port()
    blocks = re.findall(r"```json5\n// (\w+)\.json5.*?\n(.*?)```", DOCS.read_text(), re.DOTALL)
    for name, text in blocks:
        text = re.sub(r'"([a-z]+\.(?:pem|key))"', rf'"{folder}/\1"', text)
        (folder / f"{name}.json5").write_text(text.replace("7447", str(port)))
    assert [name for name, _ in blocks] == ["engine", "viewer"]
    with open_session(ZenohSettings(config=folder / "engine.json5")) as session:
        made = Engine(session)
        try:
            with reader(ZenohSettings(config=folder / "viewer.json5")) as found:
                wait_for(lambda: KEY in found.seen(), LONG)
                wait_for(lambda: found.tokens() == [TOKEN], LONG)
                assert found.seen() == {KEY}
            stranger = (folder / "viewer.json5").read_text().replace("viewer.", "stranger.")
            (folder / "stranger.json5").write_text(stranger)
            with reader(ZenohSettings(config=folder / "stranger.json5")) as found:
                gets_nothing(found)
        finally:
            made.end()


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
    for name in ("ca.pem", "viewer.pem", "viewer.key"):
        (tmp_path / name).touch()
    made = ZenohSettings(
        mode="client", connect=("robot:7447",), tls=tls(tmp_path, "viewer", mutual=False),
        access=Access(read=("a", "b")), config=tmp_path / "ca.pem", compression=True,
    )  # fmt: skip
    assert made.connect == ("tls/robot:7447",)
    assert value_from_json(ZenohSettings, json_from_value(made)) == made
    assert value_from_json(ZenohSettings, json_from_value(ZenohSettings())) == ZenohSettings()


@pytest.mark.parametrize(
    ("values", "match"),
    [
        ({"listen": ("7447",)}, "expected an address such as"),
        ({"connect": ("tcp/a b:1",)}, "expected an address such as"),
        ({"listen": "tcp/robot:1"}, "expected a tuple"),
        ({"mode": "boss"}, "mode is 'boss'"),
        ({"config": Path("nowhere.json5")}, "expected a file of zenoh's settings"),
    ],
)
def test_settings_that_cannot_be_say_why(values, match) -> None:
    with pytest.raises(InputError, match=match):
        ZenohSettings(**values)


def test_strange_settings_and_files_are_refused(tmp_path) -> None:
    with pytest.raises(InputError, match=r"'lisen' is not known, .*did you mean listen"):
        from_plain(ZenohSettings, {"lisen": []})
    with pytest.raises(InputError, match="a PEM file that exists"):
        Tls(ca=tmp_path / "ca.pem")
    bad = tmp_path / "bad.json5"
    bad.write_text("{mode: 7}")
    with (
        pytest.raises(InputError, match="zenoh cannot start"),
        open_session(ZenohSettings(config=bad)),
    ):
        pass


def test_an_address_in_use_is_said() -> None:
    with (
        listening() as (_, address),
        pytest.raises(InputError, match="zenoh cannot start"),
        open_session(ZenohSettings(listen=(address,))),
    ):
        pass
