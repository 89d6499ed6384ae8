"""Faults put into a running skin one after the other, and what the system says to each.

    python benchmarks/faults.py [--json FILE]

A virtual skin over UDP, the engine, a recorder and a reader run as they do on a robot. Every fault
is injected from outside: at the boards, on the wires, at the processes. What is told is what
`skinfield status`, the supervisor and the recording say of it.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from rich.console import Console

import skinfield as sf
from skinfield.cli.sources import source_from_options
from skinfield.emulator.process import VirtualProcess, start
from skinfield.emulator.settings import VirtualSettings
from skinfield.files.mcap.live import LiveRecording
from skinfield.loop.client import Live
from skinfield.loop.settings import LiveSettings
from skinfield.loop.status import LiveStatus, Observer
from skinfield.loop.supervisor import Supervisor
from skinfield.ring import State
from skinfield.signal import ICubByte

RATE = 100.0
WATCH = 3.0  # s
COUNTS = ("lost", "overflowed", "malformed", "foreign", "duplicated", "swapped", "reopened")


class Bench:
    """What runs, and how to look at it."""

    def __init__(self, parts: ExitStack, folder: Path) -> None:
        self.skin: VirtualProcess = parts.enter_context(
            start(VirtualSettings(bus="udp", rate=RATE, scene="idle", lead_in=0.0))
        )
        patch = sf.layouts.hexagon72()
        source = source_from_options(
            "icub", "udp", self.skin.channels, sf.Skin((patch,)), {"period_ms": "10"}
        )
        made = LiveSettings(
            skin=patch,
            sources=(source,),
            name=f"faults-{os.getpid()}",
            board=ICubByte(),
            rate=500.0,
        )
        self.supervisor = parts.enter_context(Supervisor(made))
        self.supervisor.wait(120.0, State.STARTING).close()
        self.file = folder / "faults.mcap"
        words = [sys.executable, "-m", "skinfield.record.recorder", made.name, str(self.file)]
        self.recorder = subprocess.Popen(words)
        parts.callback(self.recorder.kill)
        self.supervisor.wait(120.0).close()
        self.live = parts.enter_context(Live(made.name))
        self.observer = Observer(self.live.reader)

    def pid(self) -> int:
        return self.live.reader.pid


def said(before: LiveStatus, now: LiveStatus, worst: dict[str, Any]) -> list[str]:
    """Sentences on what has changed between two looks."""
    lines = []
    for name, counts in now.sources.items():
        changed = {
            what: counts[what] - before.sources[name][what]
            for what in COUNTS
            if counts[what] != before.sources[name][what]
        }
        if changed:
            lines.append(", ".join(f"{number} {what}" for what, number in changed.items()))
        down = counts["down_ns"] - before.sources[name]["down_ns"]
        if down:
            lines.append(f"away for {down * 1e-9:.2f} s")
    if worst["invalid"]:
        lines.append(f"{worst['invalid']} taxels left out")
    if worst["missing"]:
        lines.append(f"patch missing, newest reading up to {worst['age'] * 1e3:.0f} ms old")
    if worst["states"] - {"running"}:
        lines.append("state " + ", ".join(sorted(worst["states"] - {"running"})))
    recorder = now.sidecars.get("recorder") or {}
    if recorder.get("silent"):
        lines.append("recorder silent")
    late = now.since.late - before.since.late
    if late > 0:
        lines.append(f"{late} cycles late")
    return lines or ["nothing: no count, state or age changed"]


def watch(bench: Bench, seconds: float) -> tuple[LiveStatus, dict[str, Any]]:
    """Look again and again; the last look, and the worst that was seen."""
    worst: dict[str, Any] = {"invalid": 0, "missing": False, "age": 0.0, "states": set()}
    end = time.monotonic() + seconds
    now = bench.observer.look()
    while time.monotonic() < end:
        time.sleep(0.05)
        now = bench.observer.look()
        worst["states"].add(now.state)
        for row in now.patches:
            worst["invalid"] = max(worst["invalid"], row["invalid"])
            worst["missing"] |= row["answer"] == "missing"
            worst["age"] = max(worst["age"], row["age"] or 0.0)
    return now, worst


def faults(bench: Bench) -> Iterator[tuple[str, Callable[[], None], Callable[[], None], float]]:
    """What is injected, how, how it ends, and for how long it is watched, s."""
    skin, nothing = bench.skin, lambda: None
    yield "1 % of messages lost", lambda: skin.wires(lose=0.01), lambda: skin.wires(lose=0), WATCH
    yield (
        "1 % of messages doubled",
        lambda: skin.wires(duplicate=0.01),
        lambda: skin.wires(duplicate=0),
        WATCH,
    )
    yield (
        "1 % of messages swapped",
        lambda: skin.wires(swap=0.01),
        lambda: skin.wires(swap=0),
        WATCH,
    )
    for text, what in (
        ("unplug 3+2s", "a triangle unplugged for 2 s"),
        ("reboot 0+2s", "a board that reboots, silent for 2 s"),
        ("bus-off 0+2s", "the bus away for 2 s"),
        ("no-ack 5+2s", "a converter that does not answer"),
        ("dead 7+2s", "a dead taxel"),
        ("stuck 9+2s", "a stuck taxel"),
        ("saturated 11+2s", "a taxel at its clamp"),
    ):
        yield what, (lambda text=text: skin.fault(text)), nothing, 6.0
    yield "junk on the port", lambda: junk(skin), nothing, WATCH
    yield (
        "the virtual skin stopped for 2 s (SIGSTOP)",
        lambda: os.kill(skin.pid, signal.SIGSTOP),
        lambda: os.kill(skin.pid, signal.SIGCONT),
        2.0,
    )
    yield "a reader killed (SIGKILL)", lambda: dead_reader(bench), nothing, WATCH
    yield "the engine killed (SIGKILL)", lambda: os.kill(bench.pid(), signal.SIGKILL), nothing, 15.0
    yield "the engine hung (SIGSTOP)", lambda: os.kill(bench.pid(), signal.SIGSTOP), nothing, 20.0
    yield "the recorder killed (SIGKILL)", lambda: bench.recorder.kill(), nothing, 6.0


def junk(skin: VirtualProcess) -> None:
    """Datagrams that mean nothing, at everything that listens on this machine's loopback."""
    import socket

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        host, port = skin.channels[0].rsplit(":", 1)
        for size in range(1, 200):
            sender.sendto(os.urandom(size), (host, int(port)))


def dead_reader(bench: Bench) -> None:
    code = (
        f"import skinfield as sf\nfor each in sf.connect({bench.live.name!r}): print(1, flush=True)"
    )
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
    assert child.stdout is not None
    child.stdout.readline()
    child.kill()
    child.wait()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    console, rows = Console(), []
    with tempfile.TemporaryDirectory() as name, ExitStack() as parts:
        bench = Bench(parts, Path(name))
        time.sleep(1.0)
        for what, begin, end, seconds in faults(bench):
            before, events = bench.observer.look(), len(bench.supervisor.events)
            begin()
            now, worst = watch(bench, seconds)
            end()
            lines = said(before, now, worst)
            lines += [f"{e.what}: {e.text}" for e in list(bench.supervisor.events)[events:]]
            after, _ = watch(bench, 1.0)
            lines.append("afterwards " + ", ".join(r["answer"] for r in after.patches))
            rows.append([what, lines])
            console.print(f"[bold]{what}[/]", highlight=False)
            for line in lines:
                console.print(f"  {line}", highlight=False, markup=False)
        recorded = [each.get("text", "") for each in LiveRecording.open(bench.file).events()]
        console.print("[bold]events in the recording[/]")
        for text in recorded:
            console.print(f"  {text}", highlight=False, markup=False)
        console.print(
            f"sent by the virtual skin: {json.dumps(bench.skin.counts())}", soft_wrap=True
        )
    if given.json is not None:
        given.json.write_text(json.dumps({"faults": rows, "events": recorded}, indent=1))


if __name__ == "__main__":
    main()
