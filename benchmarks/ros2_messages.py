"""What the messages for ROS 2 cost: processor time of each kind, the least of many times, in µs."""

import sys
import time
import uuid
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from ros2_ring import TwoPatches, contact

from skinfield.bridges.ros2.messages import SAID, Speaker
from skinfield.files.ros import RosbagKinds
from skinfield.loop.client import Live
from skinfield.loop.status import Observer

TIMES = 400
STAMP = 1_700_000_000_000_000_000
TOUCH = [
    contact(0, 7, 2.0, (0.01, 0, 0)),
    contact(0, 8, 2.0, (0, 0, 0)),
    contact(1, 9, 1, (0, 0, 0)),
]


def main() -> None:
    engine, kinds = TwoPatches(f"bench{uuid.uuid4().hex[:8]}"), RosbagKinds()
    least: dict[str, float] = {}
    try:
        with Live(engine.ring.name) as live:
            speaker, health = Speaker(live.skin, kinds), Observer(live.reader)
            for number in range(TIMES):
                engine.cycle(TOUCH, (STAMP + number, STAMP + number))
                snapshot = live.latest()
                for what in SAID:
                    start = time.thread_time()
                    if what == "diagnostics":
                        outs = [speaker.of_status(health.look(), STAMP)]
                    else:
                        outs = list(speaker.of_snapshot(snapshot, (what,)))
                    for out in outs:
                        kinds.bytes_of(out.kind, out.message)
                    least[what] = min(least.get(what, 1.0), time.thread_time() - start)
    finally:
        engine.close()
    for what, seconds in least.items():
        print(f"{what:15} {1e6 * seconds:6.0f}")


if __name__ == "__main__":
    main()
