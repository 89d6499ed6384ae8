"""A long run of everything together: boards, engine, recorder, readers, and a paired cyclictest.

    python benchmarks/soak.py [--minutes 30] [--rate 1000] [--record FILE] [--json FILE]

A virtual skin in a process of its own sends the bytes of iCub's boards over UDP; the
engine answers at the same rate; a recorder writes all of it; two readers fetch every estimate they
can, one by the futex, one every 20 ms. A line is printed each minute, and in the end what was sent,
received, lost and why, which cycles were late, the memory of each process at the start and the end,
and the times beside those of a cyclictest on the same processor in the same seconds. An engine that
ended on the way is started again, and why it did is printed; the exit status then is 1.
"""

import argparse
import json
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

import skinfield as sf
from skinfield.cli.sources import source_from_options
from skinfield.emulator.process import start
from skinfield.emulator.settings import VirtualSettings
from skinfield.errors import InputError
from skinfield.files.mcap.live import LiveRecording
from skinfield.lab.bench.jitter import Cyclictest
from skinfield.loop.client import Live
from skinfield.loop.settings import LiveSettings
from skinfield.loop.status import LiveStatus, Observer
from skinfield.loop.supervisor import Supervisor
from skinfield.ring import State
from skinfield.signal import ICubByte

BOARDS = 30  # of SCHED_FIFO: boards keep their time, whatever the computer does

READER = """
import sys, time, json, signal
import skinfield as sf
name, pause = sys.argv[1], float(sys.argv[2])
signal.signal(signal.SIGTERM, lambda *_: sys.exit())
fetched = contacts = last = missed = 0
try:
    with sf.connect(name) as live:
        while True:
            found = live.next(1.0) if not pause else live.latest()
            if pause:
                time.sleep(pause)
            if found is None:
                continue
            if last and not pause:
                missed += found.number - last - 1
            last = found.number
            fetched += 1
            contacts += len(found.contacts) > 0
finally:
    print(json.dumps({"fetched": fetched, "with_contact": contacts, "passed_over": missed}))
"""


def resident(pid: int) -> float:
    """Memory of a process in RAM, MB; NaN of one that ended."""
    with suppress(OSError):
        for line in Path(f"/proc/{pid}/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1]) / 1024
    return float("nan")


@contextmanager
def child(*words: str) -> Iterator["subprocess.Popen[str]"]:
    process = subprocess.Popen([sys.executable, *words], stdout=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()


def ended(process: "subprocess.Popen[str]") -> str:
    process.terminate()
    return process.communicate(timeout=60)[0]


def boards(place: str, rate: float) -> VirtualSettings:
    """Of a hexagon that nobody touches yet."""
    return VirtualSettings(
        bus="udp",
        channels=(place,),
        rate=rate,
        scene="idle",
        lead_in=0.0,
        priority=BOARDS,
    )


def engine_settings(place: str, rate: float, name: str) -> LiveSettings:
    """Of the same hexagon."""
    patch = sf.layouts.hexagon72()
    period = {"period_ms": str(max(round(1e3 / rate), 1))}
    source = source_from_options("icub", "udp", (place,), sf.Skin((patch,)), period)
    return LiveSettings(skin=patch, sources=(source,), name=name, board=ICubByte(), rate=rate)


def soak(minutes: float, rate: float, file: Path, port: int, console: Console) -> dict[str, Any]:
    with ExitStack() as parts:
        place = f"127.0.0.1:{port}"
        skin = parts.enter_context(start(boards(place, rate)))
        settings = engine_settings(place, rate, f"soak-{port}")
        supervisor = parts.enter_context(Supervisor(settings))
        supervisor.wait(600.0, State.STARTING).close()
        recorder = parts.enter_context(
            child("-m", "skinfield.record.recorder", settings.name, str(file))
        )
        supervisor.wait(600.0).close()
        live = parts.enter_context(Live(settings.name))
        readers = [
            parts.enter_context(child("-c", READER, settings.name, pause))
            for pause in ("0", "0.02")
        ]
        skin.scene("random")
        time.sleep(5.0)
        observer = Observer(live.reader)
        granted = observer.look().notes.get("granted", {})
        pids = {"engine": live.reader.pid, "recorder": recorder.pid, "virtual skin": skin.pid}
        pids |= {f"reader {k + 1}": each.pid for k, each in enumerate(readers)}
        memory = {name: [resident(pid)] for name, pid in pids.items()}
        seconds = 60.0 * minutes
        beside = cyclictest(granted, rate, seconds)
        watched(supervisor, observer, seconds, memory, pids, console)
        found = observer.look()
        lateness = None if beside is None else beside.finish()
        said = [json.loads(ended(each)) for each in readers]
        sent = skin.stop()
        time.sleep(0.5)
        last = observer.look()
        recorder.terminate()
        recorder.wait(60)
        return {
            "machine": platform.platform(),
            "minutes": minutes,
            "rate": rate,
            "sent": sent,
            "received": last.sources,
            "readers": said,
            "cycles": found.since.cycles,
            "since_start": found.since.as_dict(),
            "recorder": found.sidecars.get("recorder"),
            "memory_mb": memory,
            "cyclictest_us": None if lateness is None else lateness.as_micros(),
            "granted": granted,
            "restarts": supervisor.restarts,
            "ends": [each for each in supervisor.events if each.what in ("failed", "hung")],
            "traceback": supervisor.traceback,
            "recorded": recorded(file),
        }


def cyclictest(granted: dict[str, Any], rate: float, seconds: float) -> Any:
    try:
        return Cyclictest(
            granted.get("cpu"),
            max(int(granted.get("priority", 0)), 1),
            period_ns=int(1e9 / rate),
            seconds=seconds,
            offset_ns=int(0.5e9 / rate),
        )
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        return None


def watched(
    supervisor: Supervisor,
    observer: Observer,
    seconds: float,
    memory: dict[str, list[float]],
    pids: dict[str, int],
    console: Console,
) -> None:
    """Print a line each minute."""
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        time.sleep(min(left, 60.0))
        status: LiveStatus = observer.look()
        if supervisor.child is not None:
            pids["engine"] = supervisor.child.pid
        for name, pid in pids.items():
            memory[name].append(resident(pid))
        wake, ready = status.lately.wake, status.lately.ready
        console.print(
            f"{(seconds - end + time.monotonic()) / 60:5.1f} min  {status.since.cycles:>9,} cycles "
            f" {status.since.late:>6,} late  {status.lost:>6,} lost  wake p99 "
            f"{0 if wake is None else wake.p99 * 1e6:5.0f} µs  ready p99 "
            f"{0 if ready is None else ready.p99 * 1e6:5.0f} µs  engine "
            f"{memory['engine'][-1]:.1f} MB  recorder {memory['recorder'][-1]:.1f} MB",
            highlight=False,
        )


def recorded(file: Path) -> dict[str, Any]:
    """What is in the file: cycles, bytes of readings, and whether the log has gaps."""
    recording = LiveRecording.open(file)
    position, gaps, size = -1, 0, 0
    for piece in recording.blocks():
        gaps += position >= 0 and piece.position != position
        position = piece.position + len(piece.data)
        size += len(piece.data)
    numbers = [cycle.number for cycle in recording.cycles()]
    return {
        "file_mb": file.stat().st_size / 1e6,
        "log_bytes": size,
        "gaps_in_the_log": int(gaps),
        "cycles": len(numbers),
        "cycles_missing": numbers[-1] - numbers[0] + 1 - len(numbers) if numbers else 0,
        "finished": recording.finished,
        "events": [each.get("text", "") for each in recording.events()][:20],
    }


def tell(found: dict[str, Any], console: Console) -> None:
    table = Table("µs", "p50", "p99", "p99.9", "max")
    rows = {name: found["since_start"][f"{name}_us"] for name in ("wake", "ready", "latency")}
    for name, row in (*rows.items(), ("cyclictest", found["cyclictest_us"])):
        if row:
            table.add_row(name, *(f"{row[key]:,.1f}" for key in ("p50", "p99", "p999", "max")))
    console.print(table)
    for name in ("sent", "received", "readers", "recorder", "recorded", "restarts"):
        console.print(f"{name}: {json.dumps(found[name])}", highlight=False, soft_wrap=True)
    for name, values in found["memory_mb"].items():
        console.print(f"memory of {name}: {values[0]:.1f} MB at first, {values[-1]:.1f} at last")
    since = found["since_start"]
    console.print(
        f"{since['cycles']:,} cycles, {since['late']:,} late, {since['overrun']:,} beyond the next "
        f"one's time, {since['skipped']:,} periods without a cycle"
    )
    for _, what, text in found["ends"]:
        console.print(f"the engine {what}: {text}", style="red", highlight=False)
    console.print(found["traceback"], highlight=False, markup=False)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--rate", type=float, default=1000.0)
    parser.add_argument("--port", type=int, default=43931)
    parser.add_argument("--record", type=Path)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    console = Console()
    with tempfile.TemporaryDirectory() as folder:
        file = given.record or Path(folder) / "soak.mcap"
        found = soak(given.minutes, given.rate, file, given.port, console)
    tell(found, console)
    if given.json is not None:
        given.json.write_text(json.dumps(found, indent=1))
    sys.exit(1 if found["restarts"] else 0)


if __name__ == "__main__":
    main()
