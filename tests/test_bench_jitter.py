"""`skinfield bench --jitter`, and what cyclictest prints."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

import pytest
from command_line import refused
from hypothesis import given
from hypothesis import strategies as st
from test_readme import blocks, doc

from skinfield.cli.bench_tables import jitter_table
from skinfield.cli.main import app_for
from skinfield.errors import FileError, InputError
from skinfield.lab.bench import jitter
from skinfield.lab.bench.jitter import Cyclictest, JitterSettings, quantiles_from_json, result
from skinfield.loop.realtime import Quantiles, RealTimeStatus, Timing, TimingTable


def printed(histogram: dict, cycles: int, longest: int = 4) -> str:
    thread = {"histogram": histogram, "cycles": cycles, "min": 1, "max": longest, "avg": 2.5}
    return json.dumps({"file_version": 1, "thread": {"0": thread}})


PRINTED = printed({"1": 7, "2": 90, "4": 1}, 100, 2402)  # two beyond the histogram


def test_its_histogram_is_read() -> None:
    found = quantiles_from_json(PRINTED)
    assert (found.count, found.mean, found.p50) == (100, *[pytest.approx(2.5e-6)] * 2)
    assert found.p99 == found.p999 == found.max == pytest.approx(2402e-6)


@given(st.lists(st.integers(0, 50), min_size=1, max_size=400))
def test_its_quantiles_are_those_of_the_single_wakes(wakes: list[int]) -> None:
    histogram = {str(late): wakes.count(late) for late in set(wakes)}
    quantiles = quantiles_from_json(printed(histogram, len(wakes), max(wakes)))
    for value, thousandths in ((quantiles.p50, 500), (quantiles.p99, 990), (quantiles.p999, 999)):
        exact = sorted(wakes)[-(-len(wakes) * thousandths // 1000) - 1]
        assert value == pytest.approx(1e-6 * min(exact + 0.5, max(wakes)))


@given(
    st.one_of(
        st.text(),
        st.recursive(
            st.none() | st.integers() | st.text(max_size=3),
            lambda inner: (
                st.lists(inner) | st.dictionaries(st.sampled_from(["thread", "0"]), inner)
            ),
        ).map(json.dumps),
        st.dictionaries(st.text(max_size=2), st.integers()).map(lambda bins: printed(bins, 3)),
    )
)
def test_what_is_no_histogram_is_refused(text: str) -> None:
    try:
        assert quantiles_from_json(text).count == 3
    except FileError:
        return


def fake(folder: Path, script: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A program of that name, first on the path."""
    program = folder / "cyclictest"
    program.write_text(f"#!{sys.executable}\n{script}")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")


@pytest.mark.skipif(sys.platform == "win32", reason="scripts that run by themselves")
def test_it_is_run_with_these_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    words = tmp_path / "words"
    fake(
        tmp_path,
        "import sys, pathlib\n"
        "file, = (word for word in sys.argv if word.startswith('--json='))\n"
        f"pathlib.Path(file.removeprefix('--json=')).write_text({PRINTED!r})\n"
        "rest = [word for word in sys.argv[1:] if word != file]\n"
        f"pathlib.Path({str(words)!r}).write_text(' '.join(rest))\n",
        monkeypatch,
    )
    running = Cyclictest(3, 81, period_ns=500_000, seconds=2.0, offset_ns=250_000)
    assert running.finish().count == 100
    assert words.read_text() == "-q -t 1 -h 20000 -i 500 -D 2 -p 81 -a 3 -m --secaligned=250"
    assert not running.file.exists()
    Cyclictest(None, 0, lock_memory=False).finish()
    assert words.read_text() == "-q -t 1 -h 20000 -i 1000 -D 20 --policy=other --secaligned=0"


@pytest.mark.skipif(sys.platform == "win32", reason="scripts that run by themselves")
def test_its_own_words_are_passed_on_when_it_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake(tmp_path, "import sys\nsys.exit('Unable to change scheduling policy!')", monkeypatch)
    with pytest.raises(InputError, match="Unable to change scheduling policy"):
        Cyclictest(0, 80).finish()


def test_where_it_is_not_installed_the_error_names_the_package(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(InputError, match="apt install rt-tests"):
        Cyclictest(0, 80)


@pytest.mark.skipif(shutil.which("cyclictest") is None, reason="cyclictest is not installed")
def test_the_real_one_counts_its_wakes() -> None:
    running = Cyclictest(None, 0, period_ns=1_000_000, seconds=1.0, lock_memory=False)
    quantiles = running.finish()
    assert 1 <= quantiles.count <= 1001
    assert quantiles.p50 <= quantiles.max


GRANTED = RealTimeStatus("SCHED_FIFO", 80, 1, False, "locked", True, "Linux 6")


def measured() -> dict:
    """Made-up times: wakes of 12 µs, beside a cyclictest of 10 µs."""
    table = TimingTable(1_000_000)
    for cycle in range(1000):
        due = cycle * 1_000_000
        wake = due + 12_000
        table.add(due, wake, wake + 9_000, wake + 80_000, wake + 82_000, 90_000)
    paired = Quantiles(10e-6, 10e-6, 10e-6, 11e-6, 10e-6, 1000)
    timing = Timing.of(table.times, table.totals)
    about = dict.fromkeys(("no_cyclictest", "page_faults", "interruptions", "stolen_cores"))
    return result(JitterSettings(), GRANTED, timing, paired, about)


def test_its_table_and_its_json_have_the_times_beside_cyclictest() -> None:
    plain = json.loads(json.dumps(measured(), allow_nan=False))
    assert plain["loop"]["wake_us"]["p99"] == pytest.approx(12.0, rel=1 / 64)
    assert plain["loop"]["ready_us"]["p50"] == pytest.approx(80.0, rel=1 / 64)
    assert plain["cyclictest_us"]["p999"] == 10.0
    assert plain["ratio"]["p999"] == pytest.approx(1.2, rel=1 / 64)
    assert plain["granted"]["priority"] == 80
    assert jitter_table(measured()).row_count == 7


def test_options_of_jitter_need_it() -> None:
    assert "--rate-hz belongs to --jitter" in refused("bench", "--rate-hz", 500)


def test_impossible_settings_are_refused() -> None:
    for words, error in (
        (("--duration", 0), "duration is"),
        (("--busy", -1), "busy is"),
        (("-o", "a.png"), "-o draws what --jitter does not measure"),
    ):
        assert error in refused("bench", "--jitter", *words)


def left() -> set[str]:
    """Files of engines that were measured."""
    folders = Path("/dev/shm"), Path(tempfile.gettempdir())
    return {file.name for folder in folders for file in folder.glob("skinfield*bench-*")}


def test_a_loop_that_ended_is_no_measurement(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jitter, "_paired", lambda *_: (None, "none"))
    table = TimingTable(1_000_000)
    status = {"times": table.times, "totals": table.totals}
    reader = SimpleNamespace(pid=os.getpid(), status=status)
    supervisor = SimpleNamespace(failure="ValueError: a bug")
    with pytest.raises(InputError, match="after 0 cycles, expected it to run on: ValueError: a b"):
        jitter.measure(JitterSettings(duration=1.0), GRANTED, reader, supervisor)


def test_the_page_s_snippet_and_command_are_right() -> None:
    page = list(blocks(doc("real-time")))
    code = next(text for language, _, text in page if language == "python")
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "garbage collector frozen" in ended.stdout
    command = next(text for language, _, text in page if language == "sh")
    app_for(["bench"]).parse_args(command.split()[1:], exit_on_error=False)  # raises


@pytest.mark.slow
def test_an_engine_is_measured_and_leaves_nothing() -> None:
    words = "bench --jitter --duration 1 --rate-hz 100 --busy 1 --solver gaussian --json"
    before = left()
    ended = subprocess.run(
        [sys.executable, "-c", "from skinfield.cli import main; main()", *words.split()],
        capture_output=True, text=True, timeout=900, check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    plain = json.loads(ended.stdout)
    assert plain["loop"]["cycles"] >= 1
    assert plain["loop"]["ready_us"]["p50"] > 0
    if sys.platform == "linux":
        assert min(plain["page_faults"], plain["interruptions"]) >= 0
    assert plain["cyclictest_us"] is not None or plain["no_cyclictest"]
    assert "tracker" not in ended.stderr  # of shared memory that nobody took away
    assert left() == before
