"""Cost of the ring in shared memory: what a cycle pays, and how soon readers know.

Run: python benchmarks/bench_ring.py [--laps 5000] [--readers 0 1 3] [--kilobytes 4 64] [--fifo]

For each number of waiting readers, each a process, and each size of a slot: times of the writer's
calls (minimum and median; on a machine that others use too the minimum is what the call costs), the
time from the beginning of `publish` until a reader has the copy, and what could not be read.
The writer publishes every half millisecond, so that readers sleep in between. With --fifo it runs
as the engine does: SCHED_FIFO, on the last CPU, which needs the permission.
"""

import argparse
import multiprocessing
import os
import time
import uuid
from multiprocessing.connection import Connection

import numpy as np

from skinfield.ring import Field, Ring, RingReader

PERIOD = 0.0005  # s
LAST = -1  # stamp that ends it
BATCH = 6000  # bytes of the log per cycle: 4000 taxels of one byte with the heads of their blocks


def read(name: str, ready: Connection) -> None:
    """Wait for each slot and copy it; send the times it took, ns, and how many were missed."""
    reader, delays, missed, number = RingReader(name), [], 0, 0
    slot = reader.slot()
    ready.send(None)
    while True:
        newest = reader.wait(number, 60.0)
        if reader.latest(slot) is None:
            continue
        missed += slot.number - number - 1
        number = slot.number
        stamp = int(slot["stamp"])
        if stamp == LAST or newest == 0:
            break
        delays.append(time.monotonic_ns() - stamp)
    ready.send((delays, missed))


def lap(ring: Ring, batch: np.ndarray, stamp: int | None = None) -> list[int]:
    """One cycle; ns of begin, log and publish, and how the stamp was taken before publish."""
    clock = time.monotonic_ns
    t0 = clock()
    slot = ring.begin()
    t1 = clock()
    ring.log(batch)
    t2 = clock()
    slot["stamp"][...] = clock() if stamp is None else stamp
    t3 = clock()
    ring.publish()
    return [t1 - t0, t2 - t1, clock() - t3]


def measure(kilobytes: int, readers: int, laps: int, fifo: bool) -> None:
    """One line of the table."""
    name = f"bench-{uuid.uuid4().hex[:12]}"
    fields = [Field("stamp", "i8"), Field("pressure", "f4", (256 * kilobytes,))]
    context = multiprocessing.get_context("spawn")
    with Ring.create(name, fields) as ring:
        pipes = [context.Pipe() for _ in range(readers)]
        processes = [context.Process(target=read, args=(name, theirs)) for _, theirs in pipes]
        for process in processes:
            process.start()
        for ours, _ in pipes:
            ours.recv()
        if fifo:
            os.sched_setaffinity(0, {os.cpu_count() - 1})
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(80))
        batch, times = np.zeros(BATCH, np.uint8), []
        for _ in range(laps):
            time.sleep(PERIOD)
            times.append(lap(ring, batch))
        lap(ring, batch, LAST)
        if fifo:
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
            os.sched_setaffinity(0, range(os.cpu_count()))
        found = [ours.recv() for ours, _ in pipes]
        for process in processes:
            process.join()
        ring.unlink()
    columns = np.array(times).T / 1e3
    text = "  ".join(f"{column.min():6.1f} {np.median(column):6.1f}" for column in columns)
    delays = np.concatenate([each for each, _ in found]) / 1e3 if found else np.zeros(1)
    quantiles = " ".join(f"{q:7.0f}" for q in np.quantile(delays, (0, 0.5, 0.99)))
    print(f"{kilobytes:5d} {readers:7d}   {text}   {quantiles} {sum(each for _, each in found):7d}")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--laps", type=int, default=5000)
    parser.add_argument("--readers", type=int, nargs="+", default=[0, 1, 3])
    parser.add_argument("--kilobytes", type=int, nargs="+", default=[4, 64])
    parser.add_argument("--fifo", action="store_true")
    options = parser.parse_args()
    print(f"{os.cpu_count()} CPUs; µs, minimum and median of {options.laps}, log of {BATCH} bytes")
    print("slot kB readers         begin            log        publish   until copied: min p50 p99")
    for kilobytes in options.kilobytes:
        for readers in options.readers:
            measure(kilobytes, readers, options.laps, options.fifo)


if __name__ == "__main__":
    main()
