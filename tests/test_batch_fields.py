"""Fields of many readings against the reconstructor; lazy results against both."""

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError
from skinfield.pipeline import batch, batch_fields, batch_results
from skinfield.pipeline.array_backend import ArrayBackend
from skinfield.pipeline.batch_fields import BulkFields
from skinfield.pipeline.batch_recipe import Recipe
from skinfield.pipeline.batch_results import LazyResults

PATCH = sf.layouts.hexagon72()
GRID = sf.Grid.square(PATCH, nodes=8)
RNG = np.random.default_rng(3)
SOLVERS = {
    "gaussian": sf.GaussianField(), "tikhonov": sf.Tikhonov(), "pseudo": sf.PseudoInverse(),
    "nonnegative": sf.NonNegative(),
}  # fmt: skip


def pressed(count: int) -> np.ndarray:
    """Readings of a bump that wanders, with noise."""
    place = PATCH.plane[30] + np.linspace(0, 8e-3, count)[:, None] * [1.0, 0.5]
    away = np.square(PATCH.plane[None] - place[:, None]).sum(axis=2)
    return 0.2 * np.exp(-away / (5e-3) ** 2) + RNG.normal(0, 0.002, (count, 72))


@pytest.fixture(scope="module", params=list(SOLVERS))
def reconstructor(request) -> sf.Reconstructor:
    return sf.Reconstructor(PATCH, grid=GRID, solver=SOLVERS[request.param])


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of some readings, so that few readings have several."""
    monkeypatch.setattr(batch, "CHUNK", 16)
    for module in (batch_fields, batch_results):
        monkeypatch.setattr(module, "RUN", 8)


def eager(reconstructor: sf.Reconstructor, readings: np.ndarray, run: int) -> list[sf.Estimate]:
    found = []
    for first in range(0, len(readings), run):
        reconstructor.reset()
        found.append(reconstructor(readings[first : first + run]))
    return found


def close(found, expected) -> None:
    assert found.shape == expected.shape
    scale = np.abs(expected).max()
    assert np.abs(found - expected).max() < 3e-6 * scale


@pytest.mark.parametrize("lack", ["nothing", "one", "any"])
@pytest.mark.parametrize("solver", ["gaussian", "pseudo"])
@pytest.mark.parametrize("library", ["numpy", "array_api_strict"])
def test_another_device_gives_the_same(library: str, solver: str, lack: str) -> None:
    backend = ArrayBackend(pytest.importorskip(library, reason="of the extra test"))
    rec = sf.Reconstructor(PATCH, grid=GRID, solver=SOLVERS[solver])
    readings = pressed(37)
    if lack == "one":
        readings[:, 31] = np.nan
    elif lack == "any":
        readings[RNG.random(readings.shape) < 0.03] = np.nan
    names = ("pressure", "displacement")
    found, expected = (BulkFields(rec, names, backend=on)(readings) for on in (backend, None))
    for name in names:
        close(found[name], expected[name])
    force = BulkFields(rec, "pressure", backend=backend).normal_force(readings)
    close(force, BulkFields(rec, "pressure").normal_force(readings))


def test_a_device_is_for_products_alone() -> None:
    rec = sf.Reconstructor(PATCH, grid=GRID, solver=SOLVERS["nonnegative"])
    with pytest.raises(InputError, match=r"solver is NonNegative\(\), expected a linear one"):
        BulkFields(rec, backend=ArrayBackend.numpy())


@pytest.mark.parametrize("lack", ["nothing", "one", "any"])
def test_bulk_fields_are_those_of_the_reconstructor(reconstructor, lack) -> None:
    readings = pressed(37)
    if lack == "one":
        readings[:, 31] = np.nan
    elif lack == "any":
        readings[9:12, 44] = np.nan
        readings[20, :5] = np.nan
        readings[5, [30, 31, 60]] = np.nan
    names = ("displacement", "pressure", "indentation")
    bulk = BulkFields(reconstructor, names)
    found = bulk(readings)
    estimates = eager(reconstructor, readings, 8 if bulk.run == 8 else 16)
    for name in names:
        assert found[name].dtype == np.float32
        close(found[name], np.concatenate([getattr(e, name) for e in estimates]))
    force = BulkFields(reconstructor, "pressure").normal_force(readings)
    expected = np.concatenate([e.normal_force for e in estimates])
    np.testing.assert_allclose(force, expected, atol=2e-6 * np.abs(expected).max())
    for one, other in zip(
        bulk.contacts(readings), [c for e in estimates for c in e.contacts], strict=True
    ):
        assert len(one) == len(other)
        for contact, expected in zip(one, other, strict=True):
            np.testing.assert_allclose(contact.force, expected.force, rtol=1e-7, atol=1e-9)
            np.testing.assert_allclose(contact.covariance, expected.covariance, rtol=1e-5)
    some = BulkFields(reconstructor, "pressure", np.float64)(readings)
    assert list(some) == ["pressure"]
    np.testing.assert_allclose(
        some["pressure"], np.concatenate([e.pressure for e in estimates]), rtol=1e-7, atol=1e-3
    )


class Kept:
    def __init__(self, readings: np.ndarray) -> None:
        self.readings = readings

    def __len__(self) -> int:
        return len(self.readings)

    def stamps(self, first, last):
        return 10**9 + 20_000_000 * np.arange(first, last)

    def values(self, first, last):
        return self.readings[first:last]


@pytest.fixture(scope="module")
def held() -> np.ndarray:
    readings = pressed(37)
    readings[3, 7] = np.nan
    return readings


def test_lazy_results_are_those_of_the_reconstructor(reconstructor, held) -> None:
    results = LazyResults(Recipe.of(reconstructor), Kept(held))
    run = 8 if results.pressure.chunk == 8 else 16
    whole = eager(reconstructor, held, run)
    for name in ("pressure", "indentation", "displacement"):
        expected = np.concatenate([getattr(e, name) for e in whole])
        lazy = getattr(results, name)
        assert (lazy.shape, lazy.dtype) == (expected.shape, np.float32)
        close(lazy[:], expected)
        for index in (-1, slice(30, 4, -7), [20, 3, 3], (slice(5, 30), 17), np.arange(37) % 9 == 0):
            np.testing.assert_array_equal(lazy[index], np.asarray(lazy)[index])
    force = np.concatenate([np.atleast_1d(e.normal_force) for e in whole])
    close(results.normal_force[:], force)
    contacts = [each for e in whole for each in e.contacts]
    assert len(results.contacts) == 37
    for found, expected in zip(results.contacts, contacts, strict=True):
        assert len(found) == len(expected)
        for one, other in zip(found, expected, strict=True):
            np.testing.assert_allclose(one.position, other.position, atol=1e-9)
            assert one.normal_force == pytest.approx(other.normal_force, rel=1e-6)
    np.testing.assert_array_equal(results.readings[:], held)
    np.testing.assert_array_equal(results.stamp_ns[:], Kept(held).stamps(0, 37))


def test_what_a_reading_gives_does_not_depend_on_how_it_is_asked_for(reconstructor, held) -> None:
    recipe, kept = Recipe.of(reconstructor), Kept(held)
    whole = LazyResults(recipe, kept).pressure[:]
    for cache in (1, 1 << 20):
        results = LazyResults(recipe, kept, cache_bytes=cache)
        for row in (36, 9, 8, 7, 20, 9):
            np.testing.assert_array_equal(results.pressure[row], whole[row])


def test_one_estimate_and_blocks(reconstructor, held) -> None:
    results = LazyResults(Recipe.of(reconstructor), Kept(held))
    reconstructor.reset()
    expected = reconstructor(held[20])
    found = results.estimate(20)
    np.testing.assert_array_equal(found.pressure, expected.pressure)
    assert found.stamp_ns == 10**9 + 400_000_000
    blocks = list(results.blocks("pressure", "stamp_ns", rows=10))
    assert [where.stop - where.start for where, _ in blocks] == [10, 10, 10, 7]
    together = np.concatenate([fields["pressure"] for _, fields in blocks])
    np.testing.assert_array_equal(together, results.pressure[:])
    with pytest.raises(
        InputError, match=r"reading is 1\.5, expected a whole number from -37 to 36"
    ):
        results.estimate(1.5)
    with pytest.raises(InputError, match="reading is 37, expected a whole number from -37 to 36"):
        results.estimate(37)


def test_the_same_readings_by_another_solver(held) -> None:
    results = LazyResults(Recipe.of(sf.Reconstructor(PATCH, grid=GRID)), Kept(held))
    other = results.using(solver=sf.Tikhonov(), grid=sf.Grid.square(PATCH, nodes=5))
    expected = sf.Reconstructor(
        PATCH, grid=sf.Grid.square(PATCH, nodes=5), solver=sf.Tikhonov()
    )(held)  # fmt: skip
    close(other.pressure[:], expected.pressure)
    with pytest.raises(sf.errors.InputError, match="part is 'patch'"):
        results.using(patch=PATCH)


def test_xarray_computes_what_it_is_asked_for(held) -> None:
    pytest.importorskip("xarray")
    results = LazyResults(Recipe.of(sf.Reconstructor(PATCH, grid=GRID)), Kept(held))
    data = results.to_xarray()
    assert not results._cache._chunks or len(results._cache._chunks) == 1  # the stamps alone
    assert dict(data.sizes) == {"reading": 37, "row": 8, "column": 8, "axis": 3}
    whole = results.pressure[:].reshape(37, 8, 8)
    moved = results.displacement[:].reshape(37, 8, 8, 3)
    np.testing.assert_array_equal(data.pressure.isel(reading=5).values, whole[5])
    np.testing.assert_array_equal(data.pressure[::-3, 2].values, whole[::-3, 2])
    np.testing.assert_array_equal(
        data.displacement.isel(reading=[9, 1], row=[0, 5], axis=2).values,
        moved[[9, 1]][:, [0, 5]][..., 2],
    )
    np.testing.assert_array_equal(
        data.displacement.isel(reading=3, column=[1, 0, 1]).values, moved[3][:, [1, 0, 1]]
    )
    np.testing.assert_allclose(data.pressure.mean("reading").values, whole.mean(axis=0), rtol=1e-5)
    assert data.pressure.attrs["units"] == "Pa"
    assert float(data.stamp[1] - data.stamp[0]) == 20_000_000
