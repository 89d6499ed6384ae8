"""The page on the ring: its programs run, its tables are those of the code."""

import re
from pathlib import Path

import pytest
from ring_scenes import own_name

from skinfield.ring import header

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "ring.md").read_text(encoding="utf-8")


def snippet(language: str) -> str:
    (text,) = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    return text


def test_python_runs(capsys: pytest.CaptureFixture[str]) -> None:
    with own_name() as name:
        exec(compile(snippet("python").replace('"demo"', repr(name)), "ring.md", "exec"), {})
    shown, log = capsys.readouterr().out.splitlines()
    assert shown == "1 [ 0.   0.  -1.5] {'unit': 'N'} RUNNING True"
    assert log == "16 bytes, 0 lost"


def test_c_is_the_example() -> None:  # which test_ring_c compiles and runs
    assert snippet("c") == (ROOT / "examples" / "c" / "ring_watch.c").read_text()


def test_layout_is_that_of_the_code() -> None:
    rows = re.findall(r"^(\d+) +(\d+|\.\.\.) +(.+)$", header.__doc__ or "", re.MULTILINE)
    assert len(rows) > 30
    for offset, size, what in rows:
        assert f"| {offset} | {size} | {what.replace('``', '`')} |" in PAGE
