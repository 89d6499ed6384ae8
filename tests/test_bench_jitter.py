"""`skinfield bench --jitter`, and what cyclictest prints."""

import json
import os
import shutil
import stat
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from test_readme import blocks

from skinfield.cli import jitter_run
from skinfield.cli.bench import bench
from skinfield.cli.bench_jitter import _table, _target, jitter_as_json
from skinfield.cli.jitter_run import Jitter, JitterSettings
from skinfield.cli.jitter_source import Switch, fingers
from skinfield.cli.main import main
from skinfield.errors import FileError, InputError
from skinfield.experiments.bench.machine import Company
from skinfield.layout.generators import hexagon72
from skinfield.realtime import Granted, Quantiles, TimingTable
from skinfield.realtime.cyclictest import Cyclictest, Lateness, lateness_of

ROOT = Path(__file__).resolve().parents[1]
PRINTED = """# /dev/cpu_dma_latency set to 0us
# Histogram
000000 000000
000001 000007
000002 000090
000003 000000
000004 000001
# Total: 000000098
# Min Latencies: 00001
# Avg Latencies: 00002
# Max Latencies: 02402
# Histogram Overflows: 00002
# Histogram Overflow at cycle number:
# Thread 0: 00146 00329
"""


def invoke(*words: str):
    return CliRunner().invoke(main, ["bench", *words])


def test_its_histogram_is_read() -> None:
    found = lateness_of(PRINTED.splitlines())
    assert found.counts.tolist() == [0, 7, 90, 0, 1]
    assert (found.count, found.beyond) == (100, 2)
    quantiles = found.quantiles()
    assert quantiles.p50 == pytest.approx(2.5e-6)
    assert quantiles.p99 == quantiles.p999 == quantiles.max == pytest.approx(2402e-6)


def test_shares_of_later_wakes() -> None:
    ends, share = lateness_of(PRINTED.splitlines()).later()
    assert ends == pytest.approx([2e-6, 3e-6, 4e-6, 5e-6])
    assert share == pytest.approx([0.93, 0.03, 0.03, 0.02])


@given(st.lists(st.integers(0, 50), min_size=1, max_size=400))
def test_its_quantiles_are_those_of_the_single_wakes(wakes: list[int]) -> None:
    found = Lateness(np.bincount(wakes), 0, 1e-6 * max(wakes)).quantiles()
    for value, thousandths in ((found.p50, 500), (found.p99, 990), (found.p999, 999)):
        exact = sorted(wakes)[-(-len(wakes) * thousandths // 1000) - 1]
        assert value == pytest.approx(1e-6 * min(exact + 0.5, max(wakes)))


@given(st.one_of(st.text(), st.lists(st.from_regex(r"[0-9]{1,30} [0-9]{1,30}")).map("\n".join)))
def test_what_is_no_histogram_is_refused(text: str) -> None:
    for whole in (text, f"{text}\n{PRINTED}", f"{PRINTED}\n{text}"):
        try:
            found = lateness_of(whole.splitlines())
        except FileError:
            continue
        assert found.count > 0
        assert found.quantiles().p50 >= 0


def fake(folder: Path, script: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A program of that name, first on the path."""
    program = folder / "cyclictest"
    program.write_text(f"#!{sys.executable}\n{script}")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")


@pytest.mark.skipif(sys.platform == "win32", reason="scripts that run by themselves")
def test_it_is_run_with_these_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    words = tmp_path / "words"
    fake(
        tmp_path,
        f"import sys, pathlib\npathlib.Path({str(words)!r}).write_text(' '.join(sys.argv[1:]))\n"
        f"print({PRINTED!r})\n",
        monkeypatch,
    )
    running = Cyclictest(3, 81, 500_000, 2.0, 250_000).start()
    assert running.finish().count == 100
    assert words.read_text() == ("-q -m -t 1 -a 3 -p 81 -i 500 -D 2 --secaligned=250 -h 20000")
    assert "--policy=other" in Cyclictest(None, 0).command()
    assert "-a" not in Cyclictest(None, 0).command()
    assert "-m" not in Cyclictest(None, 0, lock_memory=False).command()


@pytest.mark.skipif(sys.platform == "win32", reason="scripts that run by themselves")
def test_what_it_says_when_it_fails_is_passed_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake(tmp_path, "import sys\nsys.exit('Unable to change scheduling policy!')", monkeypatch)
    with pytest.raises(InputError, match="Unable to change scheduling policy"):
        Cyclictest(0, 80).start().finish()


def test_where_it_is_not_installed_it_says_how(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(InputError, match="apt install rt-tests"):
        Cyclictest(0, 80).start()


@pytest.mark.skipif(shutil.which("cyclictest") is None, reason="cyclictest is not installed")
def test_the_real_one_counts_its_wakes() -> None:
    found = Cyclictest(None, 0, 1_000_000, 1.0).start().finish()
    assert 1 <= found.count <= 1001
    assert found.quantiles().p50 <= found.max


def found(load: str = "engine", ready_ns: int = 80_000, fifo: bool = True) -> Jitter:
    """Made-up times: wakes of 12 µs, beside a cyclictest of 10 µs."""
    table = TimingTable(1_000_000)
    for cycle in range(1000):
        due = cycle * 1_000_000
        wake = due + 12_000
        table.add(due, wake, wake + 9_000, wake + ready_ns, wake + ready_ns + 2_000, 90_000)
    scheduler, priority = ("SCHED_FIFO", 80) if fifo else ("SCHED_OTHER", 0)
    granted = Granted(
        scheduler, priority, 1, False, "locked", True, True, 1, True, "Linux 6", (), ()
    )
    paired = Quantiles(10e-6, 10e-6, 10e-6, 11e-6, 10e-6, 1000)
    company = Company(0.1, 2.0, 0.0, 0.0, 0)
    late = np.array([12e-6]), np.array([0.0])
    settings = JitterSettings(load=load)
    return Jitter(settings, granted, table.timing(), paired, "", company, 0, 0, late, late)


def test_targets_are_judged_in_their_units() -> None:
    good, bad = found(), found(ready_ns=150_000)
    assert [target.met for target in good.targets()] == [True, True, True]
    assert [target.met for target in bad.targets()] == [True, False, True]
    assert good.ratio("p999") == pytest.approx(1.2, rel=1 / 64)
    assert _target(good.targets()[1]).startswith("ready p50 ≤ 100 µs: 80")
    assert _target(bad.targets()[1]).endswith("missed")


def test_what_was_not_measured_is_not_judged() -> None:
    assert [target.met for target in found(load="none").targets()] == [True, None, None]
    targets = found(fifo=False).targets()
    assert [target.met for target in targets] == [None, None, None]
    assert "without SCHED_FIFO" in _target(targets[1])


def test_its_json_has_plain_numbers() -> None:
    plain = json.loads(json.dumps(jitter_as_json(found()), allow_nan=False))
    assert plain["loop"]["wake_us"]["p99"] == pytest.approx(12.0, rel=1 / 64)
    assert plain["cyclictest_us"]["p999"] == 10.0
    assert plain["targets"][0]["met"] is True
    assert plain["granted"]["priority"] == 80
    assert _table(found()).row_count == 7


def test_options_of_jitter_need_it() -> None:
    result = invoke("--rate", "500")
    assert result.exit_code == 2
    assert "--rate belongs to --jitter" in result.output


@pytest.mark.parametrize(
    ("words", "named"), [(("--seconds", "0"), "seconds"), (("--busy", "-1"), "busy")]
)
def test_impossible_settings_are_said(words: tuple[str, ...], named: str) -> None:
    result = invoke("--jitter", *words)
    assert result.exit_code == 2
    assert f"{named} is" in result.output


def run_alone(words: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-c", "from skinfield.cli import main; main()", *words.split()],
        capture_output=True,
        text=True,
        timeout=180,
        check=False,
    )


def left() -> set[str]:
    """Files of engines that were measured."""
    folders = Path("/dev/shm"), Path(tempfile.gettempdir())
    return {
        file.name
        for folder in folders
        if folder.is_dir()
        for file in folder.iterdir()
        if file.name.startswith("skinfield") and ("bench-" in file.name or "switch" in file.name)
    }


def test_a_loop_that_only_wakes_is_measured_and_leaves_nothing() -> None:
    words = "bench --jitter --load none --seconds 1 --rate 200 --busy 1 --json"
    ended = run_alone(words)
    assert ended.returncode == 0, ended.stderr
    plain = json.loads(ended.stdout)
    assert plain["loop"]["cycles"] >= 1
    assert plain["loop"]["cycles"] + plain["loop"]["skipped"] <= 400
    assert plain["targets"][1]["met"] is None
    if sys.platform == "linux":
        assert plain["page_faults"] >= 0
        assert plain["interruptions"] >= 0
    assert plain["cyclictest_us"] is not None or plain["no_cyclictest"]
    assert "tracker" not in ended.stderr  # of shared memory that nobody took away


@dataclass(frozen=True)
class Gone:
    """A loop that stands still."""

    granted: Granted
    table: TimingTable
    pid: int = os.getpid()

    def snapshot(self) -> tuple[np.ndarray, np.ndarray]:
        return self.table.times.copy(), self.table.totals.copy()

    def failure(self) -> str:
        return "ValueError: a bug"


def test_a_loop_that_ended_is_no_measurement(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jitter_run, "_paired", lambda *_: (None, "none"))
    loop = Gone(found().granted, TimingTable(1_000_000))
    with pytest.raises(
        InputError, match="after 0 cycles, expected it to run on: ValueError: a bug"
    ):
        jitter_run._measured(JitterSettings(seconds=1.0), loop)


def test_fingers_move_over_the_patch_once_they_are_on() -> None:
    from skinfield.acquisition import Blocks, blocks_of

    patch, switch = hexagon72(), Switch()
    try:
        source = fingers(patch, switch)
        stream, blocks = source.open(), Blocks()
        for thrown in (False, True):
            if thrown:
                switch.throw()
            blocks.clear()
            assert stream.poll(blocks, 5, 123) == 1
            (block,) = blocks_of(blocks.data)
            assert (block.stamp_ns, block.channel, block.count) == (123, 5, len(patch))
            assert (float(np.max(block.payload)) > 0.05) == thrown
        steps = np.abs(np.diff(source.touched, axis=0)).max()
        assert steps < 0.1  # it moves, and does not jump
        stream.close()
    finally:
        switch.close()
    assert not Path(switch.path).exists()


def test_the_page_s_snippet_and_command_are_right(capsys: pytest.CaptureFixture[str]) -> None:
    found = list(blocks(ROOT / "docs" / "real-time.md"))
    code = next(text for language, _, text in found if language == "python")
    exec(compile(code, "real-time.md", "exec"), {})
    assert "garbage collector frozen" in capsys.readouterr().out
    command = next(text for language, _, text in found if language == "sh")
    bench.make_context("bench", command.split()[2:])  # raises for what is no option


@pytest.mark.slow
@pytest.mark.parametrize("load", ["skin", "engine"])
def test_an_engine_is_measured_and_leaves_nothing(load: str) -> None:
    words = f"bench --jitter --load {load} --seconds 1 --rate 100 --busy 0 --json"
    before = left()
    ended = run_alone(words)
    assert ended.returncode == 0, ended.stderr
    plain = json.loads(ended.stdout)
    assert plain["loop"]["cycles"] >= 1
    assert plain["loop"]["ready_us"]["p50"] > 0
    assert left() == before
