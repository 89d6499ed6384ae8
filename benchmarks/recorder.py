"""Record a ring that is written at full rate, and check that nothing is missing.

  python benchmarks/recorder.py [seconds] [taxels] [rate] [slots]

Readings are 16-bit counts: a base, noise of two counts and a slow wave, so that they compress as a
skin's do. Engine and recorder are processes of their own; figures are those of the recorder.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from pathlib import Path

from skinfield.files.mcap.live import LiveRecording
from skinfield.record.state import RecorderState, forget_state, read_state

HERE = Path(__file__).resolve().parent
ENGINE = HERE.parent / "tests" / "recorder_ring.py"


def main() -> None:
    """Run both, then read the file."""
    usual = ("60", "4000", "1000", "64")
    seconds, taxels, rate, slots = [
        *sys.argv[1:],
        *usual[len(sys.argv) - 1 :],
    ]
    name = f"bench{uuid.uuid4().hex[:8]}"
    with tempfile.TemporaryDirectory(dir=HERE) as folder:
        path = Path(folder) / "a.mcap"
        engine = subprocess.Popen(
            [sys.executable, str(ENGINE), name, taxels, rate, seconds, slots, str(1 << 26)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert engine.stdin is not None
        assert engine.stdout is not None
        engine.stdout.readline()
        recorder = subprocess.Popen(
            [sys.executable, "-m", "skinfield.record.recorder", name, str(path)]
        )
        while read_state(name) is None:
            time.sleep(0.01)
        started = cpu_of(recorder.pid)
        engine.stdin.write("\n")
        engine.stdin.flush()
        began = time.monotonic()
        cycles, logged = map(int, engine.stdout.readline().split())
        took, worked = time.monotonic() - began, cpu_of(recorder.pid) - started
        time.sleep(1.5)  # until it tells of itself again
        state = read_state(name)
        recorder.send_signal(signal.SIGTERM)
        recorder.wait()
        engine.communicate("\n")
        forget_state(name)
        report(path, state, cycles, logged, took, worked)


def cpu_of(pid: int) -> float:
    """Seconds of processor time so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def report(
    path: Path, state: RecorderState, cycles: int, logged: int, took: float, cpu: float
) -> None:
    """Say what the engine wrote and what is in the file."""
    began = time.monotonic()
    found = LiveRecording.open(path)
    saved, there = sum(len(each.data) for each in found.blocks()), len(list(found.cycles()))
    read, size = time.monotonic() - began, path.stat().st_size
    print(f"{took:.1f} s: {cycles} cycles and {logged} bytes of log written")
    print(f"in the file: {there} cycles and {saved} bytes, {cycles - there} and "
          f"{logged - saved} missing; {size / 1e6:.1f} MB, {logged / size:.2f} to 1")  # fmt: skip
    print(f"recorder: {100 * cpu / took:.1f} % of one processor; longest write or sync "
          f"{1e3 * state.longest:.0f} ms; read back in {read:.1f} s")  # fmt: skip


if __name__ == "__main__":
    main()
