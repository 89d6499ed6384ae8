"""Set up and run skinfield from a fresh clone: needs Python 3.11 or newer, nothing else.

  python3 dev.py demo [ARGS]    simulate a press, reconstruct it, print a table, write demo.png
  python3 dev.py test [ARGS]    run the tests; ARGS go to pytest: test tests/test_architecture.py -x
  python3 dev.py run ARGS       run any skinfield command: run --help
  python3 dev.py python ARGS    run Python with skinfield: python examples/gallery/tracks.py
  python3 dev.py lint           look for mistakes and at the formatting (ruff)
  python3 dev.py types          check the types (mypy)
  python3 dev.py docs           build the documentation, with its gallery, into out/site

The first call makes .venv beside this file and installs there what the command needs: a minute or
two. Later calls start at once, until pyproject.toml changes. Nothing else is touched; to start
anew, delete .venv.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from textwrap import shorten

OLDEST = (3, 11)
ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
PYTHON = str(BIN / ("python.exe" if os.name == "nt" else "python"))
STAMP = VENV / "skinfield-setup.txt"  # root, hash of pyproject.toml, what was installed
COMMANDS = {  # what to install, which programs to run
    "demo": (".[plot]", ["skinfield demo"]),
    "test": (".[test]", ["pytest -n auto --dist worksteal --durations=5"]),
    "run": (".[all]", ["skinfield"]),  # any command
    "python": (".[plot]", ["python"]),
    "lint": (".[lint]", ["ruff check", "ruff format --check"]),
    "types": (".[dev]", ["mypy"]),
    "docs": (".[docs]", ["sphinx-build -W --keep-going -q -d build/docs docs out/site"]),
}


def main(name: str = "--help", *rest: str) -> int:
    """Run one command; return its exit status."""
    if sys.version_info < OLDEST:
        raise SystemExit(
            f"dev.py: this is Python {'.'.join(map(str, sys.version_info[:3]))}, expected "
            f"{OLDEST[0]}.{OLDEST[1]} or newer: call such a one, as in python3.12 dev.py demo"
        )
    if name not in COMMANDS:
        asked = name in ("-h", "--help")
        print(__doc__ if asked else f"dev.py: {name!r} is no command, expected {[*COMMANDS]}")
        return 0 if asked else 2
    what, programs = COMMANDS[name]
    set_up(what)
    if name == "test":  # pytest fills the cores: threads inside each process would fight for them
        os.environ.setdefault("OMP_NUM_THREADS", "1")
    folder = None if name in ("demo", "run", "python") else ROOT  # where it was called, or all
    for program, *fixed in map(str.split, programs):
        if status := subprocess.call([str(BIN / program), *fixed, *rest], cwd=folder):
            return status
    return 0


def set_up(what: str) -> None:
    """Make .venv unless it works, and install what is missing or out of date."""
    project = hashlib.sha256((ROOT / "pyproject.toml").read_bytes()).hexdigest()
    blank = f"{ROOT}\n\n"  # a .venv that somebody else made is used as it is
    stamp = STAMP.read_text() if STAMP.exists() else blank
    root, made_for, done, *_ = stamp.split("\n")
    if root != str(ROOT) or not works():
        print("dev.py: making .venv", flush=True)
        shutil.rmtree(VENV, ignore_errors=True)
        venv = [sys.executable, "-m", "venv", str(VENV)]
        if find_spec("ensurepip") is None or subprocess.call(venv):
            subprocess.call([*venv, "--without-pip", "--clear"])  # another pip can install into it
        stamp, made_for = blank, ""
    done = done if made_for == project else ""
    if not done or needs(what) - {each for one in done.split() for each in needs(one)}:
        pip = find_pip()
        STAMP.write_text("unfinished\n\n")  # stays if this is killed
        if status := install(pip, what):
            STAMP.write_text(stamp)
            raise SystemExit(f"dev.py: pip failed with status {status}; its reason stands above")
        STAMP.write_text(f"{ROOT}\n{project}\n{done} . {what}")


def needs(what: str) -> set[str]:
    """Requirements of `.[extra]`, those of the extras that it names among them; none of `.`."""
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras: dict[str, list[str]] = project["optional-dependencies"]
    found: set[str] = set()
    for name in re.findall(r"[\w-]+", what.partition("[")[2]):
        for each in extras[name]:
            found |= needs(each) if each.startswith("skinfield[") else {each}
    return found


def works() -> bool:
    """Whether the Python in .venv starts and is new enough."""
    code = f"import sys; sys.exit(sys.version_info < {OLDEST})"
    try:
        return not subprocess.call([PYTHON, "-c", code], stderr=subprocess.DEVNULL)
    except OSError:
        return False


def find_pip() -> list[str]:
    """Find a pip that can install into .venv: its own, this Python's, or one on the PATH."""
    for pip in ([PYTHON, "-m", "pip"], [sys.executable, "-m", "pip"], ["pip3"], ["pip"]):
        if shutil.which(pip[0]):
            command = [*pip, "--python", PYTHON]
            if not subprocess.run([*command, "--version"], capture_output=True).returncode:
                return command
    raise SystemExit(
        f"dev.py: {sys.executable} has no ensurepip and no pip that can install into .venv, "
        "expected one of them: on Debian or Ubuntu, sudo apt install python3-venv, then call again"
    )


def install(pip: list[str], what: str) -> int:
    """Install this checkout with what it needs; return the exit status of pip."""
    print(f"dev.py: installing {what} into .venv, with all it needs: a minute or two", flush=True)
    command = [*pip, "install", "--no-input", "--disable-pip-version-check", "-e", what]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout or ():
            if line.startswith(("Collecting ", "Building ", "Installing ")):
                print("  " + shorten(line.split(" (from")[0], 90), flush=True)
    return process.returncode


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
