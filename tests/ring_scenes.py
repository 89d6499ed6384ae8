"""Rings under names of their own, and the processes that write and read them.

python ring_scenes.py ROLE NAME [COUNT]
"""

import ctypes
import json
import os
import shutil
import subprocess
import sys
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from skinfield import loop
from skinfield.errors import InputError
from skinfield.ring import Field, Ring, RingReader, include_folder

WORDS = 512
SLOT = (Field("number", "<i8"), Field("words", "<u8", (WORDS,)))
STRICT = ("-O2", "-Wall", "-Wextra", "-Werror", "-pedantic")
SLOTS, LOG_BYTES = 4, 1 << 16


@contextmanager
def own_name() -> Iterator[str]:
    """A name that nobody else has; nothing of it stays behind."""
    name = f"test-{uuid.uuid4().hex}"
    try:
        yield name
    finally:
        Ring.remove(name)


def bytes_of(text: bytes) -> NDArray[np.uint8]:
    return np.frombuffer(text, np.uint8)


def write(ring: Ring, count: int = 1) -> int:
    """Publish slots all of whose words are their number; the newest number."""
    for _ in range(count):
        slot, number = ring.begin(), ring.number + 1
        slot["number"][...] = number
        slot["words"][:] = number
        assert ring.publish() == number
    return ring.number


def numbers(reader: RingReader) -> list[int]:
    """Slots that can be read, each of them checked."""
    found = []
    for number in range(reader.number + 2):
        slot = reader.get(number)
        if slot is not None:
            assert slot.number == number == slot["number"]
            assert np.array_equal(slot["words"], np.full(WORDS, number))
            found.append(number)
    return found


def go(process: subprocess.Popen[str]) -> None:
    """Tell a process that waits for a line."""
    process.stdin.write("go\n")
    process.stdin.flush()


@contextmanager
def worker(*arguments: object) -> Iterator[subprocess.Popen[str]]:
    """A process in one of the roles below, killed at the end if it still runs."""
    command = [sys.executable, __file__, *map(str, arguments)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def compiled(source: Path, folder: Path, *options: str, compiler: str = "cc") -> Path:
    """A program of C that has our headers."""
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler} on this machine")
    program = folder / source.stem
    headers = [f"-I{each}" for each in (include_folder(), loop.include_folder())]
    command = [compiler, *STRICT, *options, *headers, str(source), "-o", str(program)]
    subprocess.run(command, check=True, timeout=120)
    return program


# what a process of its own does


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def reopened(name: str) -> Ring:
    return Ring.reopen(name, SLOT, slots=SLOTS, log_bytes=LOG_BYTES)


def open_writer(name: str) -> Ring:
    ring = reopened(name)
    say("ready")
    return ring


def write_on(name: str, count: int) -> None:
    """Publish and log at full speed; batches in the log are words that count up."""
    ring = open_writer(name)
    sys.stdin.readline()
    word, batch = ring.log_end // 8, np.zeros(64, np.uint64)
    for i in range(count):
        write(ring)
        size = i % 64 + 1
        batch[:size] = np.arange(word, word + size)
        ring.log(batch.view(np.uint8), 8 * size)
        word += size
    ring.close()
    say("done")


def stop_within(name: str, where: int) -> None:
    """Stop in the middle of a slot (0), or of a batch of the log (1), to be killed there."""
    ring = open_writer(name)
    if where == 0:
        ring.begin()["words"][: WORDS // 2] = 666
    else:  # as Log.append does up to its copying
        ring._words[33] = ring.log_end + 4096
        ring._log._octets[ring.log_end % LOG_BYTES :][:2048] = 66
    say("half")
    time.sleep(600)


def read_on(name: str, count: int) -> None:
    """Read until slot `count`; say how many were whole, torn, overtaken, and what the log lost."""
    reader = RingReader(name)
    slot, log, word = reader.slot(), reader.log_reader(), 0
    whole = torn = overtaken = taken = 0
    say("ready")
    newest, wanted = 0, 0
    while newest < count:
        newest = reader.wait(wanted, 60.0)
        wanted = newest
        if reader.get(newest, slot) is None:
            overtaken += 1
        else:
            same = bool((slot["words"] == newest).all() and slot["number"] == newest)
            whole, torn = whole + same, torn + (not same)
        data, _ = log.read()
        words = np.frombuffer(data, np.uint64)
        word = (log.position - len(data)) // 8
        torn += not np.array_equal(words, np.arange(word, word + len(words)))
        taken += len(data)
    result = {"whole": whole, "torn": torn, "overtaken": overtaken, "newest": newest}
    say(json.dumps(result | {"log": taken, "lost": log.lost}))


def scribble(name: str, _: int) -> None:
    """Write to the reader's mapping, past all of Python."""
    reader = RingReader(name)
    say("ready")
    ctypes.memset(reader._slots[0].ctypes.data, 1, 8)
    say("written")


def create(name: str, _: int) -> None:
    """Try to make the ring when told, and keep it."""
    say("ready")
    sys.stdin.readline()
    try:
        with Ring.create(name, SLOT):
            say("won")
            sys.stdin.readline()
    except InputError:
        say("refused")


def fork(name: str, _: int) -> None:
    """Write, and leave a child behind that does nothing."""
    ring = open_writer(name)
    if not os.fork():
        ring.close()  # nothing: it is its parent's
        say(str(os.getpid()))
    time.sleep(600)


ROLES = {"write": write_on, "stop": stop_within, "read": read_on, "scribble": scribble}
ROLES |= {"create": create, "fork": fork}

if __name__ == "__main__":
    ROLES[sys.argv[1]](sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 0)
