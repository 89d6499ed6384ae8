"""Folders of results: what comes back, lazily, and what becomes of damaged ones."""

import json
import pickle
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import FileError, InputError, SkinfieldError
from skinfield.files import ResultsWriter, load_contacts, open_results, save_results
from skinfield.files import results as results_module
from skinfield.files.pending import pending
from skinfield.files.results import read_results
from skinfield.reconstruct.serialisation import (
    ReconstructorConfig,
    attributes_from_results,
    checksum,
)

for package in ("dask", "xarray", "zarr", "pyarrow"):
    pytest.importorskip(package, reason="of the extra batch")

PATCH = sf.layouts.hexagon72()
GRID = sf.Grid.square(PATCH, nodes=8)
RNG = np.random.default_rng(8)
SOLVERS = [sf.GaussianField(), sf.Tikhonov(), sf.PseudoInverse(), sf.Inverse(), sf.NonNegative()]
PRESSED = {"pressure": "Pa", "normal_force": "N"}
COUNT = 200
READINGS = RNG.normal(0.01, 0.01, (COUNT, 72))
READINGS[60:140, 30] += 0.1
READINGS[7, 3] = np.nan
STAMPS = 1_700_000_000_123_456_789 + 20_000_000 * np.arange(COUNT)


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of 64 readings, so that there are several."""
    monkeypatch.setattr(results_module, "RUN", 64)
    monkeypatch.setattr(results_module, "WARM", 0)


@pytest.mark.parametrize(
    ("solver", "quantity"),
    [(each, sf.Capacitance()) for each in SOLVERS]
    + [(SOLVERS[0], sf.BaseStress()), (SOLVERS[0], sf.Gap())],
    ids=lambda each: type(each).__name__,
)
def test_results_are_those_of_the_reconstructor(solver, quantity, tmp_path: Path) -> None:
    relative = isinstance(solver, sf.Tikhonov)
    made = sf.Reconstructor(PATCH, grid=GRID, solver=solver, quantity=quantity, relative=relative)
    readings = READINGS * (1e5 if isinstance(quantity, sf.BaseStress) else 1.0)
    path = tmp_path / "run.skinfield"
    save_results(path, made, readings, STAMPS, notes=("one", "two"), source="here")
    results = sf.open_results(path, precision=np.float64)
    assert dict(results.sizes) == {"reading": COUNT, "row": 8, "column": 8, "axis": 3, "taxel": 72}
    assert len(results.pressure.chunks[0]) == 4
    np.testing.assert_array_equal(results.readings, readings)
    np.testing.assert_array_equal(results.stamp, STAMPS)
    assert (results.attrs["notes"], results.attrs["source"]) == (["one", "two"], "here")
    units = {name: results[name].attrs["units"] for name in results.data_vars}
    lengths = {"indentation": "m", "displacement": "m"}
    pressed = {name: "relative" if relative else its for name, its in PRESSED.items()}
    assert units == {**pressed, **lengths, "readings": quantity.unit}
    estimates = []
    for first in range(0, COUNT, 64):  # a run of an iterative solver each
        made.reset()
        estimates.append(made(readings[first : first + 64]))
    for name in ("pressure", "indentation", "displacement"):
        expected = np.concatenate([getattr(each, name) for each in estimates])
        found = results[name].to_numpy().reshape(expected.shape)
        assert np.abs(found - expected).max() <= 1e-9 * np.abs(expected).max()
    force = np.concatenate([each.normal_force for each in estimates])
    np.testing.assert_allclose(results.normal_force, force, rtol=1e-9, atol=1e-9)
    table = load_contacts(path, slice(100, 131)).to_pylist()
    contacts = [c for each in estimates for c in each.contacts][100:131]
    assert [row["reading"] for row in table] == [
        100 + k for k, each in enumerate(contacts) for _ in range(max(len(each), 1))
    ]
    for k in (0, 30):
        load = sum(row["force_N"] or 0 for row in table if row["reading"] == 100 + k)
        assert load == pytest.approx(sum(c.normal_force for c in contacts[k]), rel=1e-6)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("results") / "run.skinfield"
    save_results(path, sf.Reconstructor(PATCH, grid=GRID, solver=SOLVERS[0]), READINGS, STAMPS)
    return path


def test_a_slice_computes_its_chunks_alone(good: Path, monkeypatch) -> None:
    spans = []
    original = results_module.Results.fields

    def fields(self, first, last, **how):
        spans.append((first, last))
        return original(self, first, last, **how)

    monkeypatch.setattr(results_module.Results, "fields", fields)
    results = open_results(good)
    assert not spans
    whole = results.pressure.to_numpy()
    assert sorted(spans) == [(0, 64), (64, 128), (128, 192), (192, 200)]
    spans.clear()
    np.testing.assert_array_equal(results.pressure[70], whole[70])
    np.testing.assert_array_equal(
        results.pressure[100:66:-7, 2, [1, 5]], whole[100:66:-7, 2, [1, 5]]
    )
    assert set(spans) == {(64, 128)}
    after = results.isel(reading=results.stamp > STAMPS[150])
    np.testing.assert_array_equal(after.pressure, whole[151:])
    other = pickle.loads(pickle.dumps(results))  # as for another process
    np.testing.assert_array_equal(other.displacement[5:9], results.displacement[5:9])
    force = (results.pressure.sum(("row", "column")) * results.attrs["cell_area_m2"]).to_numpy()
    np.testing.assert_allclose(force, results.normal_force, rtol=1e-4, atol=1e-4)


def test_the_same_readings_by_another_solver_on_another_grid(good: Path) -> None:
    grid = sf.Grid.square(PATCH, nodes=5)
    other = open_results(good, solver=sf.NonNegative(), grid=grid)
    expected = sf.Reconstructor(PATCH, grid=grid, solver=sf.NonNegative())(READINGS[:64])
    found = other.pressure[:64].to_numpy().reshape(64, -1)
    assert np.abs(found - expected.pressure).max() < 1e-5 * expected.pressure.max()


def test_a_failure_leaves_what_was_there(tmp_path: Path) -> None:
    made = sf.Reconstructor(PATCH, grid=GRID, solver=SOLVERS[0])
    path = tmp_path / "run.skinfield"
    save_results(path, made, READINGS)
    np.testing.assert_array_equal(open_results(path).stamp, np.arange(COUNT))
    for count in (COUNT, 0):
        writer = ResultsWriter(pending(path), ReconstructorConfig.of(made))
        writer.write(STAMPS[:count], READINGS[:count])
        if not count:
            with pytest.raises(InputError, match="no reading was written"):
                writer.close()
        writer.place.discard()
    assert [p.name for p in tmp_path.iterdir()] == ["run.skinfield"]
    save_results(path, made, READINGS[:1])  # replaces what was there; its stamp is 0
    assert open_results(path).sizes["reading"] == 1
    (tmp_path / "my.skinfield" / "own").mkdir(parents=True)
    beyond = np.array([0, 2**63], dtype=np.uint64)
    for words, said in [
        ((tmp_path / "my.skinfield", made, READINGS), "expected a new name"),
        ((tmp_path / "run.npz", made, READINGS), "expected a name that ends in"),
        ((path, made, READINGS, STAMPS[:3]), "stamp_ns has shape"),
        ((path, made, READINGS[:2], beyond), "stamp_ns reaches 9223372036854775808, expected"),
        ((path, sf.Reconstructor(PATCH, grid=GRID, solver=Own()), READINGS), "solver is a Own"),
    ]:
        with pytest.raises(InputError, match=said):
            save_results(*words)
    assert open_results(path).sizes["reading"] == 1


class Own:
    def prepare(self, model):
        return sf.Tikhonov().prepare(model)


def read_all(path: Path) -> None:
    results = read_results(path)
    results.stamps(0, COUNT)
    results.values(0, COUNT)


@pytest.mark.parametrize("kind", ["flip", "cut", "gone", "garbage"])
def test_no_damage_goes_unnoticed(good: Path, tmp_path: Path, kind: str) -> None:
    rng = np.random.default_rng(0)
    path = tmp_path / "damaged.skinfield"
    shutil.copytree(good, path)
    for place in sorted(file for file in path.rglob("*") if file.is_file()):
        if place.parent.name != "results.zarr" and place.name == "zarr.json" and kind == "flip":
            continue  # a letter in a unit's name: nothing that is read
        whole = place.read_bytes()
        flipped = bytearray(whole)
        flipped[rng.integers(len(whole))] ^= 1
        made = {"flip": flipped, "cut": whole[: len(whole) // 2], "garbage": rng.bytes(300)}
        if kind == "gone":
            place.unlink()
        else:
            place.write_bytes(made[kind])
        with pytest.raises(FileError):
            read_all(path)
        place.write_bytes(whole)


def resealed(good: Path, path: Path, change) -> Path:
    """A folder whose settings are changed on purpose, checksum and all."""
    shutil.copytree(good, path)
    file = path / "results.zarr" / "zarr.json"
    whole = json.loads(file.read_text())
    attributes = whole["attributes"]
    change(attributes)
    content = {name: attributes.get(name) for name in ("reconstructor", "notes", "source")}
    attributes["check"] = checksum(content)
    file.write_text(json.dumps(whole))
    return path


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda a: a.update(format="other"), "does not say 'skinfield results'"),
        (lambda a: a.update(version=99), "is of version 99, expected 2"),
        (lambda a: a.pop("reconstructor"), "holds no reconstructor"),
        (lambda a: a["reconstructor"].pop("solver"), "settings lack solver"),
        (lambda a: a["reconstructor"].update(grid=[[0, 1]]), "grid is"),
        (lambda a: a["reconstructor"].update(patch=None), "patch is a"),
        (lambda a: a.update(notes=3), "and notes"),
    ],
)
def test_settings_that_make_no_sense_are_refused(good: Path, tmp_path: Path, change, said) -> None:
    with pytest.raises(FileError, match=said):
        open_results(resealed(good, tmp_path / "odd.skinfield", change))


def test_edited_settings_and_other_readings_are_refused(good: Path, tmp_path: Path) -> None:
    path = resealed(good, tmp_path / "edited.skinfield", lambda a: None)
    file = path / "results.zarr" / "zarr.json"
    file.write_text(file.read_text().replace('"snr": 10.0', '"snr": 11.0'))
    with pytest.raises(FileError, match="its checksum differs"):
        open_results(path)
    small = ReconstructorConfig.of(sf.Reconstructor(sf.layouts.icub_triangle()))
    other = attributes_from_results(small, (), "")
    path = resealed(good, tmp_path / "other.skinfield", lambda a: a.update(other))
    with pytest.raises(FileError, match="expected one or more of 12 taxels"):
        open_results(path)


@pytest.mark.parametrize("name", ["gone", "file", "empty", "a\0b"])
def test_what_is_no_result_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_text("hello")
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileError):
        open_results(tmp_path / name)


@pytest.mark.parametrize("package", ["xarray", "dask.array"])
def test_a_missing_package_names_its_extra(good: Path, package: str, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(SkinfieldError, match=r"pip install 'skinfield\[batch\]'"):
        open_results(good)


def test_where_taxels_rest_goes_on_from_run_to_run(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(results_module, "WARM", 32)
    rng, readings = np.random.default_rng(4), 12 * results_module.RUN
    drift = np.linspace(0.0, 1.0, readings)[:, None] * rng.normal(0.0, 8e-3, len(PATCH))
    values = drift + rng.normal(0.0, 0.002, drift.shape)
    stamps = (np.arange(readings) + 1) * 200_000_000
    made = sf.Reconstructor(PATCH, sf.Layer(), sf.Grid.square(PATCH, nodes=12), noise_std=0.002)
    save_results(tmp_path / "drift.skinfield", made, values, stamps)
    results = read_results(tmp_path / "drift.skinfield")
    found = [len(each) for each in results.estimates(0, readings).contacts]
    assert np.mean(found) < 0.02
    late = [len(each) for each in results.estimates(readings - 40, readings).contacts]
    assert late == found[-40:]
    alone = made(values[-256:], stamp_ns=stamps[-256:])
    assert np.mean([len(each) for each in alone.contacts]) > 0.5  # what would be without
