"""Which contact that was found belongs to which true one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skinfield.experiments.cases.truth import TrueContact
from skinfield.fields import Contact
from skinfield.layout import Patch

GATE = 8e-3  # m: farther apart, two contacts do not belong together


@dataclass(frozen=True)
class Match:
    """A true contact and the one that was found for it.

    Attributes
    ----------
    true, found : int
        Their places in the two lists.
    distance : float, m
    true_force, found_force : float, N
    """

    true: int
    found: int
    distance: float
    true_force: float
    found_force: float

    @property
    def force_error(self) -> float:
        """Signed, part of the true force."""
        return self.found_force / self.true_force - 1


def matched(
    patch: Patch, true: Sequence[TrueContact], found: Sequence[Contact], gate: float = GATE
) -> tuple[tuple[Match, ...], int, int]:
    """Assign found contacts to true ones: as many pairs as the gate allows, then the nearest.

    Parameters
    ----------
    patch : Patch
        On which the true contacts' positions lie.
    true : sequence of TrueContact
    found : sequence of Contact
    gate : float, m

    Returns
    -------
    matches : tuple of Match
        In the order of the true contacts.
    missed, false : int
        True contacts and found ones that are left over.
    """
    if not true or not found:
        return (), len(true), len(found)
    from scipy.optimize import linear_sum_assignment

    plane = np.array([contact.position for contact in true])
    places = patch.surface.position_from_plane(plane)
    positions = np.array([contact.position for contact in found])
    apart = np.linalg.norm(places[:, None] - positions[None], axis=2)
    # A pair beyond the gate costs more than all pairs within it: it is only made if no other is.
    beyond = gate * (min(apart.shape) + 1)
    rows, columns = linear_sum_assignment(np.where(apart <= gate, apart, beyond))
    matches = tuple(
        Match(i, j, float(apart[i, j]), true[i].force, float(found[j].normal_force))
        for i, j in zip(rows.tolist(), columns.tolist(), strict=True)
        if apart[i, j] <= gate
    )
    return matches, len(true) - len(matches), len(found) - len(matches)
