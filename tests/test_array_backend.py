"""Batches on any device, by libraries that are at hand: on the host where there is no GPU."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import skinfield as sf
from skinfield.errors import InputError
from skinfield.pipeline import array_backend, device_product, device_search
from skinfield.pipeline.array_backend import ArrayBackend
from skinfield.pipeline.batch import FEWEST, BulkProduct
from skinfield.pipeline.device_non_negative import BulkNonNegative
from skinfield.pipeline.device_product import DeviceProduct, chunk_of

PATCH = sf.layouts.hexagon72()
LAYER = sf.Layer(2e-3, 100e3, 0.4)
GRID = sf.Grid.square(PATCH, nodes=18)


def torch(device: str) -> ArrayBackend:
    pytest.importorskip("array_api_compat", reason="array-api-compat: the extra gpu has it")
    library = pytest.importorskip("torch", reason="PyTorch is not installed: the extra gpu has it")
    if device == "cuda" and not library.cuda.is_available():
        pytest.skip("PyTorch finds no GPU")
    return ArrayBackend.torch(device)


def cupy() -> ArrayBackend:
    pytest.importorskip("array_api_compat", reason="array-api-compat: the extra gpu has it")
    library = pytest.importorskip("cupy", reason="CuPy is not installed")
    if not library.cuda.is_available():
        pytest.skip("CuPy finds no GPU")
    return ArrayBackend.cupy()


def strict() -> ArrayBackend:
    """The standard and nothing beyond, so that no library's habits are relied on."""
    return ArrayBackend(pytest.importorskip("array_api_strict", reason="of the extra test"))


BACKENDS = {
    "numpy": ArrayBackend.numpy,
    "strict": strict,
    "torch-cpu": lambda: torch("cpu"),
    "torch-cuda": lambda: torch("cuda"),
    "cupy": cupy,
}


@pytest.fixture(params=BACKENDS)
def backend(request: pytest.FixtureRequest) -> ArrayBackend:
    return BACKENDS[request.param]()


@pytest.fixture(scope="module")
def readings() -> np.ndarray:
    """Of two bodies, fading in, with noise; linearised."""
    bodies = [
        sf.simulate.Sphere(radius=6e-3, position=(-9e-3, 6e-3), force=1.0),
        sf.simulate.Cylinder(radius=3e-3, position=(12e-3, -8e-3), force=1.5),
    ]
    press = sf.simulate.press(LAYER, bodies, extent=70e-3, cell=1e-3)
    change = press.capacitance(PATCH.positions, PATCH.pad_diameter)
    noise = np.random.default_rng(3).normal(scale=2e-3, size=(23, 72))
    table = np.linspace(0.0, 1.0, 23)[:, None] * change + noise
    return sf.Capacitance().linearise(table, np.empty_like(table))


def operator_of(solver: sf.NonNegative) -> Any:
    rec = sf.Reconstructor(PATCH, LAYER, GRID, solver=solver, noise_std=2e-3)
    return solver.prepare(rec.model)


# --- products ---------------------------------------------------------------------------------


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


# --- names of devices -------------------------------------------------------------------------


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


# --- non-negative pressure --------------------------------------------------------------------


def test_non_negative_answers_are_those_of_one_by_one(
    backend: ArrayBackend, readings: np.ndarray
) -> None:
    operator = operator_of(sf.NonNegative(tolerance=1e-7, precision=np.float64))
    bulk = BulkNonNegative(operator, backend, tolerance=1e-3, chunk=10)
    found = bulk(readings)
    assert (found.pressure >= 0.0).all()
    assert (found.gap <= 1e-3).all()
    one, idle = np.empty(len(GRID)), 0
    for row, reading in enumerate(readings):
        operator.apply(reading, one)
        assert found.idle[row] == operator.idle
        idle += operator.idle
        if operator.idle:
            assert not found.pressure[row].any()
        above = found.objective[row] / operator.objective - 1.0
        assert -2e-6 <= above <= found.gap[row] / (1.0 - found.gap[row]) + 2e-6  # proved, and true
    assert 0 < idle < 10


def test_in_double_precision_they_converge(backend: ArrayBackend, readings: np.ndarray) -> None:
    operator = operator_of(sf.NonNegative(tolerance=1e-10, precision=np.float64))
    found = BulkNonNegative(operator, backend, precision=np.float64)(readings)
    assert found.gap.max() <= 1e-10
    expected = np.empty((23, len(GRID)))
    for reading, out in zip(readings, expected, strict=True):
        operator.apply(reading, out)
    assert np.abs(found.pressure - expected).max() < 1e-4 * expected.max()


def test_against_a_general_solver_of_bounded_least_squares(readings: np.ndarray) -> None:
    """White cells, so that pressure is amounts times a number: min |Bz - b|²/2 + |z|²/2 + mu z."""
    operator = operator_of(sf.NonNegative(length_scale=0.0))
    problem = operator.problem
    rows, penalty = problem.rows[:, :72].astype(float), problem.penalty.astype(float)
    bulk = BulkNonNegative(operator, ArrayBackend.numpy(), tolerance=1e-9, precision=np.float64)
    found = bulk(readings[-3:])
    for row, reading in enumerate(readings[-3:]):
        white = reading * problem.whitening
        # the linear term goes into the square: |z + mu|² = |z|² + 2 mu z + |mu|²
        system = np.vstack([rows.T, np.eye(len(rows))])
        exact = lsq_linear(system, np.concatenate([white, -penalty]), (0.0, np.inf), tol=1e-13)
        amounts = found.pressure[row] / float(problem.bump[0, 0])
        assert np.abs(amounts - exact.x).max() < 1e-3 * exact.x.max()
        least = exact.cost - 0.5 * penalty @ penalty
        assert found.objective[row] == pytest.approx(least, rel=1e-6)
        mine = 0.5 * np.square(rows.T @ amounts - white).sum() + 0.5 * amounts @ amounts
        assert found.objective[row] == pytest.approx(mine + penalty @ amounts, rel=1e-9)


@pytest.mark.parametrize("length_scale", [0.0, 1e-3])
def test_readings_that_no_pressure_explains(length_scale: float, readings: np.ndarray) -> None:
    """A prior of little noise and readings that are mostly noise: hundreds of steps."""
    operator = operator_of(sf.NonNegative(snr=100.0, length_scale=length_scale))
    wild = np.random.default_rng(0).normal(scale=0.2, size=(6, 72)) - 3.0 * readings[-6:]
    bulk = BulkNonNegative(operator, ArrayBackend.numpy(), 1e-4, precision=np.float64)
    found = bulk(wild)
    assert found.gap.max() <= 1e-4
    assert 100 < found.iterations.min() < found.iterations.max() < 900


def test_a_search_without_success_says_so(readings: np.ndarray) -> None:
    solver = sf.NonNegative(snr=1000.0, tolerance=1e-4, precision=np.float64, length_scale=1e-3)
    operator, out = operator_of(solver), np.empty(len(GRID))
    wild = np.random.default_rng(0).normal(scale=0.2, size=(4, 72))
    found = BulkNonNegative(operator, ArrayBackend.numpy(), most_iterations=64)(wild)
    assert found.gap.min() > 0.1
    nothing = 0.5 * np.square(wild * operator.problem.whitening).sum(axis=1)
    assert (found.objective <= nothing).all()
    for row, reading in enumerate(wild):
        operator.apply(reading, out)
        assert found.objective[row] * (1.0 - found.gap[row]) <= operator.objective


def test_few_steps_leave_a_gap_that_is_said(readings: np.ndarray) -> None:
    operator = operator_of(sf.NonNegative())
    best = BulkNonNegative(operator, ArrayBackend.numpy(), tolerance=1e-7, precision=np.float64)
    least, before = best(readings[-4:]).objective, np.inf
    for most in (1, 16, 32, 64):
        bulk = BulkNonNegative(operator, ArrayBackend.numpy(), 1e-7, most)
        found = bulk(readings[-4:])
        assert (found.objective * (1.0 - found.gap) <= least * (1.0 + 1e-6)).all()
        assert (found.iterations <= most + device_search.EVERY).all()
        assert found.gap.max() < before
        before = found.gap.max()
    assert before < 1e-3


def test_only_idle_readings_and_none(readings: np.ndarray) -> None:
    bulk = BulkNonNegative(operator_of(sf.NonNegative()), ArrayBackend.numpy())
    found = bulk(np.zeros((3, 72)))
    assert found.idle.all()
    assert not found.pressure.any()
    assert not found.gap.any()
    assert bulk(np.zeros((0, 72))).pressure.shape == (0, len(GRID))


def test_readings_that_lack_taxels_are_refused(readings: np.ndarray) -> None:
    bulk = BulkNonNegative(operator_of(sf.NonNegative()), ArrayBackend.numpy())
    spoiled = readings.copy()
    spoiled[2, 5] = np.nan
    with pytest.raises(InputError, match=r"readings\[2, 5\] is nan, expected a finite number"):
        bulk(spoiled)
    with pytest.raises(InputError, match="tolerance"):
        BulkNonNegative(operator_of(sf.NonNegative()), ArrayBackend.numpy(), tolerance=0.0)


# --- CUDA's copies, where there is no CUDA ----------------------------------------------------


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


def test_the_page_runs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from test_readme import ROOT, follow

    monkeypatch.chdir(tmp_path)
    assert follow(ROOT / "docs" / "gpu.md") == (2, 0)
    printed = capsys.readouterr().out.splitlines()
    assert printed[0] == "(3000, 1600) True"
    assert printed[1].startswith("True True")
