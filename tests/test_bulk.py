"""Fields and contacts of many readings against the reconstructor's own."""

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError
from skinfield.reconstruct import bulk as bulk_module
from skinfield.reconstruct.bulk import BulkFields

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
    for name, value in (("CHUNK", 16), ("FEWEST", 16), ("RUN", 8), ("WARM", 3)):
        monkeypatch.setattr(bulk_module, name, value)


def eager(reconstructor: sf.Reconstructor, readings: np.ndarray, run: int) -> list[sf.Estimate]:
    found = []
    for first in range(0, len(readings), run):
        reconstructor.reset()
        start = max(first - 3, 0)  # warm
        found += list(reconstructor(readings[start : first + run]))[first - start :]
    return found


def close(found, expected) -> None:
    assert found.shape == expected.shape
    scale = np.abs(expected).max()
    assert np.abs(found - expected).max() < 3e-6 * scale


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
    estimates = eager(reconstructor, readings, 8)
    for name in names:
        assert found[name].dtype == np.float32
        close(found[name], np.stack([getattr(e, name) for e in estimates]))
    stamps = np.arange(37) * 20_000_000
    later = bulk.estimate(readings, stamps, skip=8)
    for name in ("pressure", "displacement", "pressure_std"):
        close(getattr(later, name), np.stack([getattr(e, name) for e in estimates])[8:])
    for one, other in zip(later.contacts, [e.contacts for e in estimates][8:], strict=True):
        assert len(one) == len(other)
        for contact, expected in zip(one, other, strict=True):
            np.testing.assert_array_equal(contact.force, expected.force)
            np.testing.assert_array_equal(contact.covariance, expected.covariance)
    some = BulkFields(reconstructor, "pressure", np.float64)(readings)
    assert list(some) == ["pressure"]
    alone = BulkFields(reconstructor, "pressure")(readings)["pressure"]
    np.testing.assert_array_equal(alone, found["pressure"])  # whatever else is wanted
    np.testing.assert_allclose(
        some["pressure"], np.stack([e.pressure for e in estimates]), rtol=1e-7, atol=1e-3
    )


def test_outputs_that_make_no_sense_are_refused() -> None:
    rec = sf.Reconstructor(PATCH, grid=GRID)
    for outputs, said in [
        ((), "expected one name or more"),
        (("pressure", "pressure"), "each once"),
        (("force",), "outputs is 'force'"),
    ]:
        with pytest.raises(InputError, match=said):
            BulkFields(rec, outputs)
