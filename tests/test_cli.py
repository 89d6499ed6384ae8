"""The command line as a whole: what help teaches, how errors read, what a file of settings does."""

import json
import os
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, refused, result_of, run

from skinfield.cli.main import COMMANDS, LAB, app_for
from skinfield.cli.report import print_json
from skinfield.cli.settings import load_settings, settings_from_toml

SNAPSHOT = Path(__file__).with_name("cli_help.txt")  # UPDATE_HELP=1 writes it anew
GROUPS = ("layout", "calibrate")
VISIBLE = 13


def commands() -> list[tuple[str, ...]]:
    """All commands, with those within groups."""
    found: list[tuple[str, ...]] = [(name,) for name in COMMANDS if name not in GROUPS]
    for name in GROUPS:
        found += [(name, each) for each in app_for([name])[name] if not each.startswith("-")]
    return found + [("lab", name) for name in LAB]


@pytest.mark.parametrize("words", commands(), ids=" ".join)
def test_every_command_teaches_by_example(words: tuple[str, ...]) -> None:
    named = " ".join(words[1:] if words[0] == "lab" else words)
    assert f"\n  skinfield {named}" in run(*words, "--help").split("\n", 2)[2]


def test_help_is_as_it_was() -> None:
    texts = []
    for words in ((), ("tune",)):  # headings, commands, options, defaults, paragraphs
        text = invoke([*words, "--help"]).stdout
        texts.append("\n".join(line.rstrip() for line in text.splitlines()).rstrip())
    found = "\n\n\n".join(texts) + "\n"
    if os.environ.get("UPDATE_HELP"):
        SNAPSHOT.write_text(found, encoding="utf-8")
    assert found == SNAPSHOT.read_text(encoding="utf-8")


def test_few_commands_are_listed_and_the_rest_is_named() -> None:
    text = invoke(["--help"]).stdout
    listed = re.findall(r"^  ([a-z]+)  +[A-Z]", text, re.MULTILINE)
    assert len(listed) <= VISIBLE
    for name in COMMANDS:
        assert re.search(rf"\b{name}\b", text + invoke(["lab", "--help"]).stdout), name


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["layuot"], "Error: 'layuot' is no command of skinfield (did you mean layout?)"),
        (["layout", "lnit"], "'lnit' is no command of skinfield layout (did you mean lint?)"),
        (["lab", "pres"], "'pres' is no command of skinfield lab (did you mean press?)"),
        (["run", "--rate-hx", "5"], "Unknown option: --rate-hx. Did you mean --rate-hz?"),
        (["run", "--rate-hz", "fast"], 'Invalid value for --rate-hz: unable to convert "fast"'),
        (["run", "--rate-hz"], "--rate-hz requires an argument"),
        (["run", "--rate-hz", "-3"], "--rate-hz is -3.0, expected a finite number above 0"),
        (["run", "--solver", "best"], 'Invalid value "best" for --solver'),
        (["layout", "show", "hexagon72"], "--output"),
        (["layout", "lint", "no_such.txt"], "no_such.txt: no such file, and no generator"),
        (["layout", "lint", "hexagon72:rows=3"], "rows"),
        (["layout", "show", "hexagon72", "-o", "a.gif"], "'.gif'"),
        (["layout", "show", "rectangular:rows=x", "-o", "a.png"], "rows"),
        (["layout", "convert", "hexagon72", "a.xyz"], "'.xyz'"),
        (["layout", "convert", "hexagon72", "a.pcd"], "no layout format that is written"),
        (["layout", "convert", "hexagon72", "a.txt", "--patch", "x"], "patch 'x' is not in"),
        (["run", "nowhere.toml"], "nowhere.toml cannot be read: No such file"),
        (["tune", "--smoothing", "3"], "--smoothing"),
        (["design", "hexagon72", "--force-n", "-1"], "--force-n is -1.0, expected a finite"),
        (["press", "--cell-mm", "nan"], "--cell-mm is nan, expected a finite number above 0"),
        (["emulate", "--duration", "-1"], "--duration is -1.0, expected a finite number above 0"),
        (["emulate", "--fault", "rain 3"], "--fault is 'rain 3': kind is 'rain', expected one of"),
        (["emulate", "--temperature", "x"], "--temperature is 'x': temperature is 'x', expected"),
        (["run", "--bus", "foo"], "--bus is 'foo': interface is 'foo', expected udp, socketcan"),
    ],
)
def test_errors_are_one_paragraph(words: list[str], text: str) -> None:
    done = invoke(words)
    assert done.exit_code == 2
    assert done.stdout == ""
    assert text in done.stderr
    assert done.stderr.startswith("Error: ")
    assert done.stderr.count("\n") <= 2
    assert "Traceback" not in done.stderr


def test_flags_come_before_a_file_and_both_are_written(tmp_path: Path) -> None:
    before, after = tmp_path / "before.toml", tmp_path / "after.toml"
    before.write_text(
        '[skin]\nlayout = "icub_triangle"\n[loop]\nrate_hz = 200\nevents = true\ntare_s = 2\n'
        '[source]\nchannel = ["can0", "can1"]\n'
    )
    words = ["--rate-hz", "50", "--no-events", "--channel", "can7", "--save", str(after)]
    run("run", before, *words)
    assert load_settings(after) == settings_from_toml(
        '[skin]\nlayout = "icub_triangle"\n[loop]\nrate_hz = 50\ntare_s = 2\n'
        '[source]\nchannel = ["can7"]\n'
    )
    assert "there already" in refused("run", "--save", after)
    run("run", "--skin", "icub_hexagon", "--save", after, "--force")
    assert after.read_text() == '[skin]\nlayout = "icub_hexagon"\n'


def test_json_is_json_even_of_what_is_no_number(capsys: pytest.CaptureFixture[str]) -> None:
    print_json({"a": float("nan"), "b": [np.float64(0.5), float("inf")], "c": np.int64(3)})
    text = capsys.readouterr().out
    assert json.loads(text, parse_constant=pytest.fail) == {"a": None, "b": [0.5, None], "c": 3}


@pytest.mark.parametrize(
    ("command", "keys"),
    [
        (
            "demo --grid 12 --skin icub_triangle --press 0,0,1,4 -o a.png",
            {"contacts", "presses", "picture"},
        ),
        ("press --plot a.png --skin icub_triangle", {"bodies", "force_N", "readings"}),
        ("cases made --count 1 --quantity stress", {"folder", "files"}),
        ("layout show hexagon72 -o a.png", {"name", "patches", "file"}),
        ("layout convert hexagon72 a.toml", {"name", "patches", "file"}),
        ("rig --new a.toml", {"scenario"}),
    ],
)
def test_what_says_something_says_it_as_json(
    command: str, keys: set[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert keys <= result_of(*command.split()).keys()


def test_the_command_is_also_a_module() -> None:
    words = [sys.executable, "-m", "skinfield", "--version"]
    said = subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    assert said == version("skinfield")


def test_what_a_command_loads_later_computes_on_one_thread() -> None:
    script = """
import contextlib, sys
from skinfield.cli import main
with contextlib.suppress(SystemExit):
    sys.argv = ["skinfield", "--version"]
    main()
import scipy.linalg
from threadpoolctl import threadpool_info
print(*(each["num_threads"] for each in threadpool_info() if "scipy.libs" in each["filepath"]))
"""
    kept = {name: value for name, value in os.environ.items() if "NUM_THREADS" not in name}
    words = [sys.executable, "-c", script]
    done = subprocess.run(words, env=kept, check=True, capture_output=True, text=True)
    assert set(done.stdout.splitlines()[-1].split()) == {"1"}
