"""Files of results: what comes back, and what becomes of damaged ones."""

import json
import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import skinfield as sf
from skinfield.conditioning import Calibration, ICubByte
from skinfield.errors import FileError, InputError
from skinfield.pipeline import batch_format
from skinfield.pipeline.batch_format import Extent, narrowed, widened
from skinfield.pipeline.batch_recipe import Recipe
from skinfield.pipeline.conditioner import Conditioner
from skinfield.sinks import open_results_file, save_results
from skinfield.sources import open_results

PATCH = sf.layouts.hexagon72()
GRID = sf.Grid.square(PATCH, nodes=8)
RNG = np.random.default_rng(8)
SOLVERS = {
    "gaussian": sf.GaussianField(), "tikhonov": sf.Tikhonov(), "pseudo": sf.PseudoInverse(),
    "inverse": sf.Inverse(), "nonnegative": sf.NonNegative(),
}  # fmt: skip
READINGS = RNG.normal(0.01, 0.01, (50, 72))
READINGS[7, 3] = np.nan
STAMPS = 1_700_000_000_123_456_789 + 20_000_000 * np.arange(50)


@pytest.mark.parametrize(
    ("solver", "quantity"),
    [(name, sf.Capacitance()) for name in SOLVERS]
    + [("gaussian", sf.BaseStress()), ("gaussian", sf.Gap())],
    ids=str,
)
def test_results_are_those_of_the_reconstructor(solver, quantity, tmp_path: Path) -> None:
    made = sf.Reconstructor(PATCH, grid=GRID, solver=SOLVERS[solver], quantity=quantity)
    scale = 1e5 if isinstance(quantity, sf.BaseStress) else 1.0
    save_results(tmp_path / "run.skinfield", made, scale * READINGS, STAMPS, exact=True,
                 notes=("one", "two"), source="here")  # fmt: skip
    results = sf.open_results(tmp_path / "run.skinfield", precision=np.float64)
    np.testing.assert_array_equal(results.readings[:], scale * READINGS)
    np.testing.assert_array_equal(results.stamp_ns[:], STAMPS)
    assert (results.notes, results.source, len(results)) == (("one", "two"), "here", 50)
    made.reset()
    estimate = made(scale * READINGS[:50])
    for name in ("pressure", "indentation", "displacement"):
        expected = getattr(estimate, name)
        found = getattr(results, name)[:]
        assert found.shape == expected.shape
        assert np.abs(found - expected).max() <= 1e-9 * np.abs(expected).max()
    assert results.recipe.solver == SOLVERS[solver]


def test_single_precision_is_taken_where_it_rounds_far_below_the_noise(tmp_path: Path) -> None:
    made = sf.Reconstructor(PATCH, grid=GRID)
    save_results(tmp_path / "a.skinfield", made, READINGS)
    save_results(tmp_path / "b.skinfield", made, READINGS, exact=True)
    single, double = (np.load(tmp_path / f"{n}.skinfield" / "readings.npy") for n in "ab")
    assert (single.dtype, double.dtype) == (np.float32, np.float64)
    np.testing.assert_array_equal(double, READINGS)
    assert np.nanmax(np.abs(single - READINGS)) < 1e-3 * 0.002
    np.testing.assert_array_equal(open_results(tmp_path / "a.skinfield").stamp_ns[:], np.arange(50))


def test_counts_stay_counts_and_become_the_same_readings(tmp_path: Path) -> None:
    counts = RNG.integers(100, 241, (9000, 72)).astype(float)
    counts[5, 6], counts[8, 9] = np.nan, 255.0  # absent; at a clamp
    calibration = Calibration.from_convention(PATCH, ICubByte(), gain=-171.0, noise_std=0.6)
    conditioner = Conditioner(sf.Gap(), sf.Layer(), calibration, ICubByte())
    extent = Extent()
    for part in np.array_split(counts, 7):
        extent.add(part)
    assert extent.kind() == np.dtype("<i2")  # 255 is a count, so no byte is left for absent ones
    recipe = Recipe.of(sf.Reconstructor(PATCH, grid=GRID, quantity=sf.Gap(), noise_std=0.004))
    path = tmp_path / "run.skinfield"
    with open_results_file(path, recipe, extent.kind(), conditioner=conditioner) as writer:
        for part in np.array_split(np.arange(9000), 7):
            writer.write(part * 1_000_000, counts[part])
    results = open_results(path)
    np.testing.assert_array_equal(results.kept.recorded(0, 9000), counts)
    np.testing.assert_array_equal(results.readings[:], conditioner(counts))
    np.testing.assert_array_equal(results.readings[5000:3:-999], conditioner(counts)[5000:3:-999])
    assert np.isnan(results.readings[8, 9])
    assert (path / "readings.npy").stat().st_size == 128 + 9000 * 72 * 2
    assert results.stamp_ns[8999] == 8_999_000_000
    again = pickle.loads(pickle.dumps(results.kept))
    np.testing.assert_array_equal(again.values(4000, 4200), conditioner(counts)[4000:4200])


def test_results_and_their_arrays_can_be_pickled(tmp_path: Path, monkeypatch) -> None:
    made = sf.Reconstructor(PATCH, grid=GRID)
    monkeypatch.chdir(tmp_path)
    save_results("run.skinfield", made, READINGS, STAMPS, notes=("one",))
    results = open_results("run.skinfield", precision=np.float64)
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / "other")
    results.pressure[3]
    text = pickle.dumps(results.pressure)
    assert len(text) < 60_000
    pressure, again = pickle.loads(text), pickle.loads(pickle.dumps(results))
    np.testing.assert_array_equal(pressure[:], results.pressure[:])
    np.testing.assert_array_equal(again.displacement[5:9], results.displacement[5:9])
    assert again.notes == ("one",)
    with pytest.raises(TypeError, match="cannot be pickled"):
        pickle.dumps(results.stamp_ns)


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        ([0, 254], "u1"), ([0, 255], "<i2"), ([-1, 32766], "<i2"), ([0, 32767], "<u2"),
        ([0, 65535], "<i4"), ([-1, 2**31 - 2], "<i4"), ([0, 2**31], "<f4"), ([0, 2**31 + 1], "<f8"),
        ([0.5, 3], "<f4"), ([0.1, 3], "<f8"), ([np.nan, 3], "u1"), ([np.nan, np.nan], "<f4"),
    ],
)  # fmt: skip
def test_the_narrowest_type_is_found_and_loses_nothing(values, kind) -> None:
    table = np.array([values, values], float)
    extent = Extent()
    extent.add(table)
    assert extent.kind() == np.dtype(kind)
    np.testing.assert_array_equal(widened(narrowed(table, extent.kind())), table)


@given(st.lists(st.floats(-1e9, 1e9) | st.integers(-70000, 70000) | st.just(np.nan), min_size=1))
def test_whatever_the_numbers_nothing_is_lost(values) -> None:
    table = np.array(values, float)[None]
    extent = Extent()
    extent.add(table)
    np.testing.assert_array_equal(widened(narrowed(table, extent.kind())), table)


def test_a_failure_leaves_what_was_there(tmp_path: Path) -> None:
    made = sf.Reconstructor(PATCH, grid=GRID)
    path = tmp_path / "run.skinfield"
    save_results(path, made, READINGS)
    writer = open_results_file(path, Recipe.of(made), np.dtype("<f4"))
    writer.write(STAMPS, READINGS)
    writer.discard()
    with pytest.raises(InputError, match="no reading was written"):
        open_results_file(path, Recipe.of(made), np.dtype("<f4")).close()
    assert [p.name for p in tmp_path.iterdir()] == ["run.skinfield"]
    assert len(open_results(path)) == 50
    save_results(path, made, READINGS[:9])  # replaces what was there
    assert len(open_results(path)) == 9
    other = tmp_path / "other.skinfield"
    other.mkdir()
    (other / "mine.txt").write_text("keep")
    with pytest.raises(FileError, match="expected a new name"):
        save_results(other, made, READINGS)
    with pytest.raises(InputError, match="expected a name that ends in"):
        save_results(tmp_path / "run.npz", made, READINGS)
    with pytest.raises(InputError, match="stamp_ns has shape"):
        save_results(path, made, READINGS, STAMPS[:3])


class Own:
    def prepare(self, model):
        return sf.Tikhonov().prepare(model)


def test_a_solver_of_ones_own_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    made = sf.Reconstructor(PATCH, grid=GRID, solver=Own())
    with pytest.raises(InputError, match="solver is a Own, which results cannot hold"):
        save_results(tmp_path / "run.skinfield", made, READINGS)
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("results") / "run.skinfield"
    save_results(path, sf.Reconstructor(PATCH, grid=GRID), READINGS, STAMPS)
    return path


def read_all(path: Path) -> None:
    results = open_results(path)
    np.testing.assert_array_equal(results.stamp_ns[:], STAMPS)
    np.testing.assert_array_equal(results.readings[:], READINGS.astype(np.float32))


@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.data())
def test_no_damage_goes_unseen(good: Path, tmp_path: Path, data) -> None:
    path = tmp_path / "bad.skinfield"
    shutil.rmtree(path, ignore_errors=True)
    shutil.copytree(good, path)
    file = path / data.draw(st.sampled_from(["settings.json", "stamp_ns.npy", "readings.npy"]))
    content = bytearray(file.read_bytes())
    kind = data.draw(st.sampled_from(["flip", "cut", "grow", "gone", "garbage"]))
    place = data.draw(st.integers(0, len(content) - 1))
    if kind == "flip":
        content[place] ^= data.draw(st.integers(1, 255))
    elif kind == "cut":
        del content[place:]
    elif kind == "grow":
        content += data.draw(st.binary(min_size=1, max_size=9))
    elif kind == "garbage":
        content = bytearray(data.draw(st.binary(max_size=300)))
    file.write_bytes(content)
    if kind == "gone":
        file.unlink()
    try:
        read_all(path)
    except FileError:
        return
    text = file.read_bytes()
    assert file.name == "settings.json" or text == (good / file.name).read_bytes() or (
        file.name.endswith("npy") and text[128:] == (good / file.name).read_bytes()[128:]
    )  # fmt: skip


def test_settings_that_were_edited_are_named_as_such(good: Path, tmp_path: Path) -> None:
    path = tmp_path / "edited.skinfield"
    shutil.copytree(good, path)
    whole = json.loads((path / "settings.json").read_text())
    whole["content"]["recipe"]["solver"]["snr"] = 11.0
    (path / "settings.json").write_text(json.dumps(whole))
    with pytest.raises(FileError, match="its sum differs"):
        open_results(path)
    whole["version"] = 99
    (path / "settings.json").write_text(json.dumps(whole))
    with pytest.raises(FileError, match="is of version 99, expected 1"):
        open_results(path)


def resealed(good: Path, path: Path, change) -> Path:
    """A folder whose settings are changed on purpose, sum and all."""
    shutil.copytree(good, path)
    whole = json.loads((path / "settings.json").read_text())
    change(whole["content"])
    (path / "settings.json").write_text(batch_format.text_from_content(whole["content"]))
    return path


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda c: c.pop("recipe"), "lacks or misplaces"),
        (lambda c: c["recipe"].pop("solver"), "settings lack solver"),
        (lambda c: c.update(recipe=3), "lacks or misplaces"),
        (lambda c: c.update(readings=51), "expected <i8"),
        (lambda c: c.update(readings="many"), "has 'many' readings"),
        (lambda c: c.update(taxels=71), "of 71 taxels"),
        (lambda c: c.update(type="|O"), "of 72 taxels of type"),
        (lambda c: c["sums"].update({"readings.npy": []}), "has no 1 sums"),
        (lambda c: c["recipe"].update(grid=[[0, 1]]), "grid is"),
        (lambda c: c["recipe"].update(patch=None), "patch is a"),
    ],
)
def test_settings_that_make_no_sense_are_refused(good: Path, tmp_path: Path, change, said) -> None:
    with pytest.raises(FileError, match=said):
        open_results(resealed(good, tmp_path / "odd.skinfield", change))


@pytest.mark.parametrize("name", ["gone", "file", "empty", "a\0b"])
def test_what_is_no_result_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_text("hello")
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileError):
        open_results(tmp_path / name)


def test_times_beyond_what_a_file_holds_are_refused(tmp_path: Path) -> None:
    rec = sf.Reconstructor(PATCH, grid=GRID)
    stamps = np.array([0, 2**63], dtype=np.uint64)
    with pytest.raises(InputError, match=r"stamp_ns reaches 9223372036854775808, expected"):
        save_results(tmp_path / "a.skinfield", rec, READINGS[:2], stamp_ns=stamps)
    assert not list(tmp_path.iterdir())
