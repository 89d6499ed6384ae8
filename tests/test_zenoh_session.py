"""Sessions of zenoh: addresses, certificates, and that denied is denied."""

import re
import shutil
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from live_skins import wait_for

from skinfield.errors import InputError
from skinfield.settings import from_plain, json_from_value, value_from_json

pytest.importorskip("zenoh")
from zenoh_peers import free_port, listening

from skinfield.bridges.zenoh import session as sessions
from skinfield.bridges.zenoh.session import ZenohSettings, open_session

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


def made_by_the_docs(folder: Path, who: str, of: str, port: int) -> ZenohSettings:
    """The docs' file for an engine or a viewer, with the certificate of somebody, at a port."""
    blocks = re.findall(r"```json5\n// (\w+)\.json5.*?\n(.*?)```", DOCS.read_text(), re.DOTALL)
    text = dict(blocks)[who].replace("7447", str(port)).replace(f"{who}.", f"{of}.")
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
    with open_session(made_by_the_docs(folder, "engine", of, port)) as session:

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
        reader(made_by_the_docs(folder, "viewer", "viewer", port)) as found,
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
        stranger = made_by_the_docs(folder, "viewer", "stranger", port)
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
        settings = made_by_the_docs(folder, "viewer", "viewer", port)
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
