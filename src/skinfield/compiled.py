"""Compiled kernels: the decorator of every one, and the cache of their machine code on disk.

Numba looks for a function's machine code by the file of that function alone: after a change of a
function that it calls, or of a constant of another file, it would go on with what they were. So the
code of a module's kernels lies in a folder named after all sources that the module imports, what
those import in turn, the versions of the compilers, and their settings.

With `interpret`, or NUMBA_DISABLE_JIT=1, kernels are plain Python: the same answers but for
rounding, a hundred times later, and at once where there is no machine code yet.
"""

import hashlib
import os
import platform
import re
import shutil
import stat
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from operator import attrgetter
from pathlib import Path
from types import SimpleNamespace
from typing import Any, TypeVar, overload

import llvmlite
import numba
from numba import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.registry import cpu_target

CONFIG: Any = numba.config
UNLITERAL: Any = types.unliteral
PACKAGE = Path(__file__).parent
VERSIONS_PER_MODULE = 3  # two branches of a checkout, and what is being edited
IMPORT = re.compile(
    rb"^[ \t]*(?:from (skinfield[\w.]*) import (\([^)]*\)|[^\n]*)|import (skinfield[\w.]*))", re.M
)
VALUES = attrgetter("_values")  # of a compilation's settings, as far as they are set
MODE = SimpleNamespace(interpreted=bool(CONFIG.DISABLE_JIT))  # of kernels loaded from now on
LOCK = threading.Lock()  # of Numba's setting of the folder
NO_CODE = ("NUMBA_CACHE_DIR", "NUMBA_NUM_THREADS", "NUMBA_DEBUG_CACHE")  # what they change

F = TypeVar("F", bound=Callable[..., Any])


def interpret() -> None:
    """Interpret the kernels of modules that are loaded from now on, but for the heavy ones."""
    MODE.interpreted = True


@overload
def njit(function: F, /) -> F: ...
@overload
def njit(*, heavy: bool = False, **options: Any) -> Callable[[F], F]: ...
def njit(function: Any = None, /, **options: Any) -> Any:
    """Compile a function when it is first called, without the interpreter's lock, once per machine.

    Parameters
    ----------
    function : callable
    heavy : bool
        Compile it after `interpret` too: interpreted, it would take longer than to compile.
    **options
        Those of `numba.njit`.
    """
    if function is None:
        return lambda function: njit(function, **options)
    heavy = options.pop("heavy", False)
    if CONFIG.DISABLE_JIT or (MODE.interpreted and not heavy):
        return _interpreted(function)
    folder = cache_folder(Path(function.__code__.co_filename))
    with LOCK:
        before = CONFIG.CACHE_DIR
        CONFIG.CACHE_DIR = str(folder)
        try:
            return numba.njit(
                **{"cache": True, "nogil": True, "no_cfunc_wrapper": True, **options},
                pipeline_class=QuickCompiler,
            )(function)
        finally:
            CONFIG.CACHE_DIR = before


@overload
def inner(function: F, /) -> F: ...
@overload
def inner(*, heavy: bool = False, **options: Any) -> Callable[[F], F]: ...
def inner(function: Any = None, /, **options: Any) -> Any:
    """Compile a function that only compiled ones call: in half the time.

    It is part of what calls it, and of what the cache holds of that: there it is optimised, and
    becomes machine code, once for all. It has no wrapper by which Python or C would call it.

    Parameters
    ----------
    function : callable
    heavy : bool
        See `njit`.
    **options
        Those of `numba.njit`.
    """
    if function is None:
        return lambda function: inner(function, **options)
    heavy = options.pop("heavy", False)
    if CONFIG.DISABLE_JIT:
        return _interpreted(function)
    bare = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": InnerCompiler}
    made = numba.njit(**{"nogil": True, **bare, **options})(function)
    template = made.get_call_template

    def any_value(arguments: Any, keywords: Any) -> Any:
        """One code for all values of a constant, which Numba would take for types of their own."""
        return template([UNLITERAL(each) for each in arguments], keywords)

    made.get_call_template = any_value
    return _also_interpreted(made, heavy) if MODE.interpreted else made


def _also_interpreted(made: Any, heavy: bool) -> Any:
    """Function that heavy ones call compiled, and interpreted ones so only if it is heavy."""
    kind: Any = types.Dispatcher
    function = _entry(made) if heavy else made.py_func
    cpu_target.typing_context.insert_global(function, kind(made))
    function.dispatcher = made  # which Numba knows weakly
    return _interpreted(function)


def _entry(made: Any) -> Any:
    """Function of Python that calls an inner one, compiled for it when it first does."""

    def enter(*arguments: Any) -> Any:
        return made(*arguments)

    enter.__module__, enter.__qualname__ = made.py_func.__module__, made.py_func.__qualname__
    entry = numba.njit(nogil=True)(enter)
    return lambda *arguments: entry(*arguments)


def _interpreted(function: Any) -> Any:
    """The function, with the `py_func` that compiled ones have."""
    function.py_func = function
    return function


class QuickFlags(Flags):
    """Settings of a compilation, of which Numba asks 500 times a function whether they are equal.

    Of its own it compares the values of thirty properties each time: a quarter of all it does.
    """

    __slots__ = ()

    def __hash__(self) -> int:
        return hash(QuickFlags)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, QuickFlags):
            return False
        return bool(VALUES(self) == VALUES(other))


class QuickCompiler(Compiler):
    """Numba's compiler, by `QuickFlags`."""

    def __init__(
        self,
        typing: Any,
        target: Any,
        library: Any,
        arguments: Any,
        result: Any,
        flags: Any,
        *rest: Any,
    ) -> None:
        start: Any = super().__init__
        quick: Any = QuickFlags
        start(typing, target, library, arguments, result, quick(flags), *rest)


class InnerLibrary(JITCodeLibrary):
    """Code that is optimised, and translated, in what it is linked into alone.

    Numba does both at each function for all that it calls: the deeper calls go, the more often.
    """

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """None: it is no machine code."""
        return 0

    @property
    def codegen(self) -> Any:
        """Itself, for `set_env`."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Nothing: there is none before it is linked."""


class InnerCompiler(QuickCompiler):
    """Numba's compiler, for functions that only compiled ones call."""

    def __init__(self, typing: Any, target: Any, library: Any, *rest: Any) -> None:
        name = "inner" if library is None else library.name
        code: Any = InnerLibrary
        super().__init__(typing, target, code(target.codegen(), name), *rest)


@contextmanager
def parallel_compilation(script: str, function: Any) -> Iterator[None]:
    """Have another process compile what a script calls, while this one compiles something else.

    Numba compiles one function at a time in each process. Afterwards this one loads the code; what
    the other could not compile is compiled here when it is called. None is started where a function
    of those was compiled before, nor on one processor, nor where they are interpreted.

    Parameters
    ----------
    script : str
        Of Python.
    function : callable
        One by `njit` that the script calls last.
    """
    source = Path(function.py_func.__code__.co_filename)
    allowed = getattr(os, "sched_getaffinity", lambda _: range(os.cpu_count() or 1))  # not on macOS
    alone = MODE.interpreted or len(allowed(0)) == 1
    if alone or is_cached(source, function.py_func.__qualname__):
        yield
        return
    quiet = subprocess.DEVNULL
    words = [sys.executable, "-c", script]
    with subprocess.Popen(words, stdin=quiet, stdout=quiet, stderr=quiet) as child:
        try:
            yield
        except BaseException:
            child.kill()
            raise


def is_cached(file: Path, name: str) -> bool:
    """Whether the cache holds machine code of a source file's kernel, of any types."""
    return any(cache_folder(file).rglob(f"{file.stem}.{name}-*.nbi"))


@cache
def cache_folder(file: Path) -> Path:
    """Folder of what the kernels of a source file compile to; older ones of it are deleted.

    Parameters
    ----------
    file : Path

    Returns
    -------
    Path
        It exists and can be written to.
    """
    module = _relative(str(file)).removesuffix(".py").replace(os.sep, ".")
    checkout = _checkout_folder()
    folder = checkout / f"{module}-{fingerprint(file)}"
    try:
        folder.mkdir()
    except FileExistsError:
        os.utime(folder)  # in use: not the oldest
        return folder
    versions = [each for each in checkout.glob(f"{module}-*") if len(each.name) == len(folder.name)]
    for old in sorted(versions, key=_last_use, reverse=True)[VERSIONS_PER_MODULE:]:
        shutil.rmtree(old, ignore_errors=True)  # another process may be faster
    return folder


def fingerprint(file: Path) -> str:
    """Hash of all that the machine code of a source file's kernels is made from.

    Parameters
    ----------
    file : Path

    Returns
    -------
    str
        16 hexadecimal digits.
    """
    total, seen, waiting = hashlib.sha256(_compilers()), {str(file)}, [str(file)]
    while waiting:
        more = _source(waiting.pop())[1] - seen
        seen |= more
        waiting += more
    for each in sorted(seen):
        total.update(_relative(each).encode() + b"\0" + _source(each)[0])
    return total.hexdigest()[:16]


@cache
def _source(file: str) -> tuple[bytes, frozenset[str]]:
    """Hash of a file, and the files of this package that it imports."""
    text = Path(file).read_bytes()
    return hashlib.sha256(text).digest(), frozenset(_imports(text))


def _imports(text: bytes) -> Iterator[str]:
    """Files of the modules, and of the names that are modules, of all import statements."""
    for source, names, module in IMPORT.findall(text):
        yield from _files(source or module)
        if names and _files(source)[0].endswith("__init__.py"):
            for name in re.findall(rb"\w+", names):
                yield from _files(source + b"." + name)


@cache
def _files(module: bytes) -> tuple[str, ...]:
    """The file of a module of this package; none of a name that is no module."""
    place = PACKAGE.joinpath(*module.decode().split(".")[1:])
    both = place.with_suffix(".py"), place / "__init__.py"
    return tuple(str(each) for each in both if each.is_file())


def _relative(file: str) -> str:
    """Name within this package, or of elsewhere."""
    inside = file.removeprefix(f"{PACKAGE}{os.sep}")
    return Path(file).name if inside == file else inside


@cache
def _compilers() -> bytes:
    """Versions and settings; processors are told apart by Numba itself, within a folder."""
    versions = [numba.__version__, llvmlite.__version__, sys.version, platform.machine()]
    settings = [
        f"{key}={value}"
        for key, value in sorted(os.environ.items())
        if key.startswith("NUMBA_") and key not in NO_CODE
    ]
    return "\0".join(versions + settings).encode()


@cache
def _checkout_folder() -> Path:
    """Folder of this checkout; those of checkouts that are no more are deleted."""
    root = code_folder()
    folder = root / hashlib.sha256(str(PACKAGE).encode()).hexdigest()[:16]
    if not (folder / "checkout").is_file():
        folder.mkdir(exist_ok=True)
        (folder / "checkout").write_text(str(PACKAGE))
        for other in root.glob("*/checkout"):
            if not Path(other.read_text()).is_dir():
                shutil.rmtree(other.parent, ignore_errors=True)
    return folder


def code_folder() -> Path:
    """User's cache folder, below `NUMBA_CACHE_DIR` where that is set, or a temporary one."""
    home = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    wanted = Path(CONFIG.CACHE_DIR or home).expanduser() / "skinfield" / "kernels"
    try:
        wanted.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=wanted).close()
    except (OSError, RuntimeError) as reason:  # RuntimeError: a user without a home
        temporary = _temporary_root()
        warnings.warn(
            f"{wanted} cannot be written to ({reason}): compiled code goes to {temporary}, which "
            "may be gone after a restart. Set NUMBA_CACHE_DIR to a folder that lasts.",
            RuntimeWarning,
            stacklevel=2,
        )
        return temporary
    return wanted


def _temporary_root() -> Path:
    """One for all processes of this user; of this process alone if another user made that one."""
    folder = Path(tempfile.gettempdir()) / f"skinfield-kernels-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    status = folder.lstat()
    if stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not status.st_mode & 0o077:
        return folder
    return Path(tempfile.mkdtemp(prefix="skinfield-kernels-"))


def _last_use(folder: Path) -> float:
    """Time, s; 0 if another process has deleted it."""
    try:
        return folder.stat().st_mtime
    except OSError:
        return 0.0
