"""Recordings in: every format, its damage, and what is said about it."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from any_bytes import ANYTHING, damaged
from hypothesis import given, settings
from hypothesis import strategies as st

import skinfield as sf
from skinfield.errors import FileError, InputError
from skinfield.files import open_recording, readings_for, save_recording
from skinfield.skin.reading import Recording

COUNTS = np.random.default_rng(3).integers(0, 256, (40, 7)).astype(float)
STAMPS = 1_424_362_797_536_033_000 + np.arange(40) * 20_100_000  # us digits, as yarp prints them
UIDS = [17776, 17777, 17778, 17792, 17793, 17794, 2**60 + 1]  # two modules and a large one


def seconds(stamp: int) -> str:
    return f"{stamp // 10**9}.{stamp % 10**9 // 1000:06d}"


def yarp(counts: np.ndarray = COUNTS) -> str:
    return "".join(
        f"{4898 + k} {seconds(STAMPS[k])} {' '.join(f'{v:.1f}' for v in row)}\n"
        for k, row in enumerate(counts)
    )


def cyskin_text() -> str:
    rows = (f"{k} {k / 10 + 0.6:.6f} {' '.join(f'{v:.0f}' for v in row)}\n" for k, row in ROWS)
    return " ".join(map(str, UIDS)) + " \n" + "".join(rows)


def cyskin_recorder() -> str:
    rows = (f"{k} {k / 10 + 0.6:.6f} 7 {pairs(UIDS, row)}\n" for k, row in ROWS)
    return "1\n7\n" + "".join(rows)


def pairs(uids: list[int], row: np.ndarray) -> str:
    return " ".join(f"{uid} {value:.0f}" for uid, value in zip(uids, row, strict=True))


def table(delimiter: str = ",") -> str:
    names = delimiter.join(["time_s", *(f"taxel_{k}" for k in range(7))])
    rows = "".join(
        delimiter.join([seconds(STAMPS[k]), *map(repr, row.tolist())]) + "\n" for k, row in ROWS
    )
    return f"# unit = count\n# own words, with, commas\n{names}\n{rows}"


ROWS = list(enumerate(COUNTS))
TEXTS = {"yarp": yarp(), "text": cyskin_text(), "recorder": cyskin_recorder(), "csv": table()}


def opened(folder: Path, text: str | bytes, name: str = "rec", **options) -> Recording:
    path = folder / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return open_recording(path, **options)


# ---- formats


SECONDS = 600_000_000 + 100_000_000 * np.arange(40)


@pytest.mark.parametrize(
    ("text", "stamps", "uids"),
    [
        (yarp(), STAMPS, None),
        (yarp().replace("\n", "\r\n"), STAMPS, None),
        (yarp()[:-1], STAMPS, None),
        (cyskin_text(), SECONDS, UIDS),
        (cyskin_recorder(), SECONDS, UIDS),
        *((table(delimiter), STAMPS, None) for delimiter in (",", ";", "\t", " ")),
    ],
)
def test_counts_and_stamps_come_to_the_digit(tmp_path: Path, text: str, stamps, uids) -> None:
    rec = opened(tmp_path, text)
    np.testing.assert_array_equal(rec.counts, COUNTS)
    np.testing.assert_array_equal(rec.stamp_ns, stamps)
    assert (rec.uid if rec.uid is None else rec.uid.tolist()) == uids
    assert (rec.unit, rec.skipped, rec.notes) == ("count", 0, ())
    assert rec.rate == pytest.approx(1e9 * 39 / (stamps[-1] - stamps[0]))


def test_yarp_folder_names_its_port_and_a_force_log_its_unit(tmp_path: Path) -> None:
    folder = tmp_path / "icub" / "analog:o"
    folder.mkdir(parents=True)
    (folder / "info.log").write_text("Type: Bottle;\n[1.5] /icub/right_foot/analog:o [connected]\n")
    (folder / "data.log").write_text("0 1.5 1 2 3 4 5 6\n1 1.51 1 2 3 4 5 -6e-1\n")
    rec = open_recording(folder)
    assert rec.counts[1, 5] == -0.6
    assert rec.unit == "N, N m"
    assert "/icub/right_foot/analog:o" in rec.source
    with pytest.raises(FileError, match=r"without data\.log.*logs lie in .*analog:o"):
        open_recording(tmp_path)
    with pytest.raises(FileError, match=r"info\.log of a yarpdatadumper log"):
        open_recording(folder / "info.log")
    with pytest.raises(InputError, match="force log"):
        readings_for(rec, sf.Patch(np.eye(3)[:, :2] * 1e-2))
    (folder / "info.log").write_text("Type: Image:png;\n")
    with pytest.raises(FileError, match="not pictures"):
        open_recording(folder)
    for path in (tmp_path / "none", folder.parent, "a\0b", ""):
        with pytest.raises(FileError, match="expected a"):
            open_recording(path)


def test_yarp_log_may_have_brackets_two_times_and_an_old_preamble(tmp_path: Path) -> None:
    text = "Type: Bottle;\nSource: /icub/skin/a [connected]\n" + "".join(
        f"{k} {1.4e9 + k:.6f} {1.4e9 + k + 0.002:.6f} ({k} 2) (3 (4))\n" for k in range(9)
    )
    rec = opened(tmp_path, text)
    np.testing.assert_array_equal(rec.counts, [[k, 2, 3, 4] for k in range(9)])
    np.testing.assert_array_equal(rec.stamp_ns, (1_400_000_000 + np.arange(9)) * 10**9)
    assert "/icub/skin/a" in rec.source


def test_cyskin_recorder_orders_columns_by_uid(tmp_path: Path) -> None:
    lines = cyskin_recorder().splitlines(keepends=True)
    turned = list(reversed(UIDS))
    lines[5] = f"3 0.9 7 {pairs(turned, COUNTS[3][::-1])}\n"
    lines[9] = f"7 1.3 7 {pairs([*UIDS[:-1], 99], COUNTS[7])}\n"
    rec = opened(tmp_path, "".join(lines))
    np.testing.assert_array_equal(rec.counts, np.delete(COUNTS, 7, axis=0))
    assert rec.skipped == 1
    assert "rec:10 holds other uids" in rec.notes[0]


def test_csv_uids_units_missing_values_an_index_column_and_channels(tmp_path: Path) -> None:
    text = "\ufeff# unit = dC/C0\n,time_s,uid_16,0x11,18\n0,0.5,0.1,,0.3\n1,0.6,0.4,inf,nan\n"
    rec = opened(tmp_path, text)
    np.testing.assert_array_equal(rec.counts, [[0.1, np.nan, 0.3], [0.4, np.nan, np.nan]])
    assert (rec.uid.tolist(), rec.unit, rec.skipped) == ([16, 17, 18], "dC/C0", 0)
    assert any("3 of 6 values" in note and "rec:3" in note for note in rec.notes)
    rec = opened(tmp_path, "time_s,taxel_3,taxel_1\n0,30,10\n1,31,11\n")
    none = np.nan
    np.testing.assert_array_equal(rec.counts, [[none, 10, none, 30], [none, 11, none, 31]])
    assert any("taken as count" in note for note in rec.notes)


@pytest.mark.parametrize("names", ["fx,fy,fz", "Fx,Fy,Fz", "fx,fy,fz,mx,my,mz"])
def test_a_table_of_forces_needs_no_taxels(tmp_path: Path, names: str) -> None:
    width = names.count(",") + 1
    text = f"time_s,{names}\n0{',1' * width}\n0.01{',2' * width}\n"
    rec = opened(tmp_path, text)
    assert (rec.unit, rec.stamp_ns[1]) == ("N, N m", 10_000_000)
    assert rec.counts.tolist() == [[1.0] * width, [2.0] * width]
    for other in ("volts", "taxel_0"):  # forces and taxels do not mix
        with pytest.raises(FileError, match=r"'[fF]x' is not a time.*taxel_<channel>"):
            opened(tmp_path, text.replace(names[-2:], other))


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
@pytest.mark.parametrize("uid", [None, np.array(UIDS, np.uint64)])
def test_saved_recording_comes_back_exactly(tmp_path: Path, suffix: str, uid) -> None:
    counts = np.random.default_rng(0).normal(size=(9, 7)) * 10.0 ** np.arange(-3, 4)
    counts[4, 2] = np.nan
    stamps = np.sort(np.random.default_rng(1).integers(-(10**18), 10**18, 9))
    rec = Recording(stamps, counts, uid, "Pa", "left hand")
    save_recording(rec, tmp_path / f"r{suffix}")
    back = open_recording(tmp_path / f"r{suffix}")
    np.testing.assert_array_equal(back.counts, counts)
    np.testing.assert_array_equal(back.stamp_ns, stamps)
    assert back.unit == "Pa"
    assert "left hand" in back.source
    assert (back.uid is None) if uid is None else np.array_equal(back.uid, uid)


# ---- damage


@pytest.mark.parametrize("kind", TEXTS)
@pytest.mark.parametrize(
    ("damage", "why"),
    [
        (lambda line: line[: len(line) // 2] + "\n", r"numbers, not"),
        (lambda line: re.sub(r"[\d.]+\n", "x7\n", line), r"'x7' is not a number"),
        (lambda line: "\x01\xff garbage\n", r"numbers, not"),
        (lambda line: line[:-1] + line, r"numbers, not"),
    ],
)
def test_a_bad_line_is_skipped_counted_and_named(tmp_path: Path, kind: str, damage, why) -> None:
    lines = TEXTS[kind].splitlines(keepends=True)
    bad = len(lines) - 11  # reading 29
    lines[bad] = damage(lines[bad])
    rec = opened(tmp_path, "".join(lines).encode("latin-1"))
    assert rec.skipped == 1
    np.testing.assert_array_equal(rec.counts, np.delete(COUNTS, 29, axis=0))
    assert f"rec:{bad + 1} " in rec.notes[0]
    assert re.search(why, rec.notes[0])


@pytest.mark.parametrize("kind", TEXTS)
def test_truncation_at_every_byte_loses_the_last_line_at_most(tmp_path: Path, kind: str) -> None:
    data = TEXTS[kind].encode()
    start = len(data) - 2 * len(TEXTS[kind].splitlines()[-1])
    path = tmp_path / "rec"
    for end in range(start, len(data)):
        path.write_bytes(data[:end])
        rec = open_recording(path)
        full = len(rec) - (1 if "no end" in " ".join(rec.notes) else 0)
        np.testing.assert_array_equal(rec.counts[:full], COUNTS[:full])
        assert len(rec) + rec.skipped in (38, 39, 40)
        if not data[:end].endswith(b"\n") and len(rec) + rec.skipped > full:
            assert rec.notes  # never silent
    for cut in range(2, 5):  # "...240." "...240" "...24": all read as numbers
        rec = opened(tmp_path, yarp(COUNTS * 0 + 240)[:-cut])
        assert rec.skipped == 1
        assert (rec.counts == 240).all()
        assert "ends within the number" in rec.notes[0]


def test_too_many_bad_lines_are_an_error_with_line_and_expectation(tmp_path: Path) -> None:
    lines = yarp().splitlines(keepends=True)
    for k in range(0, 40, 4):
        lines[k] = "0 1.0 3.0\n"
    with pytest.raises(FileError, match=r"rec:1: holds 3 numbers, not 9.*7 values.*10 of"):
        opened(tmp_path, "".join(lines))
    lines[0], lines[4] = yarp().splitlines(keepends=True)[0:5:4]
    assert opened(tmp_path, "".join(lines)).skipped == 8  # a fifth is borne


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is empty"),
        (b"\n \n", "is empty"),
        (b"\x7fELF\0\0\1" * 40, "binary file"),
        (b"\x1f\x8b\x08rest", "gzip"),
        (b"PAR1rest", "Parquet"),
        (b"\xff\xfe1\x00 \x00", "UTF-16"),
        (b"PK\x03\x04nonsense", "cannot be read as NPZ"),
        (b"name r_foot\ntaxel2Repr ( 3 3 )\n[calibration]\n", "layout"),
        (b"[calibration]\n0.1 0.2 0.3 0 0 1\n", "layout"),
        (b"# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\n", "layout"),
        (b'{"skin": {"taxels": []}}', "layout"),
        (b"skinfield_layout = 1\n[[patch]]\n", "layout"),
        (b"72  72\n 0.02 0.01 0.0 0.0 0.0 1.0 0.02 0.01 0.003 0 1 0\n", r"layout \(skinware\)"),
        (b"force,adc\n0.1,1023\n", "rec:1: its names .* hold none of time_s, time_ms, stamp_ns"),
        (b"# x\n0.1,1023\n0.2,1022\n", "rec:2: holds numbers, but no line of names"),
        (b"Call me Ishmael.\nSome years ago\n", "rec:1: 'Call me Ishmael.' is no line of"),
        (b"1 2 3 4 5 6 7\n", "no data follow"),
        (b"1 2 3 4 5 6 7\n0 0.6 1 2", "rec:2: the file ends after 4 of 9 numbers"),
        (b"16 17 18\n" + b"0 0.1 1 2 3 4\n" * 9, "3 whole numbers stand above lines of 6"),
        (b"1\n8\n0 0.1 2 16 5 17 6\n", "rec:2: 8 taxels are announced"),
        (b"99999999999999999999 2\n0 0.1 5 6\n", "rec:1: uid '99999999999999999999'"),
        (b"time_s,taxel_0,taxel_0\n0,1,2\n", "rec:1: column 'taxel_0' stands there twice"),
        (b"time_s,taxel_999999999\n0,1\n", "channels up to 999999999"),
        (b"# unit = mmHg\ntime_s,taxel_0\n0,1\n", "rec:1: unit 'mmHg' is not known"),
        (b"time_s,taxel_0\n", "rec:1: no data follow"),
        (b"time_s\n0\n", "no column of values"),
        (b"time_s,taxel_0\n0,nan\n1,\n", "all 2 values are nan"),
        (b"time_s,taxel_0\n1424362797536,5\n", "beyond 292 years: is it in seconds"),
        (b"time_s,taxel_0\nnan,5\n", "the time 'nan' is not a finite number"),
    ],
)
def test_what_is_no_recording_is_named(tmp_path: Path, data: bytes, message: str) -> None:
    with pytest.raises(FileError, match=rf"(?s)rec.*{message.removeprefix('rec')}"):
        opened(tmp_path, data)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"counts": COUNTS}, "lacks keys"),
        ({"positions": COUNTS}, "looks like a layout"),
        ({"pressure": COUNTS, "positions": COUNTS}, "looks like fields"),
        ({"counts": COUNTS[0], "stamp_ns": STAMPS}, "counts has shape"),
        ({"counts": COUNTS, "stamp_ns": STAMPS[:5]}, "for 40 rows"),
        ({"counts": COUNTS, "stamp_ns": STAMPS * 1.0}, "expected int64"),
        ({"counts": COUNTS, "time_s": np.full(40, np.nan)}, "expected seconds"),
        ({"counts": COUNTS.astype(str), "stamp_ns": STAMPS}, "expected numbers"),
        ({"counts": COUNTS, "stamp_ns": STAMPS, "uid": np.arange(3)}, r"expected \(7,\)"),
        ({"counts": COUNTS, "stamp_ns": STAMPS, "uid": -np.arange(7)}, "from 0"),
        ({"counts": COUNTS, "stamp_ns": STAMPS, "unit": "psi"}, "unit 'psi'"),
        ({"counts": np.array([object()]), "stamp_ns": STAMPS}, "cannot be read as NPZ"),
    ],
)
def test_npz_of_another_kind_is_refused(tmp_path: Path, keys, message) -> None:
    np.savez(tmp_path / "rec.npz", **keys)
    with pytest.raises(FileError, match=message):
        open_recording(tmp_path / "rec.npz")


# ---- fuzz: only FileError or InputError may come out, and what comes in is sound


def survives(path: Path, data: bytes) -> None:
    path.write_bytes(data)
    try:
        rec = open_recording(path)
    except InputError:
        return
    assert len(rec) > 0
    assert not np.isinf(rec.counts).any()


ALMOST = st.text("0123456789 .-e,\n()#xnatime_s", max_size=200).map(str.encode)


@pytest.mark.parametrize("kind", [*TEXTS, "npz"])
@settings(max_examples=80)
@given(data=st.data())
def test_damaged_files_and_any_bytes(
    tmp_path_factory: pytest.TempPathFactory, kind: str, data: st.DataObject
) -> None:
    seed = tmp_path_factory.getbasetemp() / "seed.npz"
    if kind == "npz":
        save_recording(Recording(STAMPS, COUNTS, np.array(UIDS, np.uint64)), seed)
    whole = seed.read_bytes() if kind == "npz" else TEXTS[kind].encode()
    survives(seed.with_name("f"), data.draw(damaged(whole) | ANYTHING | ALMOST))


# ---- onto a patch


def patch_of(uids: list[int]) -> sf.Patch:
    return sf.Patch(1e-3 * np.random.default_rng(0).normal(size=(len(uids), 2)), uid=uids)


def test_columns_are_matched_by_uid(tmp_path: Path) -> None:
    rec = opened(tmp_path, cyskin_text())
    wanted = [UIDS[5], 4242, UIDS[1], UIDS[6]]
    got = readings_for(rec, patch_of(wanted))
    np.testing.assert_array_equal(got.counts[:, [0, 2, 3]], COUNTS[:, [5, 1, 6]])
    assert np.isnan(got.counts[:, 1]).all()
    assert got.uid.tolist() == wanted
    notes = " ".join(got.notes)
    assert "1 taxels of 'patch' have no column: 4242" in notes
    assert "2 columns of sensor 0 (CySkin: temperature) left out: 17776, 17792" in notes
    assert "2 columns of uids that the layout lacks left out: 17778, 17793" in notes
    with pytest.raises(InputError, match="expected common ones"):
        readings_for(rec, patch_of([1, 2, 3]))


def test_columns_are_matched_by_channel(tmp_path: Path) -> None:
    rec = opened(tmp_path, yarp())
    xy = 1e-3 * np.random.default_rng(0).normal(size=(3, 2))
    patch = sf.Patch(xy, channel=[6, 0, 2], n_channels=7)
    np.testing.assert_array_equal(readings_for(rec, patch).counts, COUNTS[:, [6, 0, 2]])
    with pytest.raises(InputError, match=r"has 7 columns, expected 384, the channels of 'r_foot'"):
        readings_for(rec, sf.Patch(xy, channel=[6, 0, 2], n_channels=384, name="r_foot"))
    wide = replace(rec, counts=np.zeros((40, 384)))
    with pytest.raises(InputError, match="384 columns fit an iCub forearm or foot"):
        readings_for(wide, patch)


# ---- others' recordings


def test_foot_logs_are_read_whole(shared_data: Path) -> None:
    base = shared_data / "icub-foot-tipping/robotData/backwardTipping"
    skin = open_recording(base / "dumperTippingSetup01/icub/skin/right_foot")
    assert skin.counts.shape == (894, 384)
    assert (skin.skipped, skin.notes) == (0, ())
    assert skin.stamp_ns[0] == 1_424_362_797_536_033_000
    assert skin.rate == pytest.approx(50.0, rel=0.01)
    assert (skin.counts.min(), skin.counts.max()) >= (0, 255)
    again = open_recording(base / "dumperTippingSetup07/icub/skin/right_foot/data.log")
    assert again.counts.shape == (441, 384)
    force = open_recording(base / "dumperTippingSetup07/icub/right_foot/analog:o")
    assert force.counts.shape == (881, 6)
    assert force.counts[0, 2] == -125.306763
    assert force.unit == "N, N m"
    assert abs(force.stamp_ns[0] - again.stamp_ns[0]) < 1e9  # recorded together
