"""Runs of many tasks: each once, whole or not at all; pieces in order, in processes."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from skinfield.errors import FileError
from skinfield.lab.runner import Task, run, stored


def square(folder: Path, number: float) -> dict[str, float]:
    (folder / "square.txt").write_text(str(number**2))
    with (folder.parent / "calls.txt").open("a") as calls:
        calls.write(f"{number:g}\n")
    return {"square": number**2}


def stumble(folder: Path, number: float) -> None:
    (folder / "half.txt").write_text("half of it")
    if number < 0:
        raise ValueError(f"no root of {number:g}")


def vanish(folder: Path) -> None:
    os._exit(3)


def threads(folder: Path) -> list[str | None]:
    return [os.environ.get("OMP_NUM_THREADS"), os.environ.get("NUMBA_NUM_THREADS")]


def not_json(folder: Path) -> object:
    return object()


def sleep_long(folder: Path, mark: Path) -> None:
    mark.write_text("begun")
    (folder / "half.txt").write_text("half of it")
    time.sleep(60)


def squares(numbers: list[float], version: str = "") -> list[Task]:
    return [Task(f"n{number:g}", square, (number,), version) for number in numbers]


def calls(folder: Path) -> list[str]:
    return (folder / "calls.txt").read_text().split()


@pytest.mark.parametrize("workers", [1, 2])
def test_every_task_leaves_its_folder_and_summary(tmp_path: Path, workers: int) -> None:
    outcomes = list(run(squares([1, 2, 3]), tmp_path, workers=workers))
    assert {o.name: o.result["square"] for o in outcomes} == {"n1": 1.0, "n2": 4.0, "n3": 9.0}
    assert (tmp_path / "n3" / "square.txt").read_text() == "9"
    assert json.loads((tmp_path / "n2" / "task.json").read_text())["result"] == {"square": 4.0}
    assert not list(tmp_path.glob(".*"))


def test_what_is_there_is_not_run_again(tmp_path: Path) -> None:
    list(run(squares([1, 2]), tmp_path))
    outcomes = list(run(squares([1, 2, 3]), tmp_path))
    assert [outcome.reused for outcome in outcomes] == [True, True, False]
    assert outcomes[0].result == {"square": 1}
    assert calls(tmp_path) == ["1", "2", "3"]
    list(run(squares([1], version="2"), tmp_path))
    list(run([Task("n1", square, (5.0,), "2")], tmp_path))  # other arguments, same name
    assert calls(tmp_path)[3:] == ["1", "5"]
    assert (tmp_path / "n1" / "square.txt").read_text() == "25.0"


@pytest.mark.parametrize("content", ["", "{", "[1]", '{"fingerprint": 1}', "\x00", "[" * 9999])
def test_a_broken_record_means_run_it_again(tmp_path: Path, content: str) -> None:
    (task,) = squares([2])
    list(run([task], tmp_path))
    (tmp_path / "n2" / "task.json").write_text(content)
    assert [outcome.reused for _ in range(2) for outcome in run([task], tmp_path)] == [False, True]


@pytest.mark.parametrize("workers", [1, 2])
def test_a_failure_stops_no_other_and_leaves_its_traceback(tmp_path: Path, workers: int) -> None:
    tasks = [Task("bad", stumble, (-1.0,)), Task("good", stumble, (1.0,)), *squares([3])]
    (failed,) = (one for one in run(tasks, tmp_path, workers=workers) if one.failure)
    assert failed.name == "bad"
    assert "ValueError: no root of -1" in failed.failure
    assert (tmp_path / "bad.failed.txt").read_text() == failed.failure
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"bad.failed.txt", "calls.txt", "good", "n3"}
    list(run([Task("bad", stumble, (1.0,))], tmp_path))
    assert not (tmp_path / "bad.failed.txt").exists()


def test_a_process_that_dies_is_named_and_the_others_finish(tmp_path: Path) -> None:
    tasks = [Task("killer", vanish), *squares([1, 2])]
    outcomes = list(run(tasks, tmp_path, workers=2))
    assert sorted(o.name for o in outcomes) == ["killer", "n1", "n2"]
    assert [o.name for o in outcomes if o.failure] == ["killer"]
    assert "memory" in (tmp_path / "killer.failed.txt").read_text()


def test_workers_have_one_thread_and_the_caller_keeps_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    tasks = [Task(name, threads) for name in "ab"]
    assert [one.result for one in run(tasks, tmp_path, workers=2)] == [["1", "1"]] * 2
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "NUMBA_NUM_THREADS" not in os.environ


def test_whoever_stops_asking_can_go_on_later(tmp_path: Path) -> None:
    outcomes = run(squares([1, 2, 3]), tmp_path)
    next(outcomes)
    outcomes.close()  # type: ignore[attr-defined]
    assert calls(tmp_path) == ["1"]
    again = run(squares([1, 2, 3]), tmp_path)
    assert [outcome.reused for outcome in again] == [True, False, False]


INTERRUPTED = """
import sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from test_runner import Task, run, sleep_long, squares
if __name__ == "__main__":
    out = Path(sys.argv[1])
    long = [Task(f"long{{n}}", sleep_long, (out / f"mark{{n}}",)) for n in (1, 2)]
    list(run([*squares([1]), *long], out, workers=2))
"""


def test_ctrl_c_leaves_a_folder_to_go_on_with(tmp_path: Path) -> None:
    script, out = tmp_path / "script.py", tmp_path / "out"
    script.write_text(INTERRUPTED.format(tests=str(Path(__file__).parent)))
    child = subprocess.Popen(
        [sys.executable, str(script), str(out)], start_new_session=True, stderr=subprocess.PIPE
    )
    try:
        deadline = time.monotonic() + 300
        while len(list(out.glob("mark*"))) < 2 and child.poll() is None:
            assert time.monotonic() < deadline, "tasks never began"
            time.sleep(0.02)
        os.killpg(child.pid, signal.SIGINT)  # as a terminal does
        child.communicate(timeout=300)
    finally:
        child.kill()
        child.wait()
    assert child.returncode != 0
    assert stored(squares([1])[0], out) is not None
    assert sorted(path.name for path in out.iterdir() if path.is_dir()) == ["n1"]


def test_a_result_that_json_cannot_hold_is_a_failure(tmp_path: Path) -> None:
    (outcome,) = run([Task("odd", not_json)], tmp_path)
    assert "expected None or what JSON can hold" in outcome.failure
    assert not (tmp_path / "odd").exists()


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="cannot be made"):
        next(run(squares([1]), tmp_path / "file"))


@dataclass(frozen=True)
class Settings:
    size: float
    parts: tuple[int, ...]


VALUES = (1.5, "a", np.arange(3), Settings(1.0, (1, 2)), square)


def fingerprint(value: object) -> str:
    return Task("task", square, (value,)).fingerprint


def test_fingerprints_tell_values_apart() -> None:
    values = [
        None, False, 0, 0.0, -0.0, "0", b"0", (), (0,), ((0,),), (0, 0), float("nan"), 0j,
        np.zeros(2), np.zeros((2, 1)), np.zeros(2, np.float32), Path("0"), Settings(1.0, (1,)),
        Settings(1.0, (1, 2)), square, Settings, ("ab", "c"), ("a", "bc"),
    ]  # fmt: skip
    assert len({fingerprint(value) for value in values}) == len(values)


def test_fingerprints_are_those_of_another_process() -> None:
    code = "from test_runner import VALUES, fingerprint\nprint(fingerprint(VALUES))"
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True,
        cwd=Path(__file__).parent, env={**os.environ, "PYTHONHASHSEED": "7"},
    ).stdout.strip()  # fmt: skip
    assert found == fingerprint(VALUES)
    assert len(found) == 32
