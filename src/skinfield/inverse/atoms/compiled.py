"""How functions that compiled ones alone call are compiled: in half the time."""

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

from skinfield.inverse.atoms.stale import drop_stale

drop_stale()  # before the first function of this folder is compiled, or read from disk

F = TypeVar("F", bound=Callable[..., Any])


def inner(function: F) -> F:
    """Compile a function that is never called from Python, nor kept on disk by itself.

    It is part of what calls it, and of what is kept of that. Without the two wrappers by which
    Python and C would call it there is half as much to compile.
    """
    options: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    made: F = njit(nogil=True, **options)(function)
    return made
