"""`skinfield record` and `skinfield recover` as they are typed."""

import os
import signal
import subprocess
import sys
import time
import uuid

import pytest
from command_line import invoke
from mcap_sample import write
from recorder_ring import FakeEngine

from skinfield.files.mcap.live import LiveRecording
from skinfield.record.recorder import forget_state, read_state

PATIENCE = 60.0  # s
MAIN = "from skinfield.cli import main; main()"


@pytest.fixture
def engine():
    name = f"cli{uuid.uuid4().hex[:12]}"
    made = FakeEngine(name)
    yield made
    made.close()
    forget_state(name)


def run(*words: str, code: int = 0) -> str:
    found = invoke(list(words))
    assert found.exit_code == code, found.output
    return " ".join(found.output.split())


def test_record_until_ctrl_c(engine, tmp_path):
    """From a process of its own, as it asks for another priority."""
    path = tmp_path / "a.mcap"
    child = subprocess.Popen(
        [sys.executable, "-c", MAIN, "record", engine.ring.name, "-o", str(path)],
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"COLUMNS": "200"},
    )
    try:
        end = time.monotonic() + PATIENCE
        while read_state(engine.ring.name) is None:
            assert time.monotonic() < end
            assert child.poll() is None
            time.sleep(0.02)
        for _ in range(10):
            engine.cycle()
        child.send_signal(signal.SIGINT)
        _, said = child.communicate(timeout=PATIENCE)
    finally:
        child.kill()
    assert child.returncode == 0
    assert "10 cycles" in said
    assert "lost" not in said
    assert len(list(LiveRecording.open(path).cycles())) == 10
    assert read_state(engine.ring.name) is None


def test_record_what_cannot_be(tmp_path):
    path = str(tmp_path / "a.mcap")
    assert "expected a ring" in run("record", "nonesuch-ring", "-o", path, code=2)
    assert "ends in .mcap" in run("record", "-o", str(tmp_path / "a.bag"), code=2)
    assert "--duration" in run("record", "-o", path, "--duration", "0", code=2)
    assert list(tmp_path.iterdir()) == []


def test_recover(tmp_path):
    path, bad, good = (tmp_path / name for name in ("a.mcap", "bad.mcap", "good.mcap"))
    write(path, close=False)
    text = run("recover", str(path), "-o", str(good))
    assert "saved 30 messages" in text
    assert "had no end; nothing had to be left out" in text
    bad.write_bytes(path.read_bytes()[:-10])
    assert "expected a new file" in run("recover", str(bad), "-o", str(good), code=2)
    text = run("recover", str(bad), "-o", str(good), "--force")
    assert "saved 28 messages" in text or "saved 30 messages" in text
    assert "bytes at the end" in text
    text = run("recover", str(good), "-o", str(tmp_path / "again.mcap"))
    assert "is whole: nothing was wrong with it" in text
    bad.write_text("no recording")
    assert "it is no MCAP file" in run("recover", str(bad), "-o", str(good), "--force", code=2)


@pytest.mark.parametrize("command", ["record", "recover", "info", "export"])
def test_help_teaches(command):
    assert f"skinfield {command} " in run(command, "--help")
