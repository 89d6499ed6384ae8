"""Fuzz targets run, on their seeds and on some random inputs; the runner says what it needs."""

import importlib.util
import random
import subprocess
import sys
from pathlib import Path

import pytest

FUZZ = Path(__file__).resolve().parents[1] / "fuzz"
TARGETS = sorted(file.stem for file in FUZZ.glob("fuzz_*.py"))
PLANTED = """
def one_input(data: bytes) -> None:
    if data[:2] == b"SF":
        raise KeyError("planted")
SEEDS = [b"SE"]
"""


@pytest.mark.parametrize("name", TARGETS)
def test_target_takes_any_bytes(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(FUZZ)
    target = importlib.import_module(name)
    numbers = random.Random(name)
    inputs = [b"", *getattr(target, "SEEDS", [])]
    for _ in range(8):
        data = bytearray(numbers.choice(inputs) or numbers.randbytes(60))
        data[numbers.randrange(len(data))] ^= 1 << numbers.randrange(8)
        inputs.append(bytes(data))
    for data in inputs:
        target.one_input(data)


def run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(folder / "run.py"), *words]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)


def test_runner_lists_targets_and_says_what_it_needs() -> None:
    assert run(FUZZ).stdout.split() == TARGETS
    needs = {"fuzz_nothing": "expected one of fuzz_"}
    if importlib.util.find_spec("atheris") is None:
        needs[TARGETS[0]] = "pip install atheris"
    for name, said in needs.items():
        done = run(FUZZ, name)
        assert done.returncode == 2
        assert said in done.stdout


def test_runner_finds_what_is_planted(tmp_path: Path) -> None:
    (tmp_path / "run.py").write_text((FUZZ / "run.py").read_text())
    (tmp_path / "fuzz_bad.py").write_text(PLANTED)
    (tmp_path / "fuzz_good.py").write_text("def one_input(data: bytes) -> None: ...\n")
    options = ["--plain", "--seconds", "60", "--corpus", str(tmp_path / "corpus")]
    done = run(tmp_path, "fuzz_bad", *options, "--seed", "3")
    assert done.returncode == 1
    assert "KeyError: 'planted'" in done.stdout
    found = done.stdout.split("--again ")[1].strip()
    again = run(tmp_path, "fuzz_bad", *options, "--again", found)
    assert again.returncode == 1
    assert "planted" in again.stderr
    options[2] = "0"
    done = run(tmp_path, "fuzz_good", *options)
    assert done.returncode == 0
    assert "executions in" in done.stdout
