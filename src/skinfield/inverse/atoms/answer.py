"""What a fit knows of a reading, and of its contacts from one reading to the next."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.fields import Contact
from skinfield.inverse.atoms.left_over import LOUD
from skinfield.inverse.atoms.problem import AtomSet, Problem
from skinfield.inverse.atoms.rims import Drawable

MOVED = 0.5  # standard deviations within which what was known of a contact still holds
CHANGED = 0.2  # of its force's logarithm, likewise


@dataclass(frozen=True, eq=False)
class Touches:
    """What a reading says of contacts, without the other fields of a `Fit`.

    Attributes
    ----------
    pressure : (K,) array, Pa
    contacts : tuple of Contact
        By falling normal force.
    explained : bool
        Whether noise accounts for what the contacts leave over.
    """

    pressure: Floats
    contacts: tuple[Contact, ...]
    explained: bool


@dataclass(frozen=True, eq=False)
class Answer:
    """The atoms that explain a reading, at a scale of its noise; `drawn` is None without any."""

    problem: Problem
    found: AtomSet
    scale: float
    drawn: Drawable | None


def notes_on(problem: Problem, count: int, scale: float, offset: float) -> tuple[str, ...]:
    """What is to be told of an answer with as many contacts, in sentences."""
    notes = []
    if problem.late:
        notes.append(f"ContactFit stopped at the deadline, with {count} found")
    if scale > LOUD:
        notes.append("ContactFit saw more noise than was stated, and went by what it saw")
    if abs(offset) > problem.common > 0.0:
        notes.append("ContactFit took what all taxels share for an offset: tare the skin")
    return tuple(notes)


@dataclass(frozen=True, eq=False)
class Known:
    """What was found out about an atom (6,).

    Attributes
    ----------
    atom : (6,) array
        The minimum of the cost.
    offset : (6,) array
        From there to the posterior's mean, which is stated: its error is smaller.
    covariance : (6, 6) array
    """

    atom: Floats
    offset: Floats
    covariance: Floats


def holds(known: Known, atom: Floats) -> bool:
    """Whether an atom is still about where it was when its covariance was found."""
    off = atom - known.atom
    deviation = np.sqrt(np.diag(known.covariance)[:2])
    return bool((np.abs(off[:2]) < MOVED * deviation).all() and abs(off[2]) < CHANGED)
