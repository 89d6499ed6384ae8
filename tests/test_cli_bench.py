"""`skinfield bench` from end to end, in its quickest form."""

from pathlib import Path

import pytest
from command_line import refused, result_of
from test_readme import blocks, doc

from skinfield.lab.bench.scene import SMOKE


def test_the_page_s_command_prints_its_numbers_and_leaves_a_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    page = list(blocks(doc("judge-a-solver")))
    (command,) = next(text for language, _, text in page if language == "bash").splitlines()
    found = result_of("bench", *command.split()[2:])
    assert (tmp_path / "bench.png").stat().st_size > 10_000
    names = {row["name"] for row in found["grids"]}
    assert {"paper", "paper, inversion alone", "paper's inverse, prepared"} <= names
    assert {"NonNegative to 1e-2, warm", "NonNegative to 1e-4, cold", "ContactFit"} <= names
    assert {row["nodes"] for row in found["grids"]} == set(SMOKE.grids)
    for row in found["grids"]:
        times = row["seconds_us"]
        assert 0 < times["min"] <= times["p50"] <= times["p99"] <= times["max"]
        assert row["certified"] in (None, 1.0), row["name"]
    points = {(p["solver"], p["start"], p["deadline_us"]): p for p in found["points"]}
    ladder = [*(round(1e6 * deadline) for deadline in SMOKE.deadlines), None]
    for solver in ("NonNegative", "ContactFit"):
        for start in ("warm", "cold"):
            assert all((solver, start, deadline) in points for deadline in ladder)
            last = points[solver, start, None]
            assert last["errors"]["p90"] < 1e-3  # without a deadline it converges
    assert points["GaussianField", "warm", None]["errors"]["max"] == 0.0
    assert points["paper", "cold", None]["errors"]["max"] == 0.0
    fit = points["ContactFit", "warm", None]
    assert fit["missed"] == 0.0
    assert fit["place_median_mm"] < 2.0
    assert found["machine"]["cores"] >= 1
    assert found["company"]["own"] > 0.0


@pytest.mark.parametrize(
    ("name", "words"), [("bench", "expected one of .png"), ("none/a.png", "is no folder")]
)
def test_a_name_of_no_picture_is_refused_before_anything_is_measured(
    tmp_path: Path, name: str, words: str
) -> None:
    assert words in refused("bench", "-o", tmp_path / name)
