"""`skinfield doctor`: what this machine has of what skinfield needs, and the remedies."""

import importlib.util
import json
import os
import platform
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import suppress
from importlib import metadata
from pathlib import Path
from typing import Literal, NamedTuple

from rich.table import Table

from skinfield.cli import options, report
from skinfield.processes import processors

State = Literal["OK", "note", "missing"]
COLOURS = {"OK": "green", "note": "yellow", "missing": "red bold"}
REQUIREMENT = re.compile(r"([\w.-]+)(?:\[[^]]*\])?([^;]*)(?:;.*extra == ['\"](\w+)['\"])?")
FOR_DEVELOPERS = ("all", "test", "lint", "dev")  # extras that no user needs
LOADED = ("numpy", "scipy", "numba", "matplotlib", "websockets")  # by `demo` and `run`
LEAST_SHARED, LEAST_DISK = 64e6, 2e9  # bytes
GIGA, MEGA = 1e9, 1e6
CAN_DEVICE = "280"  # ARPHRD_CAN of linux/if_arp.h
SERIAL = ("ttyUSB*", "ttyACM*", "tty.usb*")
UNLOADED = "it does not load: {}"
REAL_TIME = (
    "import json; from skinfield.loop.realtime import RealTime; "
    "print(json.dumps(RealTime().apply().as_dict()))"
)
PATIENCE = 30.0  # s for the process that asks for real time


class Row(NamedTuple):
    """What was looked at, how it is, what there is, and the remedy, if any."""

    what: str
    state: State
    value: str
    remedy: str = ""


def doctor(*, as_json: options.Json = False) -> int:
    """Tell what is there, what is not, and the remedy; nothing is changed, nothing is looked up.

    OK is as it should be; a note says what works less well or is not installed; where something is
    missing, `demo` or `run` cannot work, and the exit status is 1.

      skinfield doctor
      skinfield doctor --json | jq '.findings[] | select(.state != "OK")'
    """
    findings = [found for check in CHECKS for found in check()]
    works = all(each.state != "missing" for each in findings)
    value = {"works": works, "findings": [each._asdict() for each in findings]}
    verdict = "demo and run can work here" if works else "something is missing: see its remedy"
    report.finish(as_json, value, lines=[_table(findings), verdict])
    return 0 if works else 1


def _table(findings: list[Row]) -> Table:
    made = report.table(None, ("", "", "found", "remedy"), ())
    for each in findings:
        colour = COLOURS[each.state]
        made.add_row(
            each.what, f"[{colour}]{each.state}[/]", _plain(each.value), _plain(each.remedy)
        )
    return made


def _plain(text: str) -> str:
    """Text in which no bracket is taken for a style."""
    return text.replace("[", r"\[")


def python() -> Iterator[Row]:
    """The interpreter, and this package."""
    place = f"{platform.python_version()}, {sys.executable}"
    yield Row("Python", "OK", place)
    yield Row("skinfield", "OK", f"{metadata.version('skinfield')}, {Path(__file__).parents[1]}")


def packages() -> Iterator[Row]:
    """What skinfield needs always, and its extras."""
    extras: dict[str, list[str]] = {}
    for text in metadata.requires("skinfield") or ():
        name, wanted, extra = REQUIREMENT.match(text).groups()  # type: ignore[union-attr]
        version = _version(name)
        if extra is None:
            yield _package(name, wanted.strip(), version)
        elif extra not in FOR_DEVELOPERS and name != "skinfield":
            lacking = extras.setdefault(extra, [])
            lacking += [] if version else [name]
    for extra, lacking in extras.items():
        remedy = f'python -m pip install "skinfield[{extra}]"' if lacking else ""
        found = f"without {', '.join(lacking)}" if lacking else "installed"
        yield Row(f"extra {extra}", "note" if lacking else "OK", found, remedy)


def _package(name: str, wanted: str, version: str) -> Row:
    remedy = f'python -m pip install "{name}{wanted}"'
    if not version:
        return Row(name, "missing", f"not installed, expected {wanted}", remedy)
    if name in LOADED:
        try:
            importlib.import_module(name)
        except Exception as error:  # whatever a broken installation raises
            return Row(name, "missing", UNLOADED.format(error), remedy)
    return Row(name, "OK", version)


def _version(name: str) -> str:
    with suppress(metadata.PackageNotFoundError):
        return metadata.version(name)
    return ""


def machine() -> Iterator[Row]:
    """Processors and memory."""
    from skinfield.loop.realtime.system import values_of

    model = values_of("/proc/cpuinfo").get("model name\t") or platform.machine()
    allowed = processors()
    few = allowed < 2
    remedy = "one core is shared by engine, page and skin: cycles will be late" if few else ""
    memory = values_of("/proc/meminfo").get("MemAvailable", "").removesuffix(" kB")
    free = f", {int(memory) * 1024 / GIGA:.1f} GB of memory free" if memory.isdecimal() else ""
    cores = f"{allowed} core{'' if few else 's'}"
    yield Row("processor", "note" if few else "OK", f"{model}, {cores}{free}", remedy)


def compiled_code() -> Iterator[Row]:
    """Where compiled code is kept, and how much of it is there."""
    import warnings

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        from skinfield.compile_progress import CompileProgress
        from skinfield.compiled import code_folder

        folder = code_folder()
        run = CompileProgress("run")
    size = sum(each.stat().st_size for each in folder.rglob("*") if each.is_file())
    where = f"{folder}, {size / MEGA:.0f} MB"
    if run.seconds_left < 1.0:
        yield Row("compiled code", "OK", f"{where}: all that a run needs")
    else:
        text = f"{where}: a first run compiles for some {run.seconds_left:.0f} s"
        yield Row("compiled code", "note", text, "skinfield warmup")
    for each in said:
        yield Row("compiled code", "note", str(each.message))


def real_time() -> Iterator[Row]:
    """What the system grants to a process that must wake on time: one is started, and asks."""
    from skinfield.loop.realtime import RealTimeStatus

    done = subprocess.run(
        [sys.executable, "-c", REAL_TIME],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )
    if done.returncode:
        last = (done.stderr.strip() or "it said nothing").splitlines()[-1]
        yield Row("real time", "note", f"cannot be asked for: {last}")
        return
    status = RealTimeStatus.from_dict(json.loads(done.stdout))
    granted, *_ = status.sentences()
    yield Row("real time", "note" if status.refused else "OK", granted)
    for text in status.refused:
        found, _, remedy = text.partition(": ")
        yield Row("real time", "note", found, remedy)


def shared_memory() -> Iterator[Row]:
    """Where rings lie, by which processes share estimates."""
    from skinfield.ring.files import folder_of

    folder = folder_of(None)
    try:
        tempfile.TemporaryFile(dir=folder).close()
        free = shutil.disk_usage(folder).free
    except OSError as error:
        remedy = f"give this user the right to write to {folder}"
        yield Row("shared memory", "missing", f"{folder} cannot be written to: {error}", remedy)
        return
    few = free < LEAST_SHARED
    remedy = f"expected {LEAST_SHARED / MEGA:.0f} MB: docker run --shm-size=256m" if few else ""
    found = f"{folder}, {free / MEGA:.0f} MB free"
    yield Row("shared memory", "missing" if few else "OK", found, remedy)


def page() -> Iterator[Row]:
    """A port for the page, and a browser."""
    from skinfield.page.settings import PORT

    try:
        socket.create_server(("127.0.0.1", PORT)).close()
        yield Row("page", "OK", f"port {PORT} is free")
    except OSError:
        another = "run takes another one; or give it --port"
        yield Row("page", "note", f"port {PORT} is in use", another)
    try:
        with socket.socket(type=socket.SOCK_DGRAM) as datagrams:
            datagrams.bind(("127.0.0.1", 0))
    except OSError as error:
        yield Row("network", "missing", f"127.0.0.1 cannot be used: {error}", "ip link set lo up")
    if not report.has_screen():
        by_hand = "open the page's address by hand; from elsewhere: ssh -L 8700:localhost:8700"
        yield Row("browser", "note", "no screen here", by_hand)
        return
    try:
        webbrowser.get()
        yield Row("browser", "OK", "found")
    except webbrowser.Error:
        yield Row("browser", "note", "none found", "open the page's address by hand")


def hardware() -> Iterator[Row]:
    """Serial ports and CAN interfaces that can be seen."""
    ports = sorted(each for name in SERIAL for each in Path("/dev").glob(name))
    closed = [each for each in ports if not os.access(each, os.R_OK | os.W_OK)]
    remedy = "sudo usermod -a -G dialout $USER, then log in anew" if closed else ""
    found = ", ".join(map(str, ports)) or "none is plugged in"
    yield Row("serial ports", "note" if closed or not ports else "OK", found, remedy)
    names = []
    for each in sorted(Path("/sys/class/net").glob("*")):
        with suppress(OSError):
            if (each / "type").read_text().strip() == CAN_DEVICE:
                names.append((each.name, (each / "operstate").read_text().strip()))
    down = [name for name, state in names if state == "down"]
    remedy = f"sudo ip link set {down[0]} up type can bitrate 1000000" if down else ""
    found = ", ".join(f"{name} ({state})" for name, state in names) or "no interface"
    yield Row("CAN", "note" if down or not names else "OK", found, remedy)


def bridges() -> Iterator[Row]:
    """Other software that estimates can be sent to."""
    there = importlib.util.find_spec("rclpy") is not None
    distribution = os.environ.get("ROS_DISTRO", "")
    remedy = "" if there else "source /opt/ros/DISTRO/setup.bash, for run --ros2"
    found = f"rclpy of {distribution or 'an unnamed distribution'}" if there else "no rclpy"
    yield Row("ROS 2", "OK" if there else "note", found, remedy)
    yarp = shutil.which("yarp")
    yield Row("YARP", "OK", yarp or "no yarp here; its name server may be on another machine")


def disk() -> Iterator[Row]:
    """Where recordings and pictures go."""
    folder = Path.cwd()
    free = shutil.disk_usage(folder).free
    found = f"{folder}, {free / GIGA:.1f} GB free"
    if not os.access(folder, os.W_OK):
        yield Row("folder", "note", f"{folder} cannot be written to", "cd to another, or give -o")
    elif free < LEAST_DISK:
        yield Row(
            "folder",
            "note",
            found,
            "recordings need room: docs/reference/recording-file.md says how much",
        )
    else:
        yield Row("folder", "OK", found)


CHECKS: tuple[Callable[[], Iterator[Row]], ...] = (
    python, packages, machine, compiled_code, real_time, shared_memory, page, hardware, bridges,
    disk,
)  # fmt: skip
