"""The live table: what it says, in 80 columns and in more."""

import io
import re
import time
from dataclasses import replace
from typing import Any

import pytest
from rich.console import Console

from skinfield.cli.report import shortened
from skinfield.cli.status_table import status_table
from skinfield.loop.realtime import Quantiles, Timing
from skinfield.loop.status import LiveStatus
from skinfield.signal import Count

SECOND = Quantiles(38e-6, 121e-6, 25.6e-3, 1.23, 5e-5, 1000)
NAMES = [f"left_forearm_{number:02}" for number in range(60)]


def timing(cycles: int, late: int = 0) -> Timing:
    return Timing(SECOND, SECOND, SECOND, SECOND, SECOND, cycles, late, 0, 0)


def patch(name: str, **changes: Any) -> dict[str, Any]:
    known = {"name": name, "answer": "idle", "age": 0.011, "stale": False, "force": 0.0}
    return known | {"contacts": 0, "readings": 16, "invalid": 0, "rung": 10, "gap": None} | changes


def contact(track: int, where: str, force: float, **changes: Any) -> dict[str, Any]:
    known = {"track": track, "patch": where, "normal_force": force, "force_std": 0.12}
    known |= {
        "position": [-0.1234, 0.0071, -0.0002],
        "area": 27e-6,
        "shape": "sphere",
        "maybe": 0,
    }
    return known | {"age": 2.71} | changes


def counted(**changes: int) -> dict[str, int]:
    return {each.name.lower(): 0 for each in Count} | changes


def idle(names: list[str] = NAMES) -> LiveStatus:
    return LiveStatus(
        name="skin",
        state="running",
        since=timing(48_672),
        lately=timing(1000),
        seconds=1.0,
        rate=999.6,
        sources={"ICubCan": counted(received=186_720)},
        sources_lately={"ICubCan": counted(received=2_400)},
        patches=[patch(name) for name in names],
        contacts=[],
        notes={"phase": "running"},
    )


def one_contact() -> LiveStatus:
    touched = [patch("hexagon72", answer="contacts", force=1.83, contacts=1, rung=40)]
    return replace(idle(["x"]), patches=touched, contacts=[contact(9, "hexagon72", 1.83)])


def many_contacts() -> LiveStatus:
    """14 on 5 of 60 patches."""
    rows = [contact(100 + at, NAMES[at % 5], 0.4 + 0.31 * (at * 5 % 14)) for at in range(14)]
    rows[3] |= {"maybe": 2, "force_std": None, "normal_force": 123.456, "age": 86_400.0}
    patches = [
        patch(name, answer="contacts", force=2.5, contacts=3, rung=40) if at < 5 else patch(name)
        for at, name in enumerate(NAMES)
    ]
    return replace(idle(NAMES), patches=patches, contacts=rows)


def dead_source() -> LiveStatus:
    patches = [patch(name, answer="missing", age=12.3, rung=0) for name in NAMES]
    counts = counted(received=186_720, lost=12, reopened=2, down_ns=3_400_000_000)
    lately = {"ICubCan": counted()}
    return replace(idle(NAMES), patches=patches, sources={"ICubCan": counts}, sources_lately=lately)


def calibrating() -> LiveStatus:
    nothing = timing(0)._replace(wake=None, ready=None, latency=None)
    patches = [patch("hexagon72", answer="missing", age=None, rung=0)]
    notes = {"phase": "taring"}
    return replace(
        idle(["x"]),
        state="calibrating",
        notes=notes,
        patches=patches,
        since=nothing,
        lately=nothing,
    )


def relative() -> LiveStatus:
    return replace(many_contacts(), relative=True)


def restarted() -> LiveStatus:
    events = [[time.time_ns(), "failed", "ended with signal SIGKILL: " + "signal " * 20]]
    return replace(
        one_contact(),
        generation=2,
        sidecars={
            "supervisor": {"events": events},
            "recorder": {"bytes_written": 41_000_000, "path": "/data/" + "long" * 30},
        },
    )


def failed() -> LiveStatus:
    return replace(many_contacts(), state="failed", rate=0.0)


SCENES = (idle, one_contact, many_contacts, relative, dead_source, calibrating, restarted, failed)


def text_of(status: LiveStatus, width: int, height: int | None = None, styles: bool = False) -> str:
    console = Console(record=True, width=width, force_terminal=True, file=io.StringIO())
    console.print(status_table(status, width, height))
    return console.export_text(styles=styles)


@pytest.mark.parametrize("made", SCENES)
def test_it_fits_and_nothing_is_left_out(made: Any) -> None:
    status = made()
    texts = [text_of(status, width) for width in (80, 120)]
    for width, text in zip((80, 120), texts, strict=True):
        assert "…" not in text
        assert max(map(len, text.splitlines())) <= width
        for row in status.contacts:
            assert re.search(rf"^ +{row['track']} ", text, re.M)
        assert f"{status.since.cycles:,} cycles, 0 late" in text
    assert len({len(text.splitlines()) for text in texts}) == 1  # nothing wraps in 80


@pytest.mark.parametrize("made", SCENES)
def test_it_keeps_to_a_low_screen(made: Any) -> None:
    text = text_of(made(), 80, 24)
    assert len(text.splitlines()) <= 24
    assert " cycles, " in text


def test_contacts_come_by_falling_force_with_all_their_numbers() -> None:
    lines = text_of(many_contacts(), 120).splitlines()
    first = next(at for at, line in enumerate(lines) if "x mm" in line) + 1
    rows = [line.split() for line in lines[first : first + 14]]
    forces = [float(row[2]) for row in rows]
    assert forces == sorted(forces, reverse=True)
    assert rows[0][:4] == ["103", NAMES[3], "123.46", "–"]
    assert rows[0][7:] == ["27", "two?", "86400.0"]
    assert rows[1][2:] == ["4.43", "0.12", "-123.4", "7.1", "-0.2", "27", "sphere", "2.7"]


def test_what_does_not_fit_is_counted() -> None:
    text = text_of(many_contacts(), 80, 22)
    rows = len(re.findall(r"^ +1\d\d ", text, re.M))
    assert re.search(rf"^ {14 - rows} more, \d+\.\d\d N in all", text, re.M)


def test_forces_say_where_they_are_relative() -> None:
    for made, newtons in ((many_contacts, True), (relative, False)):
        text = text_of(made(), 80, 22)
        assert text.count("force N") == text.count("N in all") + newtons == 2 * newtons
        assert ("forces relative\n" in text) == (" (relative) in all" in text) == (not newtons)


def test_columns_stay_where_they_are() -> None:
    small, large = one_contact(), one_contact()
    large.contacts[0] |= contact(99_999, "hexagon72", 999.9, age=9.9e4, area=99_999e-6)
    lines = [text_of(each, 80).splitlines() for each in (small, large)]
    heads = [next(line for line in each if "x mm" in line) for each in lines]
    assert heads[0] == heads[1]
    places = [each.index(head) + 1 for each, head in zip(lines, heads, strict=True)]
    rows = [each[place].rstrip() for each, place in zip(lines, places, strict=True)]
    assert len(rows[0]) == len(rows[1])


def test_what_is_missing_or_old_is_red() -> None:
    red = "\x1b[31m"
    for made in (dead_source, failed):
        assert red in text_of(made(), 80, styles=True)
    assert "\x1b[1;31msilent" in text_of(dead_source(), 80, styles=True)
    for made in (one_contact, many_contacts, calibrating):
        text = text_of(made(), 80, styles=True)
        assert red not in text
        assert "\x1b[1;31m" not in text


def test_it_says_what_to_do_and_what_happened() -> None:
    assert "leave the skin untouched" in text_of(calibrating(), 80)
    text = text_of(restarted(), 80)
    assert "started 2 times" in text
    assert "engine failed: ended with signal SIGKILL" in text
    assert "recording 41.0 MB into /data/" in text
    assert "60 patches: 0 touched, 0 idle, 60 missing" in text_of(dead_source(), 80)


def test_names_keep_both_ends() -> None:
    assert shortened("left_forearm_17", 11) == "left_~rm_17"
    assert shortened("hexagon72", 11) == "hexagon72"
    long = replace(idle(["the_left_forearm_17"]), contacts=[contact(1, "the_left_forearm_17", 1.0)])
    assert "the_lef~earm_17" in text_of(long, 80)
    assert "the_left_forearm_17" in text_of(long, 90)
