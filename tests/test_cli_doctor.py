"""`skinfield doctor`: what it finds, and when it says that nothing can work."""

import importlib
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace

import pytest
from command_line import invoke, result_of

from skinfield.cli import doctor as command
from skinfield.cli.doctor import Row
from skinfield.ring import files as ring_files


def findings_of(*checks: str) -> dict[str, Row]:
    return {each.what: each for check in checks for each in getattr(command, check)()}


def test_this_machine_can_run_and_each_row_has_its_state() -> None:
    found = result_of("doctor")
    assert found["works"]
    rows = {each["what"]: each for each in found["findings"]}
    assert {each["state"] for each in rows.values()} <= {"OK", "note"}
    for name in ("numpy", "scipy", "numba"):
        assert rows[name]["value"] == metadata.version(name)
    assert {"compiled code", "real time", "shared memory", "page", "CAN", "ROS 2"} <= rows.keys()


def test_a_missing_thing_ends_with_status_1_and_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def lacking() -> Iterator[Row]:
        yield Row("shared memory", "missing", "[none]", "make /dev/shm")

    for checks, code, verdict in (
        ((lacking,), 1, "something is missing"), ((command.python,), 0, "can work here"),
    ):  # fmt: skip
        monkeypatch.setattr(command, "CHECKS", checks)
        ended = invoke(["doctor"])
        assert (ended.exit_code, verdict in ended.stdout) == (code, True)
    monkeypatch.setattr(command, "CHECKS", (lacking,))
    text = invoke(["doctor"]).stdout
    assert "[none]" in text
    assert "make /dev/shm" in text


def test_packages_are_told_with_what_installs_them(monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = ["numpy>=1.26", "nosuch-package>=3", "nosuch-serial>=1; extra == 'serial'",
              "msgspec; extra == 'fast'", "nosuch-linter; extra == 'lint'"]  # fmt: skip
    monkeypatch.setattr(metadata, "requires", lambda _: wanted)
    found = findings_of("packages")
    assert found["numpy"].state == "OK"
    lacking = found["nosuch-package"]
    assert (lacking.state, lacking.remedy) == (
        "missing", 'python -m pip install "nosuch-package>=3"',
    )  # fmt: skip
    extra = found["extra serial"]
    assert (extra.state, extra.remedy) == ("note", 'python -m pip install "skinfield[serial]"')
    assert found["extra fast"].state == "OK"
    assert "extra lint" not in found


def test_a_package_that_does_not_load_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(name: str) -> None:
        raise ImportError("Numba needs NumPy 2.4 or less")

    monkeypatch.setattr(importlib, "import_module", broken)
    row = command._package("numba", ">=0.59", "0.60")
    assert row.state == "missing"
    assert "Numba needs NumPy" in row.value


def test_too_little_shared_memory_is_missing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for free, state in ((1e6, "missing"), (1e9, "OK")):
        monkeypatch.setattr(
            command.shutil, "disk_usage", lambda _, free=free: SimpleNamespace(free=free)
        )
        assert findings_of("shared_memory")["shared memory"].state == state
    monkeypatch.setattr(ring_files, "folder_of", lambda _: tmp_path / "none")
    assert findings_of("shared_memory")["shared memory"].state == "missing"


def test_code_that_is_to_be_compiled_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    for left, state, remedy in ((40.0, "note", "skinfield warmup"), (0.0, "OK", "")):
        progress = SimpleNamespace(seconds_left=left)
        monkeypatch.setattr("skinfield.compile_progress.CompileProgress", lambda _, p=progress: p)
        row = findings_of("compiled_code")["compiled code"]
        assert (row.state, row.remedy) == (state, remedy)
