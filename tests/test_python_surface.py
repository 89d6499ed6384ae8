"""Python's surface: pictures, notebooks, reading any file, pickles, data sets, names."""

import base64
import json
import multiprocessing
import pickle
import re
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot
from mcap_sample import ROWS
from scipy.io import savemat

import skinfield as sf
from skinfield import errors, plot
from skinfield.calibrate import save_calibration
from skinfield.errors import FileError, InputError
from skinfield.estimate.contact_table import COLUMNS
from skinfield.files import save_recording, write_contacts
from skinfield.files.layouts import own_toml
from skinfield.files.mcap import RecordingWriter
from skinfield.files.mcap.schema import Enclosed
from skinfield.signal import Blocks, Calibration, Kind
from skinfield.skin.reading import Recording

PATCH = sf.layouts.rectangular(rows=4, columns=5)
GRID = sf.Grid.square(PATCH, nodes=12)
READING = np.where(np.arange(20) == 7, 0.2, 0.0)
RUN = np.array([0.0, 0.5, 1.0])[:, None] * READING
EVIL = "<script>&'\""
THINGS = ["patch", "curved", "skin", "pair", "layer", "recording", "calibration", "estimate", "run"]


def recording() -> Recording:
    time = np.arange(50)
    counts = 100.0 + np.outer(time % 9, np.arange(20))
    return Recording(time * 10**7, counts, source=EVIL)


@cache
def reconstructor() -> sf.Reconstructor:
    return sf.Reconstructor(PATCH, grid=GRID, solver=sf.GaussianField())


@cache
def things() -> dict[str, Any]:
    named = sf.Patch(PATCH.positions, name=EVIL)
    return {
        "patch": named,
        "curved": sf.layouts.cylinder(radius=30e-3, arc_angle=1.0, length=20e-3),
        "skin": sf.Skin((named,), name=EVIL),
        "pair": sf.Skin((named, PATCH), name=EVIL, notes=(EVIL,)),
        "layer": sf.Layer(),
        "recording": recording(),
        "calibration": Calibration.identity(named, noise_std=0.01),
        "estimate": reconstructor()(READING),
        "run": reconstructor()(RUN, stamp_ns=np.arange(3) * 10**9),
    }


@pytest.mark.parametrize("name", THINGS)
def test_it_draws_itself_into_axes_with_units(name: str) -> None:
    thing = things()[name]
    made = thing.plot()
    try:
        assert pyplot.fignum_exists(made.figure.number)  # which notebooks show
        for label in (made.get_xlabel(), made.get_ylabel()):
            assert re.search(r"\((mm|s|N)\)|counts|ΔC/C₀|\(row of the patch\)", label), label
    finally:
        pyplot.close("all")
    if name != "curved":
        figure = plot.new_figure()
        left, right = figure.subplots(1, 2)
        assert thing.plot(right) is right
        assert not left.has_data()
    with pytest.raises(InputError, match="expected Matplotlib axes"):
        thing.plot("axes")
    assert not pyplot.get_fignums()


@pytest.mark.parametrize("name", THINGS)
def test_notebooks_show_a_small_picture_and_a_table(name: str) -> None:
    html = things()[name]._repr_html_()
    assert len(html) < 60_000
    assert EVIL not in html
    assert "<script" not in html
    (data,) = re.findall(r'src="data:image/png;base64,([^"]+)"', html)
    assert base64.b64decode(data).startswith(b"\x89PNG\r\n\x1a\n")
    assert html.count("<tr>") == html.count("</tr>") >= 3


@pytest.mark.parametrize("name", THINGS)
def test_a_repr_is_one_short_line(name: str) -> None:
    text = repr(things()[name])
    assert "\n" not in text
    assert "array" not in text
    assert len(text) < 130


def test_reprs_have_units() -> None:
    assert repr(sf.Layer()) == "Layer(thickness 2.00 mm, E 150 kPa, ν 0.5, εᵣ 3)"
    assert repr(recording()) == (
        "Recording(50 readings of 20 channels, 0.490 s at 100 Hz, unit 'count')"
    )
    assert repr(sf.Skin(PATCH, name="hand")) == "Skin('hand', 20 taxels on 1 patch)"
    assert repr(reconstructor()) == (
        "Reconstructor('rectangular', GaussianField, 12 x 12 nodes, "
        "Layer(thickness 2.00 mm, E 150 kPa, ν 0.5, εᵣ 3))"
    )
    assert re.fullmatch(
        r"Contact\(.+ N at \(.+\) mm, .+ mm², \w+\)", repr(reconstructor()(READING).contacts[0])
    )


def test_the_lines_of_a_long_recording_keep_its_extremes() -> None:
    counts = np.zeros((100_003, 2))
    counts[[17, 50_001, 100_002], 1] = 5.0, -7.0, 3.0
    axes = Recording(np.arange(len(counts)) * 10**6, counts).plot(plot.new_figure(), channels=[1])
    (line,) = axes.get_lines()
    drawn = np.asarray(line.get_ydata())
    assert (drawn.max(), drawn.min(), drawn[-1]) == (5.0, -7.0, 3.0)
    assert len(drawn) < 5000
    with pytest.raises(InputError, match="channels is 2, expected"):
        Recording(np.arange(3), np.zeros((3, 2))).plot(plot.new_figure(), channels=[2])


def test_forces_of_contacts_stand_beside_them() -> None:
    estimate = reconstructor()(READING)
    axes = estimate.plot(plot.new_figure())
    words = " ".join(text.get_text() for text in axes.texts)
    force, std = estimate.contacts[0].normal_force, estimate.contacts[0].force_std
    assert f"{plot.plus_minus(force, std)} N" in words


def test_without_matplotlib_the_table_remains(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    monkeypatch.setattr(plot, "find_spec", lambda name: None)
    html = PATCH._repr_html_()
    assert html.startswith("<table>")
    assert "20" in html
    for draw in (PATCH.plot, plot.style):
        with pytest.raises(InputError, match=re.escape('pip install "skinfield[plot]"')):
            draw()


def test_another_missing_package_is_not_explained_away() -> None:
    with pytest.raises(ModuleNotFoundError), errors.needs("matplotlib", "skinfield[plot]", "it"):
        import no_such_package  # type: ignore[import-not-found]  # noqa: F401


def test_dir_shows_what_is_computed_later() -> None:
    estimate = sf.Reconstructor(PATCH, grid=GRID)(READING)
    fields = set(sf.Estimate.__dataclass_fields__)
    assert "displacement" not in vars(estimate)
    assert fields <= set(dir(estimate))
    assert "displacement" not in vars(estimate)  # and to look computes nothing
    late = sf.Contact.later(reconstructor()(READING).contacts[0], area=1.0)
    assert set(sf.Contact.__dataclass_fields__) <= set(dir(late))


def test_contacts_are_a_tuple_and_a_data_frame() -> None:
    estimate = reconstructor()(READING, stamp_ns=5)
    contacts = estimate.contacts
    assert isinstance(contacts, tuple)
    frame = contacts.to_pandas()
    assert tuple(frame.columns) == COLUMNS
    assert frame["x_m"].tolist() == [contact.position[0] for contact in contacts]
    assert frame["stamp_ns"].tolist() == [5] * len(contacts)
    assert frame["total_force_N"].iloc[0] == estimate.normal_force
    untimed = [name for name in COLUMNS if name not in ("stamp_ns", "time_s")]
    assert list(reconstructor()(0.0 * READING).contacts.to_pandas().columns) == untimed
    assert contacts._repr_html_().count("<tr>") == 1 + len(contacts)


def test_contacts_of_a_run_name_their_reading_and_agree_with_the_file(tmp_path: Path) -> None:
    run = reconstructor()(RUN, stamp_ns=np.array([10, 20, 30]) * 10**9)
    frame = run.contacts.to_pandas()
    assert set(frame["reading"]) == {1, 2}
    assert set(frame["time_s"]) == {10.0, 20.0}
    write_contacts(tmp_path / "contacts.csv", run)
    stored = sf.read(tmp_path / "contacts.csv").to_pandas()
    assert stored["force_N"].tolist() == frame["force_N"].tolist()
    assert pickle.loads(pickle.dumps(run)).contacts.to_pandas().equals(frame)


def answers(pickled: list[bytes], reading: Any, queue: Any) -> None:
    queue.put([pickle.loads(each)(reading).pressure for each in pickled])


def test_reconstructors_answer_alike_in_another_process() -> None:
    made = Calibration.identity(PATCH, noise_std=0.01)
    settings: dict[str, Any] = {"grid": GRID, "solver": sf.GaussianField()}
    every = [reconstructor(), sf.Reconstructor(PATCH, calibration=made, **settings)]
    pressure = [rec(READING).pressure for rec in every]  # surfaces are worked out by now
    pickled = [pickle.dumps(rec) for rec in every]
    assert max(map(len, pickled)) < 10_000
    context = multiprocessing.get_context("spawn")  # as dask starts its workers
    queue = context.Queue()
    process = context.Process(target=answers, args=(pickled, READING, queue))
    process.start()
    try:
        np.testing.assert_array_equal(queue.get(timeout=240), pressure)
    finally:
        process.join(60)
        process.kill()


def test_a_reconstructor_of_a_skin_within_a_budget_goes_through_a_pickle() -> None:
    skin = sf.Skin((PATCH, sf.Patch(PATCH.positions, name="other")))
    settings: dict[str, Any] = {"budget": 1.0, "grid": (6, 12), "solver": sf.GaussianField()}
    rec: Any = sf.Reconstructor(skin, noise_std={"other": 0.02}, **settings)
    again = pickle.loads(pickle.dumps(rec))
    assert len(pickle.dumps(rec)) < 20_000
    assert (again.budget, again.rungs) == (1.0, (6, 12))
    readings = {"rectangular": READING, "other": 0.5 * READING}
    for name in readings:
        np.testing.assert_array_equal(again(readings)[name].pressure, rec(readings)[name].pressure)


def test_a_patch_from_a_pickle_is_read_only() -> None:
    again = pickle.loads(pickle.dumps(PATCH))
    assert not again.positions.flags.writeable
    assert not pickle.loads(pickle.dumps(GRID)).origin.flags.writeable
    np.testing.assert_array_equal(again.surface.plane, PATCH.plane)


@pytest.mark.parametrize(
    ("solver", "object_"),
    [
        ("gaussian", "sf.GaussianField()"),
        ("nonnegative", "sf.NonNegative()"),
        ("auto", "sf.Auto()"),
    ],
)
def test_strings_for_solvers_are_refused_with_the_object(solver: Any, object_: str) -> None:
    expected = f"solver is {solver!r}, a string; hand in an object: {object_}"
    for settings in ({}, {"budget": 1e-3}):
        with pytest.raises(InputError) as caught:
            sf.Reconstructor(PATCH, solver=solver, **settings)
        assert str(caught.value) == expected


def test_a_class_for_a_solver_is_refused_with_the_object() -> None:
    with pytest.raises(InputError, match=r"the class Auto, expected an object: give Auto\(\)"):
        sf.Reconstructor(PATCH, solver=sf.Auto)  # type: ignore[arg-type]


def test_any_file_is_read_by_its_content(tmp_path: Path) -> None:
    made = Calibration.identity(PATCH, noise_std=0.01)
    for ending in ("toml", "npz"):
        sf.save_layout(PATCH, tmp_path / f"layout.{ending}")
        assert isinstance(sf.read(tmp_path / f"layout.{ending}"), sf.Skin)
        save_calibration(made, tmp_path / f"calibration.{ending}")
        assert sf.read(tmp_path / f"calibration.{ending}").basis == made.basis
    for ending in ("csv", "npz"):
        save_recording(recording(), tmp_path / f"recording.{ending}")
        read = sf.read(str(tmp_path / f"recording.{ending}"))
        np.testing.assert_array_equal(read.counts, recording().counts)
    write_contacts(tmp_path / "contacts.parquet", reconstructor()(READING))
    assert sf.read(tmp_path / "contacts.parquet").column_names == list(COLUMNS)
    sf.save_results(tmp_path / "run.skinfield", reconstructor(), RUN, np.arange(3) * 10**9)
    assert sf.read(tmp_path / "run.skinfield").sizes["reading"] == 3


def test_a_recording_of_a_live_skin_that_encloses_its_files_is_read(tmp_path: Path) -> None:
    blocks = Blocks(512)
    sf.save_layout(PATCH, tmp_path / "hand.toml")
    save_calibration(Calibration.identity(PATCH, noise_std=0.01), tmp_path / "its.toml")
    stated = {"ports": [["skin", 20, "count"]], "calibration": "skinfield-calibration"}
    files = {name: (tmp_path / name).read_bytes() for name in ("hand.toml", "its.toml")}
    files["configuration.json"] = json.dumps(stated).encode()
    enclosed = [Enclosed(name, "", data) for name, data in files.items()]
    writer = RecordingWriter(tmp_path / "touch", enclosed, layout=ROWS)
    for stamp in (0, 10**7):
        blocks.put(stamp, 0, np.arange(20.0) + stamp, Kind.FLOATS)
    writer.write_blocks(10**7, 0, bytes(blocks.data))
    writer.close()
    read = sf.read(tmp_path / "touch")
    np.testing.assert_array_equal(read.counts, np.arange(20) + np.array([[0.0], [1e7]]))
    assert read.stamp_ns.tolist() == [0, 10**7]
    with pytest.raises(FileError, match="no known format, expected a layout file"):
        sf.load_layout(tmp_path / "touch")


def test_contacts_of_a_csv_are_read_without_pyarrow(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, run = tmp_path / "contacts.csv", reconstructor()(RUN, stamp_ns=np.arange(3) * 10**9)
    write_contacts(path, run)
    for module in ("pyarrow", "pyarrow.parquet", "pyarrow.csv"):
        monkeypatch.setitem(sys.modules, module, None)
    read = sf.read(path)
    assert read.column_names == list(COLUMNS)
    assert read.to_pandas().equals(run.contacts.to_pandas())
    assert read["force_N"].tolist() == [one.normal_force for each in run.contacts for one in each]
    head, first, *_ = path.read_text().splitlines()
    path.write_text(f"# by hand\n{head},track,grip\n{first},,left\n")
    assert np.isnan(sf.read(path)["track"]).all()
    assert sf.read(path)["grip"].tolist() == ["left"]
    path.write_text(f"{head}\n{first.replace('1,', 'one,', 1)}\n")
    with pytest.raises(FileError, match=r"column reading: .*'one'.* expected a whole table"):
        sf.read(path)
    path.write_text(f"{head}\n{first[:20]}\n")
    with pytest.raises(FileError, match=r"row 1 has .* values, expected 24"):
        sf.read(path)
    path.write_text(f"{head}\n")
    assert len(sf.read(path)) == 0


def test_a_log_of_any_columns_is_read_by_its_skins_file(tmp_path: Path) -> None:
    names = [f"q{k}" for k in range(20)]
    log = f"[log]\ntime = 'when'\ntime_unit = 'ms'\ncolumns = {names}\nunit = 'dC/C0'\n"
    of_array = f"[log]\nrate_hz = 50.0\ncolumns = {[str(k + 1) for k in range(20)]}\n"
    values = np.outer([1.0, 2.0, 3.0], np.arange(20.0))
    table = np.column_stack([np.zeros(3), [0.0, 20.0, 40.0], values])
    head = ",".join(["battery", "when", *names])
    np.savetxt(tmp_path / "log.csv", table, "%g", ",", header=head, comments="")
    savemat(tmp_path / "log.mat", {"C": values})
    for file, text, unit in (("log.csv", log, "dC/C0"), ("log.mat", of_array, "count")):
        own_toml.write(sf.Skin(PATCH, name="mine"), tmp_path / "mine.toml", text)
        read = sf.read(tmp_path / file, skin=str(tmp_path / "mine.toml"))
        np.testing.assert_array_equal(read.counts, values)
        assert read.stamp_ns.tolist() == [0, 20_000_000, 40_000_000]
        assert read.unit == unit
        with pytest.raises(FileError, match=r"sf\.read\(path, skin=\.\.\.\).*`skinfield new`"):
            sf.read(tmp_path / file)
    save_recording(recording(), tmp_path / "usual.csv")
    sf.save_layout(PATCH, tmp_path / "mine.toml")  # without [log]: as its format says
    assert len(sf.read(tmp_path / "usual.csv", skin=tmp_path / "mine.toml")) == 50
    with pytest.raises(InputError, match=r"skin is Patch.*expected .*that `skinfield new` wrote"):
        sf.read(tmp_path / "log.csv", skin=PATCH)  # type: ignore[arg-type]
    with pytest.raises(FileError, match="No such file"):
        sf.read(tmp_path / "log.csv", skin=tmp_path / "nothing.toml")


def test_what_is_no_path_no_truth_and_no_reading_is_refused_with_what_to_hand_in() -> None:
    rec, calibrated = reconstructor(), Calibration.identity(PATCH, noise_std=0.01)
    of_counts = sf.Reconstructor(PATCH, calibration=calibrated, grid=GRID, solver=rec.solver)
    wrong: list[tuple[Any, str]] = [
        (lambda: sf.read(5), "path is 5, expected a str or a PathLike: of a layout"),
        (lambda: sf.read(None), "path is None, expected a str or a PathLike: of a layout"),
        (lambda: rec(READING).plot(truth=3), "truth is 3, expected an Iterable: of presses, each"),
        (lambda: rec(READING).plot(truth=[3]), "truth[0] is 3"),
        (lambda: rec(RUN).plot(truth=[]), "truth is given for 3 readings, expected it for one"),
    ]
    for each in (rec, of_counts):
        wrong += [
            (lambda each=each: each(None), "readings is None, expected numbers: nothing was"),
            (lambda each=each: each(recording()), "expected numbers: hand in its .counts"),
        ]
    for call, said in wrong:
        with pytest.raises(InputError, match=re.escape(said)):
            call()


def test_a_damaged_calibration_is_named_and_other_faults_are_not_hidden(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "mine.npz"
    save_calibration(Calibration.identity(PATCH, noise_std=0.01), path)
    data = bytearray(path.read_bytes())
    data[data.index("skin".encode("utf-32-le"))] ^= 1  # its sum no longer fits
    path.write_bytes(data)
    with pytest.raises(FileError, match=r"not an NPZ file that can be read: Bad CRC.*format\.npy"):
        sf.read(path)
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(FileError):
        sf.read(path)

    def broken(*words: Any) -> None:
        raise KeyError("a fault of the program")

    monkeypatch.setattr("zipfile.ZipFile.namelist", broken)
    save_recording(recording(), path)
    with pytest.raises(KeyError, match="a fault of the program"):
        sf.read(path)


def test_a_folder_has_its_name_wherever_one_stands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "robot" / "left").mkdir(parents=True)
    sf.save_layout(sf.Patch(PATCH.positions, name="palm"), tmp_path / "robot" / "hand.toml")
    monkeypatch.chdir(tmp_path / "robot" / "left")
    for path in ("..", tmp_path / "robot"):
        assert sf.read(path).name == "robot"
    monkeypatch.chdir(tmp_path / "robot")
    assert sf.read(".").name == "robot"


@pytest.mark.parametrize("made_by", ["skinfield-calibration 2", "skinfield_layout = 1"])
def test_a_table_that_names_our_formats_in_a_comment_is_read(tmp_path: Path, made_by: str) -> None:
    lines = "# unit = count", f"# source = made with {made_by}", "time_s,taxel_0", "0,1", "1,2"
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    assert sf.read(tmp_path / "a.csv").counts.tolist() == [[1.0], [2.0]]


def test_what_is_nothing_known_is_told_with_what_was_tried(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("Dear reader,\nthis is no recording.\n")
    (tmp_path / "letters").mkdir()
    with pytest.raises(FileError, match=r"layout .*calibration .*table of contacts.* recording"):
        sf.read(tmp_path / "letter.txt")
    with pytest.raises(FileError, match=r"expected results .*layouts.*yarpdatadumper"):
        sf.read(tmp_path / "letters")
    for name in ("nothing.csv", "a\0b"):
        with pytest.raises(FileError, match="expected a layout, a calibration"):
            sf.read(tmp_path / name)


def test_all_is_what_a_newcomer_needs_and_the_rest_is_there() -> None:
    assert len(sf.__all__) <= 26
    assert len(set(sf.__all__)) == len(sf.__all__)
    assert set(sf.__all__) <= set(sf._ON_DEMAND)
    assert [name for name in dir(sf) if not name.startswith("_")] == sorted(sf.__all__)
    for name in ("load_layout", "load_calibration", "open_results", "load_contacts", "HalfSpace"):
        assert callable(getattr(sf, name))


def test_errors_are_there_at_once() -> None:
    code = "import skinfield as sf; print(issubclass(sf.errors.FileError, sf.errors.InputError))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"


def test_the_version_is_known_without_an_installation(monkeypatch: pytest.MonkeyPatch) -> None:
    from importlib import metadata

    assert re.match(r"\d+(\.\d+)*", sf.__version__)

    def missing(name: str) -> str:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "version", missing)
    assert re.match(r"\d", sf._version())


@pytest.mark.parametrize("name", ["two_presses", "real_habits"])
def test_a_data_set_is_the_same_for_a_seed(name: str) -> None:
    first = sf.datasets.load(name)
    sf.datasets._made.cache_clear()
    np.testing.assert_array_equal(sf.datasets.load(name).recording.counts, first.recording.counts)
    assert len(first.force) == len(first.place) == len(first.recording)
    assert len(first._repr_html_()) < 60_000


def test_two_presses_read_as_the_simulator_says_at_their_peak() -> None:
    made = sf.datasets.load("two_presses")
    counts = made.recording.counts[made.peak - 5 : made.peak + 5]
    seen = made.calibration.relative_capacitance_from_counts(counts).mean(axis=0)
    balls = [
        sf.simulate.Sphere(radius=6e-3, position=(float(x), float(y)), force=force)
        for (x, y), force, _ in made.truth(made.peak)
    ]
    both = sf.simulate.press(made.layer, balls)  # together, not one by one
    expected = both.capacitance(made.patch.plane, made.patch.pad_diameter)
    np.testing.assert_allclose(seen, expected, atol=1.5e-3)
    assert np.ptp(expected) > 0.2


def test_other_data_sets_are_refused_with_the_names() -> None:
    with pytest.raises(InputError, match=r"two_presses"):
        sf.datasets.load("three_presses")
