"""Products on any device, by libraries that are at hand: on the host where there is no GPU."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from device_backends import BACKENDS, GRID, LAYER, PATCH, faded_in

import skinfield as sf
from skinfield.errors import InputError
from skinfield.pipeline import device_product
from skinfield.pipeline.array_backend import ArrayBackend
from skinfield.pipeline.batch import FEWEST, BulkProduct
from skinfield.pipeline.device_product import DeviceProduct, chunk_of


@pytest.fixture(params=BACKENDS)
def backend(request: pytest.FixtureRequest) -> ArrayBackend:
    return BACKENDS[request.param]()


@pytest.fixture(scope="module")
def readings() -> np.ndarray:
    return faded_in()


@pytest.mark.parametrize("precision", [np.float32, np.float64])
@pytest.mark.parametrize("count", [0, 1, 7, 8, 29])
def test_products_are_those_of_the_host(backend: ArrayBackend, precision: type, count: int) -> None:
    rng = np.random.default_rng(1)
    operator, table = rng.normal(size=(50, 12)), rng.normal(size=(count, 12))
    product = DeviceProduct(operator, backend, precision, chunk=7)
    found = product.fields(table)
    assert found.dtype == product.dtype == precision
    size = np.abs(table) @ np.abs(operator).T  # of the terms that a product adds up
    error = {np.float32: 1e-6, np.float64: 1e-14}[precision]
    assert (np.abs(found - table @ operator.T) <= error * size).all()
    there = backend.fetch(product.on_device(table))
    assert np.abs(there - found).max(initial=0.0) <= error * size.max(initial=1.0)


def test_it_stands_in_for_a_bulk_product(backend: ArrayBackend, readings: np.ndarray) -> None:
    operator = sf.Reconstructor(PATCH, LAYER, GRID, solver=sf.Tikhonov()).operator
    out = np.full((23, len(operator)), np.nan, dtype=np.float32)
    product = DeviceProduct(operator, backend)
    assert product.fields(readings, out) is out
    expected = BulkProduct(operator).fields(readings)
    for block in range(4):  # of other units
        rows = slice(block * len(GRID), (block + 1) * len(GRID))
        scale = np.abs(expected[:, rows]).max()
        assert np.abs(out[:, rows] - expected[:, rows]).max() < 3e-6 * scale


def test_wrong_shapes_are_named(backend: ArrayBackend) -> None:
    product = DeviceProduct(np.ones((5, 3)), backend)
    with pytest.raises(InputError, match=r"readings has shape \(2, 4\)"):
        product.fields(np.ones((2, 4)))
    with pytest.raises(InputError, match=r"out has shape \(2, 4\)"):
        product.fields(np.ones((2, 3)), np.ones((2, 4), np.float32))
    with pytest.raises(InputError, match="operator"):
        DeviceProduct(np.ones(5), backend)
    with pytest.raises(InputError, match="chunk"):
        DeviceProduct(np.ones((5, 3)), backend, chunk=0)


class Small(ArrayBackend):
    """A device that says how little memory it has, and keeps the order of copies."""

    free: int | None = 1000
    log: list[tuple[str, int]] = []  # noqa: RUF012

    @property
    def is_host(self) -> bool:
        return False

    def free_bytes(self) -> int | None:
        return self.free

    def begin_fetch(self, array: Any, slot: int) -> Any:
        self.log.append(("begin", slot))
        end = super().begin_fetch(array, slot)

        def ending() -> np.ndarray:
            self.log.append(("end", slot))
            return end()

        return ending


def test_chunks_fit_the_free_memory() -> None:
    small = Small(np)
    assert chunk_of(small, 10) * 10 * device_product.SLOTS <= 1000 * device_product.FREE_SHARE
    assert chunk_of(small, 250) == 1
    with pytest.raises(InputError, match="has 1000 bytes free, expected 1004"):
        chunk_of(small, 251)
    object.__setattr__(small, "free", None)
    assert chunk_of(small, 1024) == device_product.CHUNK_BYTES // 1024
    assert chunk_of(ArrayBackend.numpy(), 1 << 40) == FEWEST


def test_a_chunk_travels_while_the_next_is_computed() -> None:
    small = Small(np)
    small.log.clear()
    DeviceProduct(np.eye(3), small, chunk=2).fields(np.ones((5, 3)))
    assert small.log == [
        ("begin", 0),
        ("begin", 1),
        ("end", 0),
        ("begin", 0),
        ("end", 1),
        ("end", 0),
    ]


def test_numbers_go_there_and_back(backend: ArrayBackend) -> None:
    values = np.arange(12, dtype=np.float32).reshape(4, 3)
    values.setflags(write=False)
    assert np.array_equal(backend.fetch(backend.send(values)), values)
    assert np.array_equal(backend.begin_fetch(backend.send(values), 0)(), values)
    flags = values > 4
    assert np.array_equal(backend.fetch(backend.send(flags)), flags)
    free = backend.free_bytes()
    assert free is None if backend.is_host else free is None or free > 0


def test_the_page_runs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from test_readme import ROOT, follow

    monkeypatch.chdir(tmp_path)
    assert follow(ROOT / "docs" / "gpu.md") == (2, 0)
    printed = capsys.readouterr().out.splitlines()
    assert printed[0] == "(3000, 1600) True"
    assert printed[1].startswith("True True")
