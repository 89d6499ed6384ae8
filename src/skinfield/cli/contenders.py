"""Solvers as the command line names them, ready for cases, and errors that name the case."""

import json
import pkgutil
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skinfield.cli.options import SOLVERS, mechanics_of
from skinfield.errors import FileError, InputError

if TYPE_CHECKING:
    from skinfield.solve import Solver


def entrant_from_options(name: str, options: dict[str, Any]) -> Any:
    """Solver of a name with the mechanics and the grid of the options; the paper's has its own."""
    from skinfield.lab.validation import PAPER, Entrant, known_entrants

    if options["settings"] != "{}" and (len(options["solver"]) > 1 or name == PAPER):
        raise InputError(
            f"--settings is {options['settings']!r}, expected it beside one --solver that takes "
            "them: the paper's method has none"
        )
    gate = options["gate_mm"] * 1e-3
    if name == PAPER:
        paper = next(entrant for entrant in known_entrants() if entrant.name == PAPER)
        return replace(paper, gate=gate)
    mechanics = options["mechanics"]
    return Entrant(
        name=name,
        solver=solver_from_text(name, options["settings"]),
        mechanics=None if mechanics == "case" else mechanics_of(mechanics),
        nodes=options["grid"],
        gate=gate,
    )


@contextmanager
def named(path: Path, solver: str) -> Iterator[None]:
    """Errors name the case; those of a solver from elsewhere also where they come from."""
    try:
        yield
    except InputError as error:
        raise FileError(f"{path}: {error}") from error
    except MemoryError as error:
        raise FileError(
            f"{path} does not fit into memory, expected positions in metres on a patch of some "
            f"decimetres, or a coarser --grid: {error}"
        ) from error
    except Exception as error:
        if ":" not in solver:
            raise
        last = traceback.extract_tb(error.__traceback__)[-1]
        raise FileError(
            f"{path}: --solver {solver} fails with {type(error).__name__}: {error} "
            f"({last.filename}, line {last.lineno})"
        ) from error


def solver_from_text(text: str, settings: str = "{}") -> "Solver":
    """Solver by its name, or imported, such as "package.module:Class", and made with settings.

    Raises InputError if there is no such solver, it does not take these settings, a JSON object, or
    it has no `prepare`.
    """
    try:
        keywords = json.loads(settings)
    except ValueError:
        keywords = None
    if not isinstance(keywords, dict):
        raise InputError(f"--settings is {settings!r}, expected a JSON object such as {{}}")
    if ":" in text:
        make = _imported(text)
    elif text in SOLVERS:
        from skinfield import solve as inverse

        make = getattr(inverse, SOLVERS[text])
    else:
        raise InputError(
            f"--solver is {text!r}, expected one of {', '.join(SOLVERS)}, or your own as "
            "package.module:Class"
        )
    ready = (_is_solver(make) and not keywords) or not callable(make)
    try:
        solver = make if ready else make(**keywords)
    except TypeError as error:
        raise InputError(f"--settings is {settings}, but {text} says: {error}") from error
    if not _is_solver(solver):
        raise InputError(
            f"--solver is {text!r}, which has no prepare(model), expected a solver: "
            "see CONTRIBUTING.md"
        )
    return solver  # type: ignore[no-any-return]


def _is_solver(value: Any) -> bool:
    """Whether it is an object, not a class of objects, that prepares."""
    return not isinstance(value, type) and callable(getattr(value, "prepare", None))


def _imported(text: str) -> Any:
    """What "package.module:name" names; modules of the current folder count."""
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)  # processes that are started later import from it, too
    try:
        return pkgutil.resolve_name(text)
    except Exception as error:  # whatever runs while a foreign module is imported
        raise InputError(
            f"--solver is {text!r}, which cannot be imported: {type(error).__name__}: {error}"
        ) from error
