"""A process of the tests of rings: python ring_worker.py ROLE NAME [COUNT]."""

import ctypes
import json
import os
import sys
import time

import numpy as np
from ring_scenes import SLOT, WORDS, write

from skinfield.errors import InputError
from skinfield.ring import Ring, RingReader

SLOTS, LOG_BYTES = 4, 1 << 16


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def open_writer(name: str) -> Ring:
    ring = Ring.reopen(name, SLOT, slots=SLOTS, log_bytes=LOG_BYTES)
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
