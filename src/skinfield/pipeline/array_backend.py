"""An array library and one of its devices, by the array API standard: NumPy, PyTorch or CuPy."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError

INSTALL = "pip install 'skinfield[gpu]' for PyTorch, or array-api-compat and cupy-cuda12x for CuPy"


@dataclass(frozen=True, eq=False)
class ArrayBackend:
    """Where arrays are computed.

    What all libraries do alike goes by the array API standard (data-apis.org/array-api). What it
    leaves out, copies that run beside the host and the memory that is free, is here, for each
    library that offers it.

    Parameters
    ----------
    namespace : module
        Functions of the standard, such as `array_api_compat.torch`.
    device : device of that library, optional
        Default the library's own.
    """

    namespace: Any
    device: Any = None
    _landing: dict[int, Any] = field(default_factory=dict, repr=False)

    @classmethod
    def numpy(cls) -> "ArrayBackend":
        """The host, by NumPy, which follows the standard from version 2 on."""
        if not hasattr(np, "matrix_transpose"):
            return cls(_compat("numpy"))
        return cls(np)

    @classmethod
    def torch(cls, device: str = "cuda") -> "ArrayBackend":
        """PyTorch, on a device in its own words: "cuda", "cuda:1", "mps", "cpu".

        Raises
        ------
        InputError
            If it is not installed, or the device is not there.
        """
        namespace = _compat("torch")
        library = import_module("torch")
        try:
            library.empty(1, device=device)
        except (RuntimeError, AssertionError, NotImplementedError) as error:
            first = str(error).splitlines()[0]
            raise InputError(
                f"device is {device!r}, which PyTorch does not find: {first}"
            ) from None
        return cls(namespace, library.device(device))

    @classmethod
    def cupy(cls, device: int = 0) -> "ArrayBackend":
        """CuPy, on the CUDA device of a number.

        Raises
        ------
        InputError
            If it is not installed, or the device is not there.
        """
        namespace = _compat("cupy")
        library = import_module("cupy")
        try:
            count = library.cuda.runtime.getDeviceCount()
        except library.cuda.runtime.CUDARuntimeError as error:
            raise InputError(f"CuPy finds no CUDA device: {error}") from None
        if not 0 <= device < count:
            raise InputError(f"device is {device}, expected one of the {count} that CuPy finds")
        return cls(namespace, library.cuda.Device(device))

    @classmethod
    def on(cls, device: str) -> "ArrayBackend":
        """By the name of a device: PyTorch's if that has it, else CuPy's.

        Parameters
        ----------
        device : str
            "numpy" for the host without any further library; else as PyTorch calls it: "cuda",
            "cuda:1", "mps", "cpu". Of those, CuPy has "cuda" with a number.

        Raises
        ------
        InputError
            If neither is installed, or the device is not there.
        """
        if device == "numpy":
            return cls.numpy()
        kind, _, number = device.partition(":")
        named = kind == "cuda" and (number.isdigit() or not number)
        if named and _installed("cupy") and not _torch_has_cuda():
            return cls.cupy(int(number or 0))
        if _installed("torch"):
            return cls.torch(device)
        raise InputError(f"device is {device!r}, but no library for it is installed: {INSTALL}")

    @property
    def name(self) -> str:
        """Library and device, such as "torch cuda:0"."""
        library = self.namespace.__name__.rpartition("array_api_compat.")[2]
        return library if self.device is None else f"{library} {self.device}"

    @property
    def is_host(self) -> bool:
        """Whether its arrays lie in the host's memory."""
        kind = getattr(self.device, "type", None)  # of PyTorch
        return not self._is("cupy") and kind in (None, "cpu")

    def send(self, values: NDArray[Any]) -> Any:
        """Array of the library on the device, of the same numbers."""
        if self._is("cupy"):
            with self.device:
                return self.namespace.asarray(values)
        if self._is("torch"):  # which takes no array that must not be written
            return self.namespace.asarray(np.require(values, requirements="W"), device=self.device)
        return self.namespace.asarray(values, device=self.device)

    def fetch(self, array: Any) -> NDArray[Any]:
        """NumPy array of the same numbers."""
        if self._is("cupy"):
            return np.asarray(array.get())
        return np.asarray(array.cpu() if self._is("torch") else array)

    def begin_fetch(self, array: Any, slot: int) -> Callable[[], NDArray[Any]]:
        """Begin to copy an array to the host; returns what waits for it, a NumPy array then.

        On CUDA the copy runs beside the host, into pages of its own that stay in memory: those of
        a `slot` are written over by the next copy that begins in it.
        """
        if not self._is_cuda:
            return lambda: self.fetch(array)
        page = self._page(array, slot)[: len(array)]
        if self._is("torch"):
            page.copy_(array, non_blocking=True)
            event = import_module("torch").cuda.Event()
            event.record(import_module("torch").cuda.current_stream(self.device))
        else:
            import_module("cupy").asnumpy(array, out=page, blocking=False)
            event = import_module("cupy").cuda.Event()
            event.record()

        def end() -> NDArray[Any]:
            event.synchronize()
            return np.asarray(page)

        return end

    def _page(self, array: Any, slot: int) -> Any:
        """Room on the host for an array, in pages that the device can write by itself."""
        page = self._landing.get(slot)
        if page is None or len(page) < len(array) or page.shape[1:] != array.shape[1:]:
            page = None
        if page is None or page.dtype != array.dtype:
            shape = tuple(array.shape)
            if self._is("torch"):
                library = import_module("torch")
                page = library.empty(shape, dtype=array.dtype, pin_memory=True)
            else:
                page = import_module("cupyx").empty_pinned(shape, dtype=array.dtype)
            self._landing[slot] = page
        return page

    def free_bytes(self) -> int | None:
        """Memory of the device that is free; None where the library does not say."""
        if self._is("cupy"):
            return int(self.device.mem_info[0])
        if self._is_cuda:
            return int(import_module("torch").cuda.mem_get_info(self.device)[0])
        return None

    @contextmanager
    def computing(self, tf32: bool = False) -> Iterator[None]:
        """Products of single precision in full, or of TF32's 10 bits where that is asked for.

        PyTorch has one setting for all its work: it is put back at the end. CuPy reads its own,
        which is off, from the environment (CUPY_TF32).
        """
        if self._is("cupy"):
            with self.device:
                yield
            return
        if not self._is_cuda:
            yield
            return
        library = import_module("torch")
        before = library.get_float32_matmul_precision()
        library.set_float32_matmul_precision("high" if tf32 else "highest")
        try:
            yield
        finally:
            library.set_float32_matmul_precision(before)

    @property
    def _is_cuda(self) -> bool:
        return self._is("cupy") or getattr(self.device, "type", None) == "cuda"

    def _is(self, library: str) -> bool:
        return bool(self.namespace.__name__.endswith(f"array_api_compat.{library}"))


def _installed(library: str) -> bool:
    try:
        import_module(library)
    except ImportError:
        return False
    return True


def _torch_has_cuda() -> bool:
    return _installed("torch") and bool(import_module("torch").cuda.is_available())


def _compat(library: str) -> ModuleType:
    try:
        return import_module(f"array_api_compat.{library}")
    except ImportError as error:
        missing = error.name or library
        raise InputError(f"{missing} is not installed: {INSTALL}") from None
