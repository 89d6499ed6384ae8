"""Rings under names of their own, and the processes that write and read them."""

import shutil
import subprocess
import sys
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from skinfield import loop
from skinfield.ring import Field, Ring, RingReader, include_folder

WORDS = 512
SLOT = (Field("number", "<i8"), Field("words", "<u8", (WORDS,)))
STRICT = ("-O2", "-Wall", "-Wextra", "-Werror", "-pedantic")
WORKER = Path(__file__).with_name("ring_worker.py")


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


@contextmanager
def worker(*arguments: object) -> Iterator[subprocess.Popen[str]]:
    """A process of `ring_worker.py`, killed at the end if it still runs."""
    command = [sys.executable, str(WORKER), *map(str, arguments)]
    process = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=WORKER.parent
    )
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
