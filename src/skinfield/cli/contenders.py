"""Solvers as the command line names them, ready for cases, and errors that name the case."""

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from skinfield.cli.options import mechanics_of, solver_from_text
from skinfield.errors import FileError, InputError


def entrant_from_options(name: str, options: dict[str, Any]) -> Any:
    """Solver of a name with the mechanics and the grid of the options; the paper's has its own.

    Raises
    ------
    InputError
        For a solver that there is not, or settings that it does not take.
    """
    from skinfield.lab.validation import PAPER, Entrant, known_entrants

    several = len(options["solver"]) > 1
    if several and options["settings"] != "{}":
        raise InputError("--settings is given with several solvers, expected one that takes them")
    if name == PAPER:
        if options["settings"] != "{}":
            raise InputError(
                f"--settings is {options['settings']!r}, but the paper's method has none: expected "
                "them beside another --solver"
            )
        paper = next(entrant for entrant in known_entrants() if entrant.name == PAPER)
        return replace(paper, gate=options["gate_mm"] * 1e-3)
    mechanics = options["mechanics"]
    return Entrant(
        name=name,
        solver=solver_from_text(name, options["settings"]),
        mechanics=None if mechanics == "case" else mechanics_of(mechanics),
        nodes=options["grid"],
        gate=options["gate_mm"] * 1e-3,
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
