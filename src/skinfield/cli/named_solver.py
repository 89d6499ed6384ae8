"""A solver by name, from this package or from anybody's."""

import importlib
import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from skinfield.cli.options import SOLVERS
from skinfield.errors import InputError
from skinfield.inverse import Solver

SOLVER_HELP = (
    f"One of {', '.join(SOLVERS)}; or your own as package.module:Class, "
    "from what is installed or lies in the current folder."
)


def solver_from_text(text: str, settings: str = "{}") -> Solver:
    """Solver by its name on the command line, or by where it is imported from.

    Parameters
    ----------
    text : str
        Such as "gaussian" or "package.module:Class"; a class, or a function that makes a
        solver, is called with the settings.
    settings : str
        A JSON object.

    Raises
    ------
    InputError
        If there is no such solver, it does not take these settings, or it has no `prepare`.
    """
    given = _settings(settings)
    if ":" in text:
        make = _imported(text)
    elif text in SOLVERS:
        make = SOLVERS[text]
    else:
        raise InputError(
            f"--solver is {text!r}, expected one of {', '.join(SOLVERS)}, or your own as "
            "package.module:Class"
        )
    try:
        ready = (_is_solver(make) and not given) or not callable(make)
        solver = make if ready else make(**given)
    except TypeError as error:
        raise InputError(f"--settings is {settings}, but {text} says: {error}") from error
    if not _is_solver(solver):
        raise InputError(
            f"--solver is {text!r}, which has no prepare(model), expected a solver: "
            "see CONTRIBUTING.md"
        )
    return solver  # type: ignore[no-any-return]


def _is_solver(found: Any) -> bool:
    """Whether it is an object, not a class of objects, that prepares."""
    return not isinstance(found, type) and callable(getattr(found, "prepare", None))


def _settings(text: str) -> dict[str, Any]:
    try:
        found = json.loads(text)
    except ValueError as error:
        raise InputError(f"--settings is {text!r}, expected a JSON object: {error}") from error
    if not isinstance(found, dict):
        raise InputError(f"--settings is {text!r}, expected a JSON object such as {{}}")
    return found


def _imported(text: str) -> Any:
    module, _, attribute = text.partition(":")
    with _current_folder():
        try:
            found = importlib.import_module(module)
        except Exception as error:  # whatever runs while a foreign module is imported
            raise InputError(
                f"--solver is {text!r}, but {module!r} cannot be imported: "
                f"{type(error).__name__}: {error}"
            ) from error
    if not hasattr(found, attribute):
        raise InputError(f"--solver is {text!r}, but {module} has no {attribute!r}")
    return getattr(found, attribute)


@contextmanager
def _current_folder() -> Iterator[None]:
    """Modules of the current folder can be imported, as with `python -m`."""
    here = str(Path.cwd())
    sys.path.insert(0, here)
    try:
        yield
    finally:
        sys.path.remove(here)
