"""Every example runs as it stands and prints the number that it should.

Those of examples/gallery run when the documentation is built, and hold what they should in asserts.
"""

import os
import re
import runpy
import shutil
from pathlib import Path

import matplotlib
import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
FOUND = {  # the last number with that unit, between; two-sided, so that an odd gain fails too
    "own_layout": ("N", 2.6, 3.4),  # 3.0
    "paper_method": ("N", 1.6, 2.0),  # 2.0; a plain inverse misses what lies between the taxels
    "light_press_filter": ("N", 0.14, 0.23),  # 0.2
    "judge_a_layout": ("mm", 0.3, 0.7),  # of place, under 5 mm
    "press_truth": ("mm deep", 0.5195, 0.5205),  # the integral equation has 0.5200
    "virtual_rig": ("N", 0.8, 1.4),  # 1.0
    "whole_skin": ("N", 1.3, 1.75),  # 1.5
    "own_solver_validated": ("mm", 1.0, 3.0),  # of place, median of four cases
}


def test_each_example_is_tested() -> None:
    assert {file.stem for file in EXAMPLES.glob("*.py")} == set(FOUND)


def keep(picture: Path) -> None:
    """Copy a picture to where people look at them, if there is such a place."""
    if asked := os.environ.get("SKINFIELD_PICTURES"):
        folder = Path(asked) / "examples"
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copy(picture, folder)


@pytest.mark.parametrize("name", FOUND)
def test_example(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with matplotlib.rc_context({"backend": "agg"}):
        runpy.run_path(str(EXAMPLES / f"{name}.py"))
    printed = capsys.readouterr().out
    unit, low, high = FOUND[name]
    assert low < float(re.findall(rf"([\d.]+)(?: ±.*)? {unit}\b", printed)[-1]) < high, printed
    for picture in re.findall(r"\S+\.png", printed):
        assert (tmp_path / picture).stat().st_size > 10_000
        keep(tmp_path / picture)
    if name == "light_press_filter":  # it sees what a single reading loses
        raw, smooth = map(int, re.findall(r"(\d+)%", printed))
        assert raw < 90
        assert smooth == 100
