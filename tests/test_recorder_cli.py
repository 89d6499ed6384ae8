"""`skinfield record` and `skinfield recover` as they are typed."""

import os
import signal
import subprocess
import sys

from command_line import refused, run
from live_skins import wait_for
from mcap_sample import write

from skinfield.files.mcap.live import LiveRecording
from skinfield.record.recorder import read_state

PATIENCE = 60.0  # s
MAIN = "from skinfield.cli import main; main()"


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
        wait_for(lambda: read_state(engine.ring.name) or child.poll() is not None)
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
    path = tmp_path / "a.mcap"
    assert "expected a ring" in refused("record", "nonesuch-ring", "-o", path)
    assert "ends in .mcap" in refused("record", "-o", tmp_path / "a.bag")
    assert "--duration" in refused("record", "-o", path, "--duration", "0")
    assert list(tmp_path.iterdir()) == []


def test_recover(tmp_path):
    path, bad, good = (tmp_path / name for name in ("a.mcap", "bad.mcap", "good.mcap"))
    write(path, close=False)
    text = run("recover", path, "-o", good)
    assert "saved 30 messages" in text
    assert "had no end; nothing had to be left out" in text
    bad.write_bytes(path.read_bytes()[:-10])
    assert "expected a new file" in refused("recover", bad, "-o", good)
    text = run("recover", bad, "-o", good, "--force")
    assert "saved 28 messages" in text or "saved 30 messages" in text
    assert "bytes at the end" in text
    text = run("recover", good, "-o", tmp_path / "again.mcap")
    assert "is whole: nothing was wrong with it" in text
    bad.write_text("no recording")
    assert "it is no MCAP file" in refused("recover", bad, "-o", good, "--force")
