"""Contacts of the skin as skinDynLib sends them.

From robotology/icub-main 2.11.1, `src/libraries/skinDynLib/src/skinContact.cpp` and
`skinContactList.cpp`: a list of contacts, each a list of eight. skinDynLib reads whole numbers and
floating ones by their types, and refuses a contact without any taxel, so both are kept to here. It
does not read lists of contacts from the text carrier at all: those readers need tcp; a Bottle,
`yarp read` and everything else can be read over both.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.protocols.yarp.bottle import Value
from skinfield.protocols.yarp.skin_parts import SkinPart

LARGEST = 1 << 31  # numbers of contacts come round: they have 32 bits


@dataclass(frozen=True, eq=False)
class SkinContact:
    """One contact; vectors (3,) in the link's frame.

    Parameters
    ----------
    number : int
        Of the contact, which it keeps while it goes on.
    part : SkinPart
    place : (3,) array, m
        Centre of pressure.
    force : (3,) array, N
        That acts on the robot: into the skin, against the normal.
    moment : (3,) array, N m
        That acts on the robot, about the centre of pressure.
    centre : (3,) array, m
        Mean place of the active taxels.
    normal : (3,) array
        Outward.
    taxels : sequence of int
        Active ones, by their channels in the port's vector; at least one.
    pressure : float, kPa
        Mean over the contact.
    """

    number: int
    part: SkinPart
    place: Floats
    force: Floats
    moment: Floats
    centre: Floats
    normal: Floats
    taxels: Sequence[int]
    pressure: float

    def __post_init__(self) -> None:
        if not len(self.taxels):
            raise InputError("contact has no taxel, expected one or more, as skinDynLib does")

    @property
    def values(self) -> list[Value]:
        """As a list of a bottle."""
        part = self.part
        vectors = (self.place, self.force, self.moment, self.centre, self.normal)
        return [
            [self.number % LARGEST, part.body, part.link, part.skin],
            *(_floats(vector) for vector in vectors),
            [int(taxel) for taxel in self.taxels],
            float(self.pressure),
        ]


def _floats(vector: Floats) -> list[Value]:
    return [float(number) for number in np.asarray(vector)]
