"""Every example runs as it stands and prints the number that it should."""

import re
import runpy
from pathlib import Path

import matplotlib
import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
NEWTONS = {  # the last force that each prints, between; two-sided, so that an odd gain fails too
    "quickstart": (1.2, 2.3),  # pressed with 2.0
    "own_layout": (2.6, 3.4),  # 3.0
    "paper_method": (1.6, 2.0),  # 2.0; a plain inverse misses what lies between the taxels
    "light_press_filter": (0.14, 0.23),  # 0.2
}


def test_each_example_is_tested() -> None:
    assert {file.stem for file in EXAMPLES.glob("*.py")} == set(NEWTONS)


@pytest.mark.parametrize("name", NEWTONS)
def test_example(
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    with matplotlib.rc_context({"backend": "agg"}):
        runpy.run_path(str(EXAMPLES / f"{name}.py"))
    printed = capsys.readouterr().out
    low, high = NEWTONS[name]
    assert low < float(re.findall(r"([\d.]+)(?: ±.*)? N", printed)[-1]) < high, printed
    for picture in re.findall(r"\S+\.png", printed):
        assert (tmp_path / picture).stat().st_size > 10_000


def test_the_filter_sees_what_a_single_reading_loses(
    capsys: pytest.CaptureFixture[str],
) -> None:
    runpy.run_path(str(EXAMPLES / "light_press_filter.py"))
    raw, smooth = (int(share) for share in re.findall(r"(\d+)%", capsys.readouterr().out))
    assert raw < 90
    assert smooth == 100
