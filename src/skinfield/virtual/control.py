"""The control socket: JSON in datagrams, a command in each, and an answer to each."""

import json
import socket
from collections.abc import Callable, Mapping
from typing import Any

from skinfield.errors import InputError, SkinfieldError
from skinfield.sources.live.places import host_and_port

LONGEST = 4096  # bytes of a command
ANSWER = 60_000  # bytes of an answer: one datagram
PER_POLL = 64  # commands, so that a flood of them delays no reading for long
DEEP = 8  # levels that a command's JSON may have

Command = Callable[[Mapping[str, Any]], dict[str, Any]]


def answer_to(data: bytes, commands: Mapping[str, Command]) -> dict[str, Any]:
    """Do what a datagram says; ``{"ok": true, ...}``, or false with the error in words.

    A `tag` in the command comes back in the answer.

    Parameters
    ----------
    data : bytes
        Anything.
    commands : mapping
        By the value of `do`.
    """
    tag: Any = None
    try:
        given = _parsed(data)
        tag = given.get("tag")
        name = given.get("do")
        if not isinstance(name, str) or name not in commands:
            raise InputError(f"do is {name!r:.60}, expected one of {', '.join(sorted(commands))}")
        answer = {"ok": True, **commands[name](given)}
    except SkinfieldError as error:
        answer = {"ok": False, "error": str(error)[:2000]}
    return answer if tag is None else {"tag": tag, **answer}


def _parsed(data: bytes) -> Mapping[str, Any]:
    if len(data) > LONGEST:
        raise InputError(f"command has {len(data)} bytes, expected at most {LONGEST}")
    try:
        given = json.loads(data.decode())
    except (ValueError, RecursionError) as error:
        raise InputError(f"command is no JSON: {error}, expected an object with 'do'") from error
    if not isinstance(given, dict) or _depth(given) > DEEP:
        raise InputError("command is no plain object, expected one such as {'do': 'counts'}")
    return given


def _depth(value: Any, level: int = 1) -> int:
    if level > DEEP:
        return level
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return max((_depth(each, level + 1) for each in inner), default=level)


class Control:
    """A bound socket that answers.

    Parameters
    ----------
    address : str
        ``"127.0.0.1:0"``.
    commands : mapping of str to function
        What `do` can be.

    Raises
    ------
    InputError
        If the address cannot be bound.
    """

    def __init__(self, address: str, commands: Mapping[str, Command]) -> None:
        place = host_and_port(address, "127.0.0.1", 0)
        self._commands = commands
        family = socket.AF_INET6 if ":" in place[0] else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.bind(place)
        except (OSError, UnicodeError) as error:
            self._socket.close()
            raise InputError(
                f"control is {address!r}, expected an address of this machine that is free: {error}"
            ) from error
        self._socket.setblocking(False)

    @property
    def address(self) -> str:
        """Where it is reached."""
        host, port = self._socket.getsockname()[:2]
        return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"

    def fileno(self) -> int:
        """Of the socket."""
        return self._socket.fileno()

    def poll(self) -> None:
        """Do and answer what has arrived; never waits."""
        for _ in range(PER_POLL):
            try:
                data, sender = self._socket.recvfrom(LONGEST + 1)
            except OSError:
                return  # nothing more, or an answer that met nobody
            answer = encoded(answer_to(data, self._commands))
            try:
                self._socket.sendto(answer, sender)
            except OSError:
                continue  # who asked is gone

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def encoded(answer: Mapping[str, Any]) -> bytes:
    """Bytes of an answer, or of the error that it is too long."""
    data = json.dumps(answer).encode()
    if len(data) > ANSWER:
        short = {"ok": False, "error": f"the answer has {len(data)} bytes: ask for less at once"}
        return json.dumps({**short, "tag": answer["tag"]} if "tag" in answer else short).encode()
    return data
