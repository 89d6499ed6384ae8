"""Devices by name, and copies to and from them."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from device_backends import torch

from skinfield.errors import InputError
from skinfield.pipeline import array_backend
from skinfield.pipeline.array_backend import ArrayBackend
from skinfield.pipeline.device_product import DeviceProduct


def test_devices_by_name() -> None:
    assert ArrayBackend.on("numpy").name == "numpy"
    assert ArrayBackend.on("numpy").is_host
    cpu = torch("cpu")
    assert cpu.name == "torch cpu"
    assert cpu.is_host
    assert ArrayBackend.on("cpu").name == "torch cpu"
    with pytest.raises(InputError, match="device is 'nowhere', which PyTorch does not find"):
        ArrayBackend.on("nowhere")
    if not import_module("torch").cuda.is_available():
        with pytest.raises(InputError, match="device is 'cuda', which PyTorch does not find"):
            ArrayBackend.on("cuda")


@contextmanager
def hidden(*names: str) -> Iterator[None]:
    """No such package, as far as imports go."""
    kept = {name: sys.modules.get(name) for name in names}
    sys.modules.update(dict.fromkeys(names))
    try:
        yield
    finally:
        for name, module in kept.items():
            if module is None:
                del sys.modules[name]
            else:
                sys.modules[name] = module


@pytest.mark.parametrize(
    ("installed", "cuda", "expected"),
    [
        (("torch",), True, "torch cuda:1"),
        (("torch", "cupy"), True, "torch cuda:1"),
        (("torch", "cupy"), False, "cupy 1"),
        (("cupy",), False, "cupy 1"),
        (("torch",), False, "torch cuda:1"),  # which then says what PyTorch misses
    ],
)
def test_who_has_the_card(
    installed: tuple[str, ...], cuda: bool, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = SimpleNamespace(cuda=SimpleNamespace(is_available=lambda: cuda))
    monkeypatch.setattr(array_backend, "import_module", lambda name: library)
    monkeypatch.setattr(array_backend, "_installed", lambda name: name in installed)
    monkeypatch.setattr(ArrayBackend, "torch", lambda device: f"torch {device}")
    monkeypatch.setattr(ArrayBackend, "cupy", lambda device: f"cupy {device}")
    assert ArrayBackend.on("cuda:1") == expected


def test_without_a_library_it_is_said_what_to_install() -> None:
    with hidden("torch", "cupy", "array_api_compat", "array_api_compat.torch"):
        with pytest.raises(InputError, match=r"device is 'cuda', but no library.*skinfield\[gpu\]"):
            ArrayBackend.on("cuda")
        with pytest.raises(InputError, match=r"is not installed: pip install 'skinfield\[gpu\]'"):
            ArrayBackend.torch()


def test_the_librarys_own_setting_of_products_is_put_back() -> None:
    library = pytest.importorskip("torch", reason="PyTorch is not installed")
    pytest.importorskip("array_api_compat")
    cuda = ArrayBackend(import_module("array_api_compat.torch"), library.device("cuda"))
    before = library.get_float32_matmul_precision()
    library.set_float32_matmul_precision("medium")
    try:
        with cuda.computing():
            assert library.get_float32_matmul_precision() == "highest"
        with cuda.computing(tf32=True):
            assert library.get_float32_matmul_precision() == "high"
        assert library.get_float32_matmul_precision() == "medium"
    finally:
        library.set_float32_matmul_precision(before)


class Page:
    """Memory of the host that a device writes to: filled when the event has passed, not before."""

    def __init__(self, values: np.ndarray, log: list[str]) -> None:
        self.values, self.log = values, log
        self.shape, self.dtype = values.shape, values.dtype

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, part: slice) -> "Page":
        return Page(self.values[part], self.log)

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        return self.values

    def copy_(self, source: np.ndarray, *, non_blocking: bool) -> None:
        assert non_blocking
        self.log.append("copy")
        waiting.append((self.values, source))


waiting: list[tuple[np.ndarray, np.ndarray]] = []


class Event:
    """An event of a stream."""

    def __init__(self) -> None:
        self.mine: list[tuple[np.ndarray, np.ndarray]] = []

    def record(self, stream: object = None) -> None:
        self.mine = list(waiting)
        waiting.clear()

    def synchronize(self) -> None:
        for out, values in self.mine:
            out[:] = values


class Device(SimpleNamespace):
    def __enter__(self) -> None: ...

    def __exit__(self, *error: object) -> None: ...


def stand_in(library: str, log: list[str]) -> tuple[ArrayBackend, dict[str, Any]]:
    """A backend whose arrays are NumPy's, and modules to be found in place of the library's."""

    def pinned(shape: tuple[int, ...], dtype: Any, pin_memory: bool = True) -> Any:
        assert pin_memory
        log.append(f"page of {shape[0]}")
        values = np.full(shape, np.nan, dtype)
        return Page(values, log) if library == "torch" else values

    def asnumpy(array: np.ndarray, out: np.ndarray, blocking: bool) -> None:
        assert not blocking
        Page(out, log).copy_(array, non_blocking=True)

    cuda = SimpleNamespace(
        Event=Event,
        current_stream=lambda device: device,
        mem_get_info=lambda device: (5000, 9000),
        runtime=SimpleNamespace(),
    )
    modules = {
        "torch": SimpleNamespace(
            cuda=cuda,
            empty=pinned,
            get_float32_matmul_precision=lambda: "highest",
            set_float32_matmul_precision=lambda to: None,
        ),
        "cupy": SimpleNamespace(cuda=cuda, asnumpy=asnumpy),
        "cupyx": SimpleNamespace(empty_pinned=pinned),
    }
    functions = {name: getattr(np, name) for name in ("matmul",)}
    namespace = SimpleNamespace(
        __name__=f"array_api_compat.{library}",
        asarray=lambda values, device=None: np.array(values),
        **functions,
    )
    return ArrayBackend(namespace, Device(type="cuda", mem_info=(5000, 9000))), modules


@pytest.mark.parametrize("library", ["torch", "cupy"])
def test_copies_of_cuda_land_when_they_are_awaited(
    library: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    log: list[str] = []
    backend, modules = stand_in(library, log)
    monkeypatch.setattr(array_backend, "import_module", lambda name: modules[name])
    assert not backend.is_host
    assert backend.free_bytes() == 5000
    rng = np.random.default_rng(2)
    operator, table = rng.normal(size=(6, 3)), rng.normal(size=(11, 3))
    product = DeviceProduct(operator, backend, np.float64, chunk=4)
    found = product.fields(table)
    assert np.allclose(found, table @ operator.T, rtol=1e-14, atol=1e-14)
    assert log == ["page of 4", "copy", "page of 4", "copy", "copy"]  # the third into the first's
    parts = [(part, products.copy()) for part, products in product.chunks(table)]
    assert [part.stop for part, _ in parts] == [4, 8, 11]
    assert np.allclose(np.concatenate([each for _, each in parts]), found)
    log.clear()
    assert np.allclose(product.fields(table[:2]), table[:2] @ operator.T, atol=1e-14)
    assert log == ["copy"]
    assert DeviceProduct(operator, backend).chunk == 1250 // (9 * 4)
