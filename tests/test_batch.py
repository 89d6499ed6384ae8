"""Bulk products against the reconstructor, reading by reading."""

import numpy as np
import pytest

import skinfield as sf
from skinfield.pipeline.batch import BulkProduct, readings_per_product, rows_of

PATCH = sf.layouts.hexagon72()
GRID = sf.Grid.square(PATCH, nodes=8)
RNG = np.random.default_rng(3)
READINGS = RNG.normal(0.01, 0.01, (37, 72))


@pytest.fixture(scope="module")
def linear() -> sf.Reconstructor:
    return sf.Reconstructor(PATCH, grid=GRID, quantity=sf.Gap())  # a gap is linear as it is


@pytest.mark.parametrize(("precision", "error"), [(np.float32, 2e-6), (np.float64, 1e-13)])
@pytest.mark.parametrize("chunk", [1, 5, 37, 64])
def test_products_are_those_of_single_readings(linear, precision, error, chunk) -> None:
    product = BulkProduct(linear.operator, precision, chunk)
    found = product.fields(READINGS)
    assert found.dtype == precision
    one = np.empty(4 * len(GRID))
    for reading, row in zip(READINGS, found, strict=True):
        linear.apply(reading, one)
        for part in np.split(np.arange(len(one)), 4):
            scale = np.abs(linear.operator[part] * reading).sum(axis=1).max()
            assert np.abs(row[part] - one[part]).max() < error * scale


def test_outputs_are_those_of_an_estimate(linear) -> None:
    estimate = linear(READINGS)
    names = ("indentation", "pressure", "displacement")
    rows = rows_of(linear.operator, linear.grid, names)
    found = BulkProduct(rows, np.float64).fields(READINGS)
    nodes = len(GRID)
    np.testing.assert_allclose(found[:, :nodes], estimate.indentation, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(found[:, nodes : 2 * nodes], estimate.pressure, rtol=1e-9)
    moved = found[:, 2 * nodes :].reshape(-1, nodes, 3)
    np.testing.assert_allclose(moved, estimate.displacement, rtol=1e-9, atol=1e-15)


def test_outputs_on_a_curved_patch_go_along_its_normals() -> None:
    curved = sf.layouts.cylinder(radius=30e-3, length=15e-3, arc_angle=1.0)
    reconstructor = sf.Reconstructor(
        curved, grid=sf.Grid.square(curved, nodes=6), quantity=sf.Gap(), solver=sf.Tikhonov()
    )
    readings = RNG.normal(0.01, 0.01, (4, len(curved)))
    rows = rows_of(reconstructor.operator, reconstructor.grid, "indentation")
    found = BulkProduct(rows, np.float64).fields(readings)
    np.testing.assert_allclose(found, reconstructor(readings).indentation, rtol=1e-9, atol=1e-15)


def test_what_is_no_product_is_refused(linear) -> None:
    product = BulkProduct(linear.operator)
    with pytest.raises(sf.errors.InputError, match=r"readings has shape \(3, 71\), expected"):
        product.fields(np.zeros((3, 71)))
    with pytest.raises(sf.errors.InputError, match="outputs is 'force', expected one of"):
        rows_of(linear.operator, linear.grid, ["force"])
    with pytest.raises(sf.errors.InputError, match=r"outputs is \(\), expected one name"):
        rows_of(linear.operator, linear.grid, [])
    with pytest.raises(sf.errors.InputError, match="chunk is 0, expected"):
        BulkProduct(linear.operator, chunk=0)


def test_outputs_of_a_product_stay_in_the_cache() -> None:
    sizes = [readings_per_product(4 * width) for width in (1, 1600, 3200, 6400, 12800, 10**7)]
    assert sizes == [512, 512, 256, 128, 64, 64]
