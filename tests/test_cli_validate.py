"""`skinfield cases` and `skinfield validate`, as a user calls them."""

import csv
import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, refused, result_of, run
from test_readme import doc, follow

from skinfield.lab.case_files import load_case

MADE = ("--seed", 4, "--quantity", "stress", "--noise", 200)
PAGE = doc("judge-a-solver")
OWN = """
import numpy as np
from skinfield.solve import LinearOperator

class Mine:
    def __init__(self, *, gain=1.0):
        self.gain = gain
    def prepare(self, model):
        matrix = self.gain * np.linalg.pinv(model.matrix)
        return LinearOperator(self, model, matrix, np.ones(len(matrix)))

ready = Mine(gain=0.5)

def make(gain):
    return Mine(gain=gain)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("made") / "cases"
    assert "wrote 3 cases" in run("cases", made, "--count", 3, *MADE)
    return made


def test_made_cases_can_be_read_and_are_those_of_the_seed(folder: Path, tmp_path: Path) -> None:
    names = [path.name for path in sorted(folder.iterdir())]
    assert names == ["000_ball12_1N.npz", "001_ball6_1N.npz", "002_flat3_0.5N.npz"]
    run("cases", tmp_path, "--count", 1, *MADE)
    one, again = load_case(folder / names[0]), load_case(tmp_path / names[0])
    np.testing.assert_array_equal(one.readings, again.readings)
    assert one.readings.shape == (4, 72)
    text = PAGE.read_text(encoding="utf-8")
    with np.load(folder / names[0]) as archive:
        for key in archive.files:
            assert f"`{key}`" in text, key


def test_cases_do_not_mix_with_those_of_another_set(tmp_path: Path) -> None:
    (tmp_path / "old.npz").write_bytes(b"of another set")
    (tmp_path / "notes.txt").write_text("kept")
    words = ("cases", str(tmp_path), "--count", "1", "--quantity", "stress")
    assert "1 NPZ file such as old.npz" in refused(*words)
    run(*words, "--force")
    assert {path.name for path in tmp_path.iterdir()} == {"000_ball12_1N.npz", "notes.txt"}


def test_either_standard_cases_or_unseen_ones(tmp_path: Path) -> None:
    assert "--count is 3 beside --unseen 2, expected one of them" in refused(
        "cases", tmp_path, "--unseen", "2", "--count", "3"
    )
    assert not list(tmp_path.iterdir())


def test_validate_prints_and_writes(folder: Path, tmp_path: Path) -> None:
    result = run(
        "validate", folder, "--grid", "20", "--per-case",
        "-o", tmp_path / "s.json", "-o", tmp_path / "s.csv",
    )  # fmt: skip
    for words in ("stress: 3 cases on", "as it is", "ball6"):
        assert words in result
    read = json.loads((tmp_path / "s.json").read_text())
    assert read["options"]["grid"] == 20
    (summary,) = read["summary"]
    assert (summary["method"], summary["noise"], summary["readings"]) == ("auto", None, 12)
    assert 0.1 < summary["place_error_mm_median"] < 4.0
    rows = read["rows"]
    assert [row["file"] for row in rows[::4]] == sorted(path.name for path in folder.iterdir())
    assert rows[0]["true_force_N"] == pytest.approx(1.0, rel=1e-4)
    with (tmp_path / "s.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [row["file"] for row in table] == sorted(path.name for path in folder.iterdir())
    assert {row["readings"] for row in table} == {"4"}
    errors = [row["place_error_mm"] for row in rows[:4]]
    assert float(table[0]["place_error_mm"]) == pytest.approx(np.median(errors), rel=1e-5)


def test_one_file_is_enough(folder: Path) -> None:
    words = ("--solver", "tikhonov", "--settings", '{"snr": 5}', "--mechanics", "half-space")
    result = run("validate", folder / "000_ball12_1N.npz", "--grid", 16, *words)
    assert "tikhonov" in result
    assert "stress: 1 case on" in result


def test_own_solver_from_the_current_folder(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "my_own_solver.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    forces = []
    for words in (("my_own_solver:Mine",), ("my_own_solver:ready",),
                  ("my_own_solver:make", "--settings", '{"gain": 0.25}')):  # fmt: skip
        run("validate", folder, "--grid", 12, "-o", "a.json", "--force", "--solver", *words)
        rows = json.loads(Path("a.json").read_text())["rows"]
        forces.append([row["total_force_error"] + 1 for row in rows])
    one, half, quarter = np.array(forces)
    np.testing.assert_allclose(half, one / 2)
    np.testing.assert_allclose(quarter, one / 4)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--solver magic", "--solver is 'magic', expected one of auto, "),
        ("--solver no_such_module:X", "cannot be imported: ModuleNotFoundError"),
        ("--solver json:Nothing", "module 'json' has no attribute 'Nothing'"),
        ("--solver json:loads", "json:loads says: "),
        ("--solver math:pi", "has no prepare"),
        ("--solver builtins:dict", "has no prepare"),
        ("--settings {", "expected a JSON object"),
        ("--settings [1]", "expected a JSON object"),
        ("--settings '{\"volume\": 11}'", "volume"),
        ("--solver gaussian --settings '{\"snr\": -1}'", "snr is -1"),
        ("--require beauty=1", "expected MEASURE=NUMBER"),
        ("--require missed", "expected MEASURE=NUMBER"),
        ("--gate-mm -1", "--gate-mm is -1.0, expected a finite number above 0"),
        ("-o s.xyz", "--output is 's.xyz', expected a name that ends in .csv or .json"),
        ("-o nowhere/s.csv", "nowhere is no folder"),
        ("--solver paper --settings '{\"snr\": 3}'", "the paper's method has none"),
        ("--grid 1", "--grid is 1, expected"),
        ("--unseen 2", "expected either CASES"),
        ("--idle 7", "--idle has no effect here: it belongs to --unseen"),
        ("--world cover", "--world has no effect here: it belongs to --unseen"),
        ("--seed 2", "--seed has no effect here: it belongs to --unseen or --noise"),
    ],
)
def test_what_cannot_be_used_is_said(folder: Path, words: str, message: str) -> None:
    assert message in refused("validate", folder, *shlex.split(words))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("", "expected either CASES"),
        ("--unseen 2 --noise 5", "expected one --quantity beside it"),
        ("--unseen 2 --noise -5 --quantity stress", "noise is -5"),
        ("--unseen 0", "--unseen is 0"),
        ("--unseen 2 --per-case", "-o FILE.csv has every press"),
        ("--unseen 2 --gate-mm 0", "--gate-mm is 0.0, expected a finite number"),
        ("--unseen 2 --grid 20", "--grid has no effect here: it belongs to"),
        ("--unseen 2 --skin nowhere", "generator is 'nowhere'"),
        ("--unseen 2 --solver magic", "--solver is 'magic'"),
        ("--unseen 2 --solver paper --solver gaussian --settings '{\"snr\": 2}'",
         "expected it beside one --solver that takes them"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_without_cases_is_said(words: str, message: str) -> None:
    assert message in refused("validate", *shlex.split(words))


def test_every_world_can_be_named() -> None:
    from typing import get_args

    from skinfield.cli.validate import WorldName
    from skinfield.lab.case_sets import WORLDS

    assert get_args(WorldName) == tuple(WORLDS)


def test_a_failing_solver_is_named_with_the_case_and_its_line(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("fails.py").write_text(
        "class Fails:\n    def prepare(self, model):\n        raise ZeroDivisionError('no way')\n"
    )
    result = refused("validate", folder, "--solver", "fails:Fails")
    assert "000_ball12_1N.npz: --solver fails:Fails fails with" in result
    assert "ZeroDivisionError: no way" in result
    assert "fails.py, line 3" in result


def test_a_case_beyond_memory_is_named(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*words: object) -> None:
        raise MemoryError("169 GiB")

    monkeypatch.setattr("skinfield.lab.validation.Entrant.rows", full)
    assert "000_ball12_1N.npz does not fit into memory" in refused("validate", folder)


@pytest.fixture(scope="module")
def exact(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("unseen") / "cases"
    run(
        "cases", made, "--unseen", "2", "--seed", "4", "--quantity", "stress",
        "--skin", "icub_hexagon", "--draws", "0",
    )  # fmt: skip
    return made


def test_several_solvers_at_several_noises(exact: Path, tmp_path: Path) -> None:
    files = tmp_path / "t.json", tmp_path / "t.csv"
    result = run(
        "validate", exact, "--solver", "paper", "--solver", "gaussian", "--grid", "20",
        "--noise", "0", "--noise", "400", "-o", files[0], "-o", files[1],
        "--require", "place_error_mm=10", "--require", "missed=1",
    )  # fmt: skip
    assert "stress: 2 cases" in result
    read = json.loads(files[0].read_text())
    found = [(row["noise"], row["method"]) for row in read["summary"]]
    assert found == [(0, "paper"), (0, "gaussian"), (400, "paper"), (400, "gaussian")]
    assert read["options"]["solver"] == ["paper", "gaussian"]
    assert len(read["rows"]) == 2 * 2 * 2
    with files[1].open() as file:
        table = list(csv.DictReader(file))
    assert len(table) == 2 * 2 * 2
    assert 0.0 < float(table[0]["place_error_mm"]) < 5.0


def test_unseen_presses_are_made_and_scored_beside_the_bound(tmp_path: Path) -> None:
    result = run(
        "validate", "--unseen", "2", "--quantity", "stress", "--noise", "400", "--solver",
        "gaussian", "--grid", "20", "--idle", "50", "--workers", "1", "-o", tmp_path / "a.json",
    )  # fmt: skip
    for part in ("stress: 2 cases on", "bound, size unknown", "interval %", "in noise"):
        assert part in result
    ours, known, unknown = json.loads((tmp_path / "a.json").read_text())["summary"]
    assert (ours["method"], ours["presses"], ours["idle_readings"]) == ("gaussian", 2, 50)
    assert 0.0 <= ours["force_held"] <= 1.0
    assert 0.0 < known["place_error_mm_median"] < unknown["place_error_mm_median"]


def test_own_solver_on_unseen_presses_in_several_processes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "my_unseen_solver.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    words = ("validate", "--unseen", 1, "--quantity", "stress", "--noise", 400, "--idle", 10)
    words += ("--workers", 2, "--grid", 10, "--solver", "my_unseen_solver:Mine")
    assert result_of(*words)[0]["method"] == "my_unseen_solver:Mine"


def test_errors_name_the_file(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "000_broken.npz").write_bytes(b"PK\x03\x04 nothing")
    assert "000_broken.npz" in refused("validate", tmp_path)
    assert "expected a folder of cases" in refused("validate", tmp_path / "nowhere")


def test_limits_decide_the_exit_code(folder: Path) -> None:
    bad = invoke(["validate", str(folder), "--grid", "16", "--require", "place_error_mm=0.001"])
    assert bad.exit_code == 1
    assert "required at most 0.001" in bad.output


def test_the_page_on_cases_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert follow(PAGE) == (2, 8)  # its last command is in test_cli_bench
    assert "mm off" in capsys.readouterr().out
    assert load_case("rig_017.npz").truth.contacts[0].force == 1.0
