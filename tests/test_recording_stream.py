"""Recordings in blocks: the same readings, notes and faults as in one piece."""

from pathlib import Path

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import FileError
from skinfield.files import open_recording, save_recording, stream_recording
from skinfield.files.recordings import RecordingStream
from skinfield.files.recordings import lines as lines_module
from skinfield.reconstruct.diagnostics import Conditioning, survey
from skinfield.signal import ICubByte, Verdict, find_faults
from skinfield.signal.faults import merged_faults
from skinfield.skin.reading import Recording

PATCH = sf.layouts.hexagon72()


@pytest.fixture(params=[50, 700, 1 << 20])
def block(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    """Bytes that are read at once."""
    monkeypatch.setattr(lines_module, "BLOCK", request.param)
    return request.param


def yarp_line(k: int) -> str:
    """Of a log with lost messages, a repeated stamp, one that runs back, and missing values."""
    stamp = 100.0 + 0.02 * (k - (k == 11) - 5 * (k == 40))
    third = "nan" if k in (5, 30) else 239
    return f"{k + (k > 20) + 3 * (k > 33)} {stamp:.6f} {240 - k % 7} 240 {third} {200 + k % 3}\n"


TEXTS = {  # what is written, the rate, and what is noted
    "yarp": ("".join(map(yarp_line, range(60))), 50.0, [
        "4 messages lost in 2 gaps of the sequence numbers, first before data.log:22",
        "2 of 240 values are nan, inf or empty, first at data.log:6: taken as missing",
        "1 stamps repeat the one before, first at data.log:12: kept",
        "1 stamps run backwards, first at data.log:41: kept",
    ]),
    "sparse": ("".join(f"{5 * k} {100 + 0.1 * k:.3f} 1 2 3 {k}\n" for k in range(30)), 10.0, [
        "sequence numbers step by 5: the log holds every so many-th",
    ]),
    "cyskin": (
        "17 18 33\n"
        + "".join(f"{k} {20 * k} {k} {k + 1} {7 * k % 50}\n" for k in range(50)), 50.0, [
        "times are whole numbers far apart: taken as milliseconds",
    ]),
    "table": (
        "# unit = count\ntime_s,taxel_3,taxel_0\n"
        + "".join(f"{0.02 * k:.2f},{k},{'inf' if k == 9 else 2 * k}\n" for k in range(40)), 50.0, [
        "1 of 80 values are nan, inf or empty, first at data.log:12: taken as missing",
        "2 of 4 channels have no column: missing",
    ]),
    "bad": (
        "# unit = Pa\ntime_s,taxel_0,taxel_1\n"
        + "".join(f"{0.02 * k:.2f},{k},{'x' if k in (3, 30) else 2 * k}\n" for k in range(40))
        + "0.80,3", 50.0, [
        "3 of 41 lines skipped: data.log:6 'x' is not a number; data.log:33 'x' is not a "
        "number; data.log:43 the file ends after 2 of 3 numbers",
    ]),
}  # fmt: skip


@pytest.mark.parametrize("name", TEXTS)
def test_blocks_are_the_recording(name: str, block: int, tmp_path: Path) -> None:
    path = tmp_path / "data.log"
    text, rate, notes = TEXTS[name]
    path.write_text(text)
    stream = stream_recording(path)
    assert isinstance(stream, RecordingStream)
    blocks = list(stream.blocks())
    assert len(blocks) > 5 or block > 60
    calls: list[tuple[int, int]] = []
    whole = open_recording(path, progress=lambda *done: calls.append(done))
    assert calls[-1] == (path.stat().st_size,) * 2
    assert calls == sorted(calls)
    for part in ("counts", "stamp_ns"):
        joined = np.concatenate([getattr(each, part) for each in blocks])
        np.testing.assert_array_equal(getattr(whole, part), joined)
    assert (whole.notes, whole.skipped) == (stream.notes, stream.skipped)
    assert list(whole.notes) == notes
    assert whole.rate == pytest.approx(rate, rel=0.05)


def test_npz_is_read_as_a_whole_and_errors_come_at_the_end(tmp_path: Path) -> None:
    save_recording(Recording(np.arange(9), np.ones((9, 3))), tmp_path / "a.npz")
    assert isinstance(stream_recording(tmp_path / "a.npz"), Recording)
    path = tmp_path / "gone.csv"
    path.write_text("time_s,taxel_0\n" + "".join(f"{0.02 * k:.2f},nan\n" for k in range(40)))
    with pytest.raises(FileError, match=r"gone.csv:2: all 40 values are nan"):
        list(stream_recording(path).blocks())


def noisy(readings: int, seed: int = 0) -> np.ndarray:
    return 240 + np.random.default_rng(seed).normal(scale=1.5, size=(readings, 72)).round()


def test_faults_of_stretches_are_those_of_the_whole() -> None:
    counts = noisy(8000)
    counts[:, 3] = np.nan  # absent
    counts[:, 7] = 238.0  # dead
    counts[5500:, 11] = 239.0  # stuck in the third stretch
    counts[4000:, 13] = 241.0  # stuck where a stretch begins
    counts[:, 17] += np.random.default_rng(1).normal(scale=30, size=8000).round()  # noisy
    counts[2000:4000, 19] = 240.0  # still for one stretch, then alive
    counts[:, 23] = np.where(np.arange(8000) % 10 < 8, 255, 250)  # mostly at a clamp
    whole = find_faults(counts, convention=ICubByte())
    parts = np.split(counts, 4)
    found = merged_faults([find_faults(part, convention=ICubByte()) for part in parts], [2000] * 4)
    np.testing.assert_array_equal(found.verdict, whole.verdict)
    kinds = ("ABSENT", "DEAD", "STUCK", "STUCK", "NOISY", "OK", "SATURATED")
    taxels = found.verdict[[3, 7, 11, 13, 17, 19, 23]]
    assert taxels.tolist() == [Verdict[kind] for kind in kinds]
    np.testing.assert_array_equal(found.since, whole.since)
    assert found.decided
    assert any("1 of 72 taxels never answer: 3" in said for said in found.sentences)


def survey_of(counts: np.ndarray, size: int):
    stamps = np.arange(len(counts)) * 20_000_000

    def blocks():
        for first in range(0, len(counts), size):
            part = slice(first, first + size)
            yield Recording(stamps[part], counts[part], source="test.log")

    return survey(blocks, PATCH, sf.Layer(), sf.Capacitance(), Conditioning(gain=-171.0))


def test_the_baseline_is_the_quietest_unloaded_stretch_of_all() -> None:
    counts = noisy(9000)
    counts[:6000] -= 25  # something lies on the skin for two thirds
    counts[:3000] -= 10 * np.sin(np.arange(3000) / 7)[:, None].round()  # and moves at first
    whole, blocks = survey_of(counts, 9000), survey_of(counts, 3000)
    level = blocks.conditioner.calibration.baseline
    np.testing.assert_allclose(level, 240, atol=0.6)
    np.testing.assert_allclose(level, whole.conditioner.calibration.baseline, atol=0.6)
    np.testing.assert_allclose(blocks.noise_std, 1.5 / 171, rtol=0.25)
    assert blocks.rate == pytest.approx(50.0)
    counts = noisy(6010)  # a rest of ten readings tells nothing
    counts[2000:4000] = np.nan  # and a block without any number is passed over
    found = survey_of(counts, 2000)
    np.testing.assert_allclose(found.noise_std, 1.5 / 171, rtol=0.25)
    assert found.conditioner.calibration.alive.all()
    assert np.isnan(found.conditioner(counts[2000:2003])).all()
