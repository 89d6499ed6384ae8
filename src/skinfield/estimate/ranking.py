"""Ranking of numbers that rounding may order either way: ties are broken by definition.

Two contacts that are mirror images have the same force, but for the rounding of sums: which of them
comes first must not depend on the processor. So numbers count as equal if they differ by a small
part of themselves, and of equal ones the first in another order comes first.
"""

from collections.abc import Iterable, Sequence
from functools import cmp_to_key
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.estimate.contact import Contact

TIE = 1e-9  # part of a number by which another one is equal: far above the rounding of any sum here


def falling_order(values: Sequence[float], ties: Sequence[Any]) -> list[int]:
    """Indices by falling value; of equal ones by rising tie.

    Parameters
    ----------
    values : sequence of N floats
    ties : sequence of N, of a type that has an order
        For contacts the smallest cell of each.
    """

    def after(one: int, other: int) -> int:
        if abs(values[one] - values[other]) <= TIE * abs(values[other]):
            return int(ties[one] > ties[other]) - int(ties[one] < ties[other])
        return -1 if values[one] > values[other] else 1

    return sorted(range(len(values)), key=cmp_to_key(after))


def by_falling_force(contacts: Iterable[Contact]) -> tuple[Contact, ...]:
    """Contacts by falling normal force; of equal ones the one with the smallest cell first."""
    every = list(contacts)
    order = falling_order(
        [contact.normal_force for contact in every],
        [int(contact.cells[0]) if len(contact.cells) else 0 for contact in every],
    )
    return tuple(every[index] for index in order)


def first_largest(values: Floats | NDArray[np.float32]) -> int:
    """Index of the largest of some numbers; the first of equal ones.

    Parameters
    ----------
    values : (N,) array
        Finite, one or more.
    """
    highest = values.max()
    return int(np.argmax(values >= highest - TIE * abs(highest)))
