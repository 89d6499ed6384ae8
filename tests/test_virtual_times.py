"""What leaves a virtual skin, when and in which order, and what is known of it."""

import json

import numpy as np
import pytest

from skinfield.layout import Skin
from skinfield.layout.generators import by_name
from skinfield.protocols.packet import PacketKind, encode_command
from skinfield.virtual import Wires
from skinfield.virtual.delivery import Fates
from skinfield.virtual.packet_ear import Ear
from skinfield.virtual.schedule import NEVER, Schedule
from skinfield.virtual.tool import Tool
from skinfield.virtual.touch import Touch
from skinfield.virtual.truth import Truth

SKIN = Skin((by_name("hexagon72"),))
MS = 1_000_000


@pytest.mark.parametrize("seed", range(3))
def test_fates_of_messages_can_be_counted_from_what_arrives(seed):
    """Numbers that are missing, doubled, or behind a later one: a second count, in plain Python."""
    rng = np.random.default_rng(seed)
    fates = Fates(50, Wires(lose=0.1, duplicate=0.1, swap=0.1), rng)
    out, first, kept = [], 0, None
    for burst in rng.integers(0, 50, 200):
        going = fates.draw(int(burst))
        for index in fates.order[:going]:
            out.append(kept if index == -1 else first + int(index))
        if fates.kept[0] >= 0:
            kept, fates.kept[0] = first + int(fates.kept[0]), -1
        first += int(burst)
    numbers = np.array(out)
    missing = first - len(set(out)) - int(fates.kept[0] == -1)
    behind = (numbers < np.maximum.accumulate(numbers)).sum()
    lost, doubled, swapped = fates.counts.tolist()
    assert (lost, doubled, swapped) == (missing, len(out) - len(set(out)), behind)
    assert min(lost, doubled, swapped) > 0.05 * first


def test_a_schedule_keeps_to_absolute_times():
    schedule = Schedule(False, 0.0, np.random.default_rng(0))
    assert schedule.next_ns == NEVER
    schedule.set({0: MS, 1: MS}, 2, 10 * MS + 5)
    assert schedule.next_ns == 11 * MS
    assert schedule.due(11 * MS - 1) == []
    (group,) = schedule.due(11 * MS + 400_000)  # late, but the next one is not
    assert group.members == (0, 1)
    assert schedule.next_ns == 12 * MS
    schedule.due(16 * MS + 1)
    assert schedule.skipped == 2 * 3  # 12 is sent late; 13, 14, 15 are not, of two boards
    assert schedule.next_ns == 16 * MS  # which is late by less than a period
    schedule.due(16 * MS + 2)
    assert schedule.skipped == 2 * 3
    assert schedule.next_ns == 17 * MS
    schedule.begin(40 * MS - 1)  # nothing was due before
    assert (schedule.next_ns, schedule.skipped) == (40 * MS, 2 * 3)


def test_jitter_never_moves_a_reading_behind_the_next():
    schedule = Schedule(False, 10e-3, np.random.default_rng(0))
    schedule.set({0: MS}, 1, 0)
    times = []
    for _ in range(1000):
        times.append(schedule.next_ns)
        schedule.due(schedule.next_ns)
    assert (np.diff(times) > 0).all()
    late = np.array(times) % MS
    assert late.max() > 0.8 * MS
    assert schedule.skipped == 0


def test_commands_are_found_in_a_stream_cut_anywhere():
    whole = b"SFx" + b"".join(
        encode_command(kind, sequence=n)
        for n, kind in enumerate([PacketKind.START, PacketKind.STOP, PacketKind.ASK])
    )
    for cut in range(len(whole)):
        ear = Ear()
        found = [*ear.packets(whole[:cut]), *ear.packets(whole[cut:]), *ear.packets(b"")]
        assert [packet.sequence for packet in found] == [0, 1, 2]


def test_the_truth_has_the_end_of_every_movement(tmp_path):
    truth = Truth(SKIN, str(tmp_path / "truth.jsonl"))
    at = lambda x: [(Touch("a", 0, Tool(), x, 0.0, 1.0), 2e-3)]
    truth.note([], 0)
    truth.note(at(1e-3), 1 * MS)
    for step in range(2, 30):  # every millisecond: a line each 10 ms
        truth.note(at(step * 1e-3), step * MS)
    truth.settle(30 * MS)
    assert truth.made == 4
    truth.settle(31 * MS)
    truth.settle(90 * MS)
    truth.note([], 100 * MS)
    truth.close()
    lines = [json.loads(line) for line in (tmp_path / "truth.jsonl").read_text().splitlines()]
    found = [(line["stamp_ns"] // MS, [p["x"] for p in line["presses"]]) for line in lines]
    assert found == [(0, []), (1, [1e-3]), (11, [11e-3]), (21, [21e-3]), (29, [29e-3]), (100, [])]
    assert truth.after(2, 2) == lines[2:4]
