"""The cache of machine code: what it is made from, and that it never outlives it."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import result_of

import skinfield
from skinfield import compiled

SOURCES = {
    "__init__.py": "",
    "numbers.py": "BEGIN = 1000\n",
    "low/__init__.py": "",
    "low/callee.py": (
        "from skinfield.compiled import njit\n\n@njit\ndef step(x):\n    return x + 1\n"
    ),
    "caller.py": (
        "from skinfield.compiled import inner, njit\n"
        "from skinfield.low import callee\nfrom skinfield.numbers import (\n    BEGIN,\n)\n\n"
        "step = callee.step\n\n@inner\ndef half(x):\n    return x // 2\n\n"
        "@njit\ndef total(x):\n    return half(BEGIN + step(x))\n"
    ),
}
RUN = (
    "from skinfield.caller import total; print(total(1), sum(total.stats.cache_hits.values()));"
    "from skinfield import compiled; print(compiled.code_folder())"
)


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A package of three files beside the module under test."""
    package = tmp_path / "src" / "skinfield"
    for name, text in SOURCES.items():
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(text)
    shutil.copy(compiled.__file__, package / "compiled.py")
    return package


def run(package: Path, **environment: str) -> tuple[list[str], Path]:
    """What a process of its own computes, how much of it was compiled before, and its cache."""
    names = {**os.environ, "XDG_CACHE_HOME": str(package.parent / "home")}
    names.pop("NUMBA_CACHE_DIR", None)
    names |= {"PYTHONPATH": str(package.parent), "PYTHONDONTWRITEBYTECODE": "1", **environment}
    command = [sys.executable, "-c", RUN]
    ran = subprocess.run(command, env=names, check=True, capture_output=True, text=True)
    values, root = ran.stdout.splitlines()
    return values.split(), Path(root)


def replace(file: Path, old: str, new: str) -> None:
    """Change a source so that neither its size nor its time shows it."""
    times = file.stat()
    assert len(old) == len(new)
    file.write_text(file.read_text().replace(old, new))
    os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))


def test_a_change_of_what_a_kernel_calls_or_imports_is_compiled_again(checkout: Path) -> None:
    assert run(checkout)[0] == ["501", "0"]
    values, root = run(checkout)
    assert values == ["501", "1"]
    assert root == checkout.parent / "home" / "skinfield" / "kernels"
    replace(checkout / "low" / "callee.py", "x + 1", "x + 9")
    assert run(checkout)[0] == ["505", "0"]
    replace(checkout / "numbers.py", "1000", "2000")
    assert run(checkout)[0] == ["1005", "0"]


def test_the_users_folder_is_used_and_code_with_checks_lies_apart(checkout: Path) -> None:
    chosen = {"NUMBA_CACHE_DIR": str(checkout.parent / "chosen")}
    assert run(checkout, **chosen)[0] == ["501", "0"]
    values, root = run(checkout, NUMBA_BOUNDSCHECK="1", **chosen)
    assert values == ["501", "0"]
    assert root == checkout.parent / "chosen" / "skinfield" / "kernels"
    assert not (checkout.parent / "home").exists()


def test_a_folder_that_cannot_be_written_to_is_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    monkeypatch.setattr(compiled.CONFIG, "CACHE_DIR", "")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with pytest.warns(RuntimeWarning, match=r"file/skinfield/kernels cannot be written to .*Set "):
        root = compiled.code_folder()
    assert root.parent == tmp_path
    root.chmod(0o777)  # as if another user had made it
    with pytest.warns(RuntimeWarning, match="cannot be written to"):
        assert compiled.code_folder() != root


def test_few_versions_of_a_module_stay_and_no_checkout_that_is_gone(
    checkout: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    caches = [each for each in vars(compiled).values() if hasattr(each, "cache_clear")]
    monkeypatch.setattr(compiled.CONFIG, "CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(compiled, "PACKAGE", checkout)
    gone = tmp_path / "skinfield" / "kernels" / "gone"
    gone.mkdir(parents=True)
    (gone / "checkout").write_text(str(tmp_path / "gone"))
    folders = []
    try:
        for number in range(compiled.VERSIONS_PER_MODULE + 2):
            (checkout / "numbers.py").write_text(f"BEGIN = {number}\n")
            for each in caches:
                each.cache_clear()
            folders.append(compiled.cache_folder(checkout / "caller.py"))
            os.utime(folders[-1], (number, number))
            compiled.cache_folder(checkout / "low" / "callee.py")
    finally:
        for each in caches:
            each.cache_clear()
    assert [folder.is_dir() for folder in folders] == [False, False, True, True, True]
    assert len(list(folders[-1].parent.glob("low.callee-*"))) == 1
    assert not gone.exists()


def test_every_kernel_is_compiled_by_this_module() -> None:
    package = Path(skinfield.__file__).parent
    own = re.compile(r"^\s*from numba import .*\bn?jit\b|\bnumba\.n?jit\b", re.MULTILINE)
    users = [file for file in package.rglob("*.py") if own.search(file.read_text())]
    assert users == [package / "compiled.py"]


@pytest.mark.slow
def test_warmup_is_a_run_that_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("skinfield.cli.run.SETTLE", 1.0)
    found = result_of("warmup")
    assert found["cycles"] > 35
    assert found["seconds"] > 1.0
