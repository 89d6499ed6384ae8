"""How far contacts that were found are from the fingers that pressed."""

from collections.abc import Sequence
from dataclasses import dataclass

from skinfield.errors import Floats
from skinfield.experiments.cases.truth import TrueContact
from skinfield.experiments.scoring.matching import matched
from skinfield.fields import Contact
from skinfield.layout import Patch


@dataclass(frozen=True)
class Miss:
    """Errors of the contacts of one reading.

    Attributes
    ----------
    force : float
        Of the sum over all contacts, without sign, part of the true one.
    place : tuple of float, m
        Distance of each finger that was found.
    missed, extra : int
        Fingers that were not found, contacts that are none.
    """

    force: float
    place: tuple[float, ...]
    missed: int
    extra: int


def miss(patch: Patch, places: Floats, forces: Floats, contacts: Sequence[Contact]) -> Miss:
    """Compare contacts with fingers at places (F, 2) m with forces (F,) N."""
    true = [
        TrueContact((float(x), float(y)), float(force))
        for (x, y), force in zip(places, forces, strict=True)
    ]
    matches, missed, extra = matched(patch, true, contacts)
    total, found = float(forces.sum()), sum(contact.normal_force for contact in contacts)
    return Miss(abs(found / total - 1), tuple(m.distance for m in matches), missed, extra)
