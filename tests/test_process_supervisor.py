"""Processes that are started again, which of them people hear, and that they end at once."""

import subprocess
import sys
import threading
import time

import pytest
from live_skins import unique_name, wait_for

from skinfield.bridges.launch import Bridge
from skinfield.errors import InputError
from skinfield.loop import process_supervisor
from skinfield.loop.process_supervisor import Child, FitProcess, SupervisedProcess, exit_text
from skinfield.settings import BridgeSettings

LONG = 600.0  # s: on a busy machine
SLEEPS, FAILS = "import time; time.sleep(1000)", "raise SystemExit(3)"


class Script(SupervisedProcess):
    def __init__(self, *scripts: str) -> None:
        super().__init__("the script")
        self.scripts = list(scripts)

    def spawn(self) -> Child:
        script = self.scripts.pop(0) if len(self.scripts) > 1 else self.scripts[0]
        if not script:
            raise OSError("no process is left")
        return subprocess.Popen([sys.executable, "-c", script], process_group=0)


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SupervisedProcess, "poll", 0.01)
    monkeypatch.setattr(SupervisedProcess, "pauses", (0.0, 0.01))


def test_what_ends_is_started_again_and_told_once(impatient: None) -> None:
    with Script(FAILS, "", FAILS, SLEEPS) as script:
        script.begin()
        script.watch()
        wait_for(lambda: script.restarts == 3 and not script.failure, LONG)
        assert script.child is not None
        child = script.child
        assert script.notices() == [
            "the script ended with status 3; it is started again",
            "the script could not be started: no process is left; it is tried again every 0.01 s",
        ]
        assert script.notices() == []
    assert child.returncode == -15
    assert not script._thread.is_alive()


def test_what_goes_well_for_long_is_told(impatient: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process_supervisor, "SETTLED", 0.0)
    said: list[str] = []
    with Script("", "", SLEEPS) as script:
        with pytest.raises(InputError, match="no process is left"):
            script.begin()
        script.failure = "it was not there"
        script.watch()

        def is_there() -> bool:
            said.extend(script.notices())
            return bool(said) and said[-1] == "the script is there again"

        wait_for(is_there, LONG)
        assert script.restarts == 2


@pytest.mark.parametrize(
    ("code", "said"), [(1, "status 1"), (-9, "signal SIGKILL"), (-99, "signal 99")]
)
def test_how_a_process_ended(code: int, said: str) -> None:
    assert exit_text(code) == said


def test_a_bridge_that_never_answers_does_not_hold_up_the_end() -> None:
    class Silent(Bridge):
        def spawn(self) -> Child:
            pipe = subprocess.PIPE
            return subprocess.Popen([sys.executable, "-c", SLEEPS], stdin=pipe, stdout=pipe)

    bridge = Silent("zenoh", "nobody", BridgeSettings())
    failures: list[str] = []

    def begin() -> None:
        try:
            bridge.begin()
        except InputError as error:
            failures.append(str(error))

    thread = threading.Thread(target=begin)
    with bridge:
        thread.start()
        wait_for(lambda: bridge.child is not None, LONG)
        child = bridge.child
        assert child is not None
        began = time.monotonic()
        bridge.stopping.set()
        thread.join(LONG)
        assert time.monotonic() - began < 90.0  # half of what it would be waited for
    assert child.returncode is not None
    assert failures == ["the bridge to zenoh did not start: all was told to end"]


def test_a_fit_that_dies_is_started_again(impatient: None) -> None:
    with FitProcess(unique_name()) as fit:
        first = fit.child
        assert first is not None
        first.kill()
        wait_for(lambda: fit.restarts == 1 and fit.child is not None, LONG)
        second = fit.child
        assert fit.notices() == ["the contact fit ended with signal SIGKILL; it is started again"]
    assert first.returncode == -9
    assert second is not None
    assert second.returncode is not None
