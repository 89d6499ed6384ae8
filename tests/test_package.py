"""The package as it is handed out, and the script that sets a fresh clone up."""

import ast
import importlib.metadata
import importlib.util
import inspect
import re
import subprocess
import sys
import types
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skinfield as sf
from skinfield.elastic import ObservationModel
from skinfield.solve.operator import LinearOperator, propagated_std

ROOT = Path(__file__).resolve().parents[1]
PUBLIC = sorted(sf._ON_DEMAND)


def test_types_are_shipped() -> None:
    assert (Path(sf.__file__).parent / "py.typed").is_file()


@pytest.mark.parametrize("name", PUBLIC)
def test_public_names_are_explained(name: str) -> None:
    thing = getattr(sf, name)
    assert inspect.isroutine(thing) or inspect.isclass(thing) or inspect.ismodule(thing)
    said = inspect.getdoc(thing) or ""
    assert said, f"skinfield.{name} has no docstring"
    assert not said.startswith(f"{name}("), f"skinfield.{name} has only the text of its dataclass"


def test_core_needs_no_extra() -> None:
    needed = importlib.metadata.requires("skinfield") or []
    core = {re.split("[<>=]", line)[0] for line in needed if "extra ==" not in line}
    rest = {"threadpoolctl", "rich", "contourpy", "mcap", "websockets", "zarr"}
    rest |= {"cyclopts", "msgspec", "tomli-w"}
    assert core <= {"numpy", "scipy", "numba"} | rest


@pytest.fixture
def dev(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> types.ModuleType:
    """dev.py of a clone in a folder of its own, whose pip writes down what it would install."""
    (tmp_path / "dev.py").write_bytes((ROOT / "dev.py").read_bytes())
    extras = 'lint = ["ruff>=0.12"]\ntest = ["pytest>=8"]\ndev = ["skinfield[test,lint]", "mypy"]'
    (tmp_path / "pyproject.toml").write_text(f"[project.optional-dependencies]\n{extras}\n")
    spec = importlib.util.spec_from_file_location("dev", tmp_path / "dev.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.installed, module.outcomes = [], iter([])  # outcomes: of the next calls of pip
    monkeypatch.setattr(module, "find_spec", lambda name: None)  # no ensurepip: quick to make
    monkeypatch.setattr(module, "find_pip", lambda: ["pip"])

    def install(pip: list[str], what: str) -> int:
        outcome = next(module.outcomes, 0)
        if isinstance(outcome, BaseException):
            raise outcome
        module.installed += [] if outcome else [what]
        return outcome

    monkeypatch.setattr(module, "install", install)
    return module


def test_set_up_installs_once_and_only_what_is_missing(dev: types.ModuleType) -> None:
    for what in (".[lint]", ".", ".[test]", ".", ".[lint]"):
        dev.set_up(what)
    assert dev.installed == [".[lint]", ".[test]"]
    (dev.ROOT / "pyproject.toml").open("a").write("# second\n")
    for what in (".", ".", ".[dev]", ".[lint]", ".[test]"):
        dev.set_up(what)
    assert dev.installed == [".[lint]", ".[test]", ".", ".[dev]"]


@pytest.mark.parametrize("lost", ["python", ""])
def test_set_up_makes_a_broken_or_interrupted_environment_anew(
    dev: types.ModuleType, lost: str
) -> None:
    if lost:
        dev.set_up(".")
        (dev.BIN / lost).unlink()
    else:
        dev.outcomes = iter([KeyboardInterrupt()])
        with pytest.raises(KeyboardInterrupt):
            dev.set_up(".")
    (dev.VENV / "old").touch()
    dev.set_up(".")
    assert dev.installed == [".", "."][not lost :]
    assert (dev.BIN / "python").exists()
    assert not (dev.VENV / "old").exists()


def test_a_failing_pip_leaves_what_was_there(dev: types.ModuleType) -> None:
    dev.set_up(".")
    dev.outcomes = iter([7])
    with pytest.raises(SystemExit, match="status 7"):
        dev.set_up(".[lint]")
    dev.set_up(".")
    assert dev.installed == ["."]


def test_an_environment_of_ones_own_is_used_as_it_is(dev: types.ModuleType) -> None:
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(dev.VENV)], check=True)
    (dev.VENV / "mine").touch()
    dev.set_up(".")
    assert (dev.VENV / "mine").exists()


def test_an_old_python_is_told_what_is_needed(
    dev: types.ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dev.sys, "version_info", (3, 10, 4, "final", 0))
    with pytest.raises(SystemExit, match=r"Python 3\.10\.4, expected 3\.11 or newer"):
        dev.main("demo")
    ast.parse((ROOT / "dev.py").read_text(), feature_version=(3, 8))  # it gets as far as that


def test_no_pip_names_the_package_to_install(
    dev: types.ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.undo()
    monkeypatch.setattr(dev.shutil, "which", lambda name: None)
    with pytest.raises(SystemExit, match="apt install python3-venv"):
        dev.find_pip()


def test_help_names_every_command(
    dev: types.ModuleType, capsys: pytest.CaptureFixture[str]
) -> None:
    assert dev.main() == 0
    said = capsys.readouterr().out
    assert [name for name in dev.COMMANDS if f"dev.py {name}" not in said] == []
    assert dev.main("tset") == 2
    assert "'tset' is no command" in capsys.readouterr().out


def test_the_solver_that_contributing_shows_is_one() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text()
    code = text.split("```python\n")[1].split("```")[0]
    known = (dataclass, ObservationModel, LinearOperator, propagated_std)
    names: dict[str, Any] = {each.__name__: each for each in known}
    exec(code, names)
    patch = sf.layouts.rectangular(rows=5, columns=5)
    grid = sf.Grid.square(patch, nodes=5)  # a node above every taxel
    solver = names["Transpose"](gain=1e9)
    reconstruct = sf.Reconstructor(patch, grid=grid, solver=solver, quantity=sf.BaseStress())
    assert reconstruct(np.eye(25)[7]).pressure.argmax() == 7
