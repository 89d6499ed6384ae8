"""Contact lists of iCub's skinManager: logs in, damage, and numbers that last."""

import csv
from collections import defaultdict
from collections.abc import Sequence
from contextlib import suppress
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from any_bytes import ANYTHING, damaged
from command_line import refused, result_of, run
from hypothesis import given, settings
from skin_events import Arm, Press, dump, log_of
from yarp_peers import values_of

import skinfield as sf
from skinfield.errors import FileError, InputError
from skinfield.estimate import ContactList, ListedContact
from skinfield.estimate.link_chart import LinkChart
from skinfield.files import open_recording
from skinfield.wire.yarp import (
    SkinContact,
    open_contact_log,
    text_from_bottle,
    values_from_text,
)

RIGHT, LEFT = Arm((4, 4, 5)), Arm((3, 4, 2))
ONE = Arm((4, 4, 5), along=0.03)


def slide(k: int) -> list[Sequence[Press]]:
    """A hand slides round three quarters of one arm; a finger rests on the other at the threshold.

    The hand is away for eight readings now and then, and comes apart into two.
    """
    x, y = 0.04 * (-2.2 + 4.4 * k / 450), 0.05 + 0.01 * np.sin(k / 60)
    hand: list[Press] = [(x, y, 60.0, 0.006)]
    if k // 29 % 5 == 1:
        hand = [(x, y - 0.011, 50.0, 0.004), (x, y + 0.011, 50.0, 0.004)]
    return [[] if k % 97 < 8 else hand, [(0.0, 0.05, 10.0 + 3.0 * np.sin(k / 9), 0.006)]]


@pytest.fixture(scope="module")
def slides(tmp_path_factory: pytest.TempPathFactory) -> Path:
    text = log_of([RIGHT, LEFT], slide, 450, repeated=0.02)
    return dump(tmp_path_factory.mktemp("dump") / "skin_events", text)


def press(k: int) -> list[Sequence[Press]]:
    """A press from reading 3 to 9 of ten."""
    return [[(0.0, 0.015, 40.0, 0.005)] if k % 10 > 2 else []]


TEXT = log_of([ONE], press, 40)


def test_bottles_and_contacts_come_back() -> None:
    """Against a reader of its own, and back through what is written."""
    line = TEXT.splitlines()[-1].split(" ", 2)[2]
    assert values_from_text(line) == values_of(line)
    odd = [["left arm", 1, -2.5, []], 'say "no"\\\n', "word", float("inf")]
    assert values_from_text(text_from_bottle(odd)) == odd
    (values,) = values_of(line)
    contact = SkinContact.of(values)
    assert contact.values == values
    assert SkinContact.of([*values, ["link", "frame"], 3]).values == values  # newer ones
    assert contact.listed(6e-3).place_std == pytest.approx(
        np.sqrt(2) * 3e-3 / np.sqrt(len(values[6]))
    )
    for text in ("(", ")", '"', "(" * 20 + ")" * 20, 'a"'):
        with pytest.raises(InputError):
            values_from_text(text)
    for at, wrong in ((0, [1, 2, 3]), (1, [1.0, 2.0]), (1, [90.0, 0.0, 0.0]), (6, []), (7, "x")):
        with pytest.raises(InputError):
            SkinContact.of([*values[:at], wrong, *values[at + 1 :]])


def listed(position: Sequence[float], normal: Sequence[float], link: int = 4) -> ListedContact:
    place, up = np.array(position, float), np.array(normal, float)
    return ListedContact.of(
        position=place, force=-2.0 * up, moment=np.zeros(3), normal=up, taxels=4, link=link
    )


def test_a_link_is_developed_by_arc_length() -> None:
    """A helix of 45° round a cylinder is a straight line, as long as it is."""
    chart, radius = LinkChart(6.5e-3), 0.03
    angle = np.linspace(0.0, 1.5 * np.pi, 400)
    normals = np.column_stack([np.sin(angle), 0 * angle, np.cos(angle)])
    places = radius * normals + np.column_stack([0 * angle, radius * angle, 0 * angle])
    plane = np.concatenate(
        [chart.plane_of([listed(*both)]) for both in zip(places, normals, strict=True)]
    )
    steps = plane - plane[0]
    expected = np.sqrt(2.0) * radius * angle
    np.testing.assert_allclose(np.linalg.norm(steps, axis=1), expected, atol=0.02 * expected[-1])
    back = chart.position_from_plane(plane)
    assert 0 < np.abs(back - places).max() < 6e-4  # of a tangent plane, half a spacing away
    frames = chart.frame_from_plane(plane)
    np.testing.assert_allclose(np.einsum("nji,njk->nik", frames, frames),
                               np.broadcast_to(np.eye(3), (400, 3, 3)), atol=1e-12)  # fmt: skip
    other = chart.plane_of([listed(places[0], normals[0], link=5)])  # the same place elsewhere
    assert np.linalg.norm(other - plane, axis=1).min() > 1.0


def test_numbers_last_round_an_arm(slides: Path) -> None:
    """One number for each of two touches, though each list numbers its contacts anew."""
    log, tracker = open_contact_log(slides), sf.Tracker.for_lists()
    seen: dict[tuple[str, int], int] = defaultdict(int)
    sent, most = set(), defaultdict(int)
    for reading in log.readings():
        tracked = [each for each in tracker(reading) if not each.is_coasting]
        assert {each.measured.number for each in tracked} == {c.number for c in reading.contacts}
        for each in tracked:
            seen[each.measured.skin, each.track_id] += 1
            sent.add(each.measured.number)
            assert np.linalg.norm(each.position - each.measured.position) < 15e-3
        for skin in {each.measured.skin for each in tracked}:
            most[skin] += 1
    assert len(sent) == sum(seen.values()) > 600
    for skin in ("r_forearm", "l_forearm"):
        longest = max(times for (part, _), times in seen.items() if part == skin)
        assert longest == most[skin] > 200  # it is there in every reading with a contact
    assert len(seen) <= 6
    assert log.passed > 3
    assert log.skipped == 0
    assert any("relative, no newtons" in note for note in log.notes)
    assert any(f"{log.passed} stamps repeat" in note for note in log.notes)


def test_a_tracker_takes_either_and_says_so() -> None:
    tracker = sf.Tracker.for_lists()
    one = ContactList(stamp_ns=1, contacts=(listed([0, 0, 0.04], [0, 0, 2]),))
    (first,) = tracker(one)
    assert first.normal_force == pytest.approx(4.0)  # the normal need not be of length 1
    with pytest.raises(InputError, match="expected after 1"):
        tracker(one)
    tracker.reset()
    (second,) = tracker(one)
    assert second.track_id > first.track_id
    patch = sf.layouts.hexagon72()
    estimate = sf.Reconstructor(patch, quantity=sf.BaseStress(), solver=sf.GaussianField(),
                                noise_std=400.0)(np.zeros(72), stamp_ns=2)  # fmt: skip
    with pytest.raises(InputError, match=r"hexagon72.*expected lists of contacts"):
        tracker(estimate)
    with pytest.raises(InputError, match="finite"):
        listed([np.nan, 0, 0], [0, 0, 1])


def test_a_contact_without_a_place_keeps_its_number() -> None:
    """skinManager does not know where the taxels are: zeros."""
    tracker = sf.Tracker.for_lists()
    zero = listed([0, 0, 0], [0, 0, 0])
    found = [tracker(ContactList(stamp_ns=10**7 * k, contacts=(zero,))) for k in range(1, 9)]
    assert {each.track_id for (each,) in found} == {0}


def test_two_as_strong_become_the_older() -> None:
    tracker = sf.Tracker.for_lists()

    def at(*places: float) -> ContactList:
        contacts = tuple(listed([x, 0, 0.04], [0, 0, 1]) for x in places)
        return ContactList(stamp_ns=next(stamps), contacts=contacts)

    stamps = count(20_000_000, 20_000_000)
    for places in [(0.0,)] * 5 + [(-0.01, 0.012)] * 5 + [(0.001,)] * 3:
        found = [each.track_id for each in tracker(at(*places)) if not each.is_coasting]
    assert found == [0]


def test_command_writes_lasting_numbers(slides: Path, tmp_path: Path) -> None:
    table = tmp_path / "contacts.csv"
    said = result_of("reconstruct", slides, "-o", table)
    rows = list(csv.DictReader(table.open()))
    assert list(rows[0])[:4] == ["reading", "stamp_ns", "time_s", "total_force_N"]
    assert list(rows[0])[-4:] == ["track", "body_part", "link", "skin_part"]
    assert {row["track"] for row in rows} == {str(each["track"]) for each in said["tracks"]}
    assert said["readings_with_contact"] == len({row["reading"] for row in rows})
    assert said["readings"] + said["passed_over"] == 450
    hand = [row for row in rows if row["skin_part"] == "r_forearm"]
    assert {(row["body_part"], row["link"]) for row in hand} == {("right_arm", "4")}
    forces = defaultdict(float)
    for row in rows:
        forces[row["reading"]] += float(row["force_N"])
        assert float(row["time_s"]) >= 0.0
    assert all(forces[row["reading"]] == pytest.approx(float(row["total_force_N"])) for row in rows)
    assert any("forces are relative" in note for note in said["notes"])


def test_command_takes_the_spacing_of_a_layout(tmp_path: Path) -> None:
    words = run("reconstruct", written(tmp_path, TEXT), "--skin", "hexagon72")
    assert "1 track " in words
    assert "0 passed over" in words
    said = result_of("reconstruct", tmp_path, "--skin", "hexagon72")
    assert said["spacing_m"] == sf.layouts.hexagon72().pitch


def test_command_refuses_what_has_no_effect(slides: Path, tmp_path: Path) -> None:
    for words in (
        ["--solver", "contact"],
        ["--slice", "0:9"],
        ["--fields", tmp_path / "f.npz"],
        ["--no-load", 240],
    ):
        assert "would have no effect" in refused("reconstruct", slides, *words)
    assert "one by one" in refused("reconstruct", slides, slides, "-o", tmp_path / "many")
    assert ".csv" in refused("reconstruct", slides, "-o", tmp_path / "run.skinfield")
    assert "reconstruct" in refused("replay", slides)
    assert "lists of contacts" in refused("calibrate", "touch", slides, "--skin", "hexagon72",
                                          "-o", tmp_path / "cal.toml")  # fmt: skip


def written(folder: Path, text: str | bytes) -> Path:
    path = folder / "data.log"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def test_other_forms_of_a_log(tmp_path: Path) -> None:
    """Both times; one more list around; the head of old versions; no contact at all."""
    lines = TEXT.splitlines()
    known = [len(each.contacts) for each in open_contact_log(written(tmp_path, TEXT)).readings()]
    assert sum(known) == 28
    both, wrapped = [], []
    for line in lines:
        number, time, rest = line.split(" ", 2) if line.count(" ") > 1 else (*line.split(), "")
        both.append(f"{number} {time} {float(time) + 0.001:.6f} {rest}\n")
        wrapped.append(f"{number} {time} ({rest})\n")
    old = "Type: Bottle;\nSource: /skinManager/skin_events:o;\n"
    for text in ("".join(both), "".join(wrapped), old + TEXT, TEXT.replace("\n", "\r\n")):
        log = open_contact_log(written(tmp_path, text))
        found = list(log.readings())
        assert [len(each.contacts) for each in found] == known
        assert found[0].stamp_ns == round(float(lines[0].split()[1]) * 1e6) * 1000
        assert log.skipped == 0
    idle = "".join(f"{k} {k}.5 \n" for k in range(9))
    assert len(list(open_contact_log(dump(tmp_path / "idle", idle)).readings())) == 9
    with pytest.raises(FileError, match="holds no lists of contacts"):
        open_contact_log(written(tmp_path, idle))


def test_damage_is_counted_or_refused(tmp_path: Path) -> None:
    lines = TEXT.splitlines(keepends=True)
    bad = [*lines[:5], lines[5].replace("0.0 0.0 0.0", "0.0 x 0.0"), *lines[6:-1], lines[-1][:99]]
    log = open_contact_log(written(tmp_path, "".join(bad)))
    assert len(list(log.readings())) == 38
    assert log.skipped == 2
    assert any("data.log:6" in note and "'x'" in note for note in log.notes)
    with pytest.raises(FileError, match="lists of contacts"):
        open_recording(log.path)
    back = "".join(lines[20:] + lines[:20])
    with pytest.raises(FileError, match=r"data\.log:21: 20 of 40 .*clock set back"):
        list(open_contact_log(written(tmp_path, back)).readings())
    much = "".join(line.replace("(4 4 5)", "").replace(") 4", ")") for line in lines)
    half = "".join(lines[:10]) + much.replace("(", "((")
    with pytest.raises(FileError, match=r"lines are unusable|no lists"):
        list(open_contact_log(written(tmp_path, half)).readings())


@settings(max_examples=60, deadline=None)
@given(damaged(TEXT[:4000].encode()) | ANYTHING)
def test_any_bytes_are_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    path = written(tmp_path_factory.getbasetemp(), data)
    tracker = sf.Tracker.for_lists()
    with suppress(FileError):
        for reading in open_contact_log(path).readings():
            tracker(reading)
