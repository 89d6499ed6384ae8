"""Streams of iCub's messages for tests: regular ones, and what becomes of them on the way."""

from collections import Counter
from itertools import pairwise

import numpy as np

from skinfield.signal import Blocks, Count, blocks_of, counters
from skinfield.wire.can.messages import CanMessages
from skinfield.wire.icub import ICubDecoder

MS = 1_000_000
BOARDS = ((0, 13), (1, 3), (0, 2))


def filled(rows):
    """Messages of (identifier, data, stamp in ms)."""
    messages = CanMessages(max(len(rows), 1))
    for row, (identifier, data, stamp) in enumerate(rows):
        messages.put(row, identifier, data)
        messages.stamp_ns[row] = round(stamp * MS)
    return messages, len(rows)


def decoded(rows, channel=0, **settings):
    """Blocks, and what was counted."""
    decoder = ICubDecoder(BOARDS, **settings)
    messages, count = filled(rows)
    blocks, counts = Blocks(1024 + 64 * len(rows)), counters()
    assert decoder.decode(messages, count, blocks, channel, counts) == count
    return list(blocks_of(blocks.data)), Counter(
        {each.name: int(counts[each]) for each in Count if counts[each]}
    )


def counted(rows, **settings):
    """Lost and duplicated messages."""
    found = decoded(rows, **settings)[1]
    return found["LOST"], found["DUPLICATED"]


def head(k, board=13, triangle=0):
    return 0x400 | board << 4 | triangle, bytes([0x40, *([k & 255] * 7)])


def tail(k, board=13, triangle=0):
    return 0x400 | board << 4 | triangle, bytes([0xC0, *([k & 255] * 5), 0, 0])


def regular(readings, triangles=1, period=10.0, rest=False, board=13):
    """Rows of readings in the order of sending; of a moving skin, or of one at rest."""
    step = min(0.1, period / (2 * triangles))
    return [
        (
            *part(0 if rest else reading * 3 + triangle, board, triangle),
            reading * period + (2 * triangle + after) * step,
        )
        for reading in range(readings)
        for triangle in range(triangles)
        for part, after in ((head, 0), (tail, 1))
    ]


def polled(rows, every):
    """The same rows with the stamps of a receiver that looks every so many ms."""
    return [(i, data, (stamp // every + 1) * every) for i, data, stamp in rows]


def delayed(rows, rng, chance, most):
    """Every now and then all that follows waits, and then comes at once."""
    found, until = [], -1.0
    for identifier, data, stamp in rows:
        if stamp > until and rng.random() < chance:
            until = stamp + most * rng.random()
        found.append((identifier, data, max(stamp, until)))
    return found


def wired(rows, rng, lose=0.0, duplicate=0.0):
    """What arrives, and how many were lost and came twice."""
    out, truth = [], Counter()
    for row in rows:
        if rng.random() < lose:
            truth["lost"] += 1
            continue
        out.append(row)
        if rng.random() < duplicate:
            out.append(row)
            truth["duplicated"] += 1
    return out, truth


def repeats(rows):
    """How often a triangle's parts of one kind stand side by side."""
    kinds = {}
    for identifier, data, _ in rows:
        kinds.setdefault(identifier, []).append(data[0])
    return sum(a == b for each in kinds.values() for a, b in pairwise(each))


def seeded(*numbers):
    return np.random.default_rng(numbers)
