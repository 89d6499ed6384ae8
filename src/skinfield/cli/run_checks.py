"""What can be refused before `skinfield run` starts anything."""

import math
import os
import socket
from pathlib import Path
from typing import Any

from skinfield.cli.run_options import extra_settings
from skinfield.errors import InputError

HERE = "127.0.0.1"


def check_given(given: dict[str, Any]) -> None:
    """Check the options that need no skin.

    Raises
    ------
    InputError
        With the option, what was expected of it, and what to do.
    """
    check_record(given["record"])
    check_name(given["name"])
    check_port(given["port"])
    for option, name, what in (
        ("duration", "--duration", "seconds"),
        ("rate", "--rate", "cycles per second; or --events: a cycle when readings arrive"),
        ("virtual_rate", "--virtual-rate", "readings per second"),
        ("tare_s", "--tare-s", "seconds of an untouched skin"),
        ("budget_us", "--budget-us", "microseconds"),
        ("deadline_ms", "--deadline-ms", "milliseconds"),
    ):
        value = given[option]
        if value is not None and not (math.isfinite(value) and value > 0):
            raise InputError(f"{name} is {value:g}, expected a positive number of {what}")
    if given["rate"] > 1e5:
        raise InputError(f"--rate is {given['rate']:g}, expected 100000 cycles per second at most")
    gain = given["gain"]
    if gain is not None and not (math.isfinite(gain) and gain):
        raise InputError(f"--gain is {gain:g}, expected counts per unit of ΔC/C₀, not 0")
    extra_settings(given["extra"])
    _check_budget(given)
    if given["hardware"] is None:
        check_scene(given["scene"])


def _check_budget(given: dict[str, Any]) -> None:
    period = 1e6 / given["rate"]
    if given["budget_us"] is not None and not given["events"] and given["budget_us"] >= period:
        raise InputError(
            f"--budget-us is {given['budget_us']:g}, expected less than the period of "
            f"{period:g} µs at --rate {given['rate']:g}: taking in readings needs time too"
        )


def check_record(path: Path | None) -> None:
    """Refuse to write over a recording, or where nothing can be written."""
    if path is None:
        return
    if path.exists():
        raise InputError(f"--record is {path}, which is there already, expected a new file")
    folder = path.parent
    if not folder.is_dir() or not os.access(folder, os.W_OK):
        raise InputError(f"--record is {path}, expected a folder that is there and can be written")


def check_name(name: str) -> None:
    """Refuse a name that a running skin has, or that none can have."""
    from skinfield.live.beside import beside
    from skinfield.ring import Ring

    beside(name, "supervisor")
    for each in Ring.names():
        if each.name == name and each.alive:
            raise InputError(
                f"a skin named {name!r} runs already, as process {each.pid}, expected another "
                "--name; `skinfield status` shows it"
            )


def check_port(port: int | None) -> None:
    """Refuse a port that cannot be served."""
    if port is None:
        return
    if not 0 <= port <= 65535:
        raise InputError(f"--port is {port}, expected 0 to 65535; 0 lets the system choose")
    with socket.socket() as trial:
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind((HERE, port))
        except OSError as error:
            raise InputError(
                f"--port {port} cannot be served: {error.strerror}, expected one that is free"
            ) from error


def check_scene(scene: str) -> None:
    """Refuse a scene of the virtual skin that there is none of."""
    from skinfield.virtual.scenes import SCENES

    if scene not in SCENES and not Path(scene).is_file():
        raise InputError(
            f"--scene is {scene!r}, expected one of {', '.join(SCENES)}, or the path of a file"
        )
