"""What can be refused before `skinfield run` starts anything."""

import errno
import math
import os
import socket
from pathlib import Path
from typing import Any

from skinfield.cli.page_options import page_settings
from skinfield.cli.run_options import extra_settings
from skinfield.errors import InputError

NOT_HERE = (errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT)


def check_given(given: dict[str, Any]) -> None:
    """Check the options that need no skin.

    Raises
    ------
    InputError
        With the option, what was expected of it, and what to do.
    """
    check_record(given["record"])
    check_name(given["name"])
    check_port(given["port"], given["host"])
    page_settings(given)  # refuses a page that others can reach, without a token
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


def check_port(port: int | None, host: str) -> None:
    """Refuse a port or an address that the page cannot be served on; None is any port."""
    if port is not None and not 0 <= port <= 65535:
        raise InputError(f"--port is {port}, expected 0 to 65535; 0 lets the system choose")
    errors = [
        _cannot_bind(family, (address[0], port or 0, *address[2:]))
        for family, address in _addresses(host)
    ]
    for error in errors:
        if error is not None and error.errno not in NOT_HERE:
            raise InputError(
                f"--port {port} of {host} cannot be served: {error.strerror}, expected one that "
                "is free"
            ) from error
    if None not in errors:  # one may be missing, where IPv6 is switched off
        raise InputError(_no_host(host, errors[0])) from errors[0]


def _cannot_bind(family: int, address: tuple[Any, ...]) -> OSError | None:
    """Why nothing can be served at an address; None if it can."""
    try:
        with socket.socket(family, socket.SOCK_STREAM) as trial:
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            if family == socket.AF_INET6:  # as the page's server does: IPv4 has its own socket
                trial.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
            trial.bind(address)
    except OSError as error:
        return error
    return None


def _no_host(host: str, error: Exception | None) -> str:
    why = getattr(error, "strerror", None) or error
    return (
        f"--host is {host!r}, expected an address of this machine, such as 127.0.0.1, or 0.0.0.0 "
        f"for all of them: {why}"
    )


def _addresses(host: str) -> list[tuple[int, tuple[Any, ...]]]:
    """Families and addresses of a host of this machine."""
    plain = host.strip("[]") or None  # an empty one is all of the machine's
    try:
        found = socket.getaddrinfo(plain, 0, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    except (OSError, UnicodeError) as error:
        raise InputError(_no_host(host, error)) from error
    return [(family, address) for family, _, _, _, address in found]


def check_scene(scene: str) -> None:
    """Refuse a scene of the virtual skin that there is none of."""
    from skinfield.virtual.scenes import SCENES

    if scene not in SCENES and not Path(scene).is_file():
        raise InputError(
            f"--scene is {scene!r}, expected one of {', '.join(SCENES)}, or the path of a file"
        )
