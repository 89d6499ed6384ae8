"""Contacts of skinDynLib: the lists that its programs read, and where a robot's patches sit.

From robotology/icub-main 2.11.1, `src/libraries/skinDynLib`: `include/iCub/skinDynLib/common.h`,
`src/skinContact.cpp` and `skinContactList.cpp`, and `app/skinGui/conf/skinManAll.ini` for the
ports. A list of contacts, each a list of eight. skinDynLib reads whole numbers and floating ones by
their types, and refuses a contact without any taxel, so both are kept to here. It does not read
lists of contacts from the text carrier at all: those readers need tcp; a Bottle, `yarp read` and
everything else can be read over both. The legs' skin has no link there: -1.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError, check_count
from skinfield.estimate import ListedContact
from skinfield.wire.yarp.carriers import Value

TORSO, LEFT_ARM, RIGHT_ARM, LEFT_LEG, RIGHT_LEG = 1, 3, 4, 5, 6  # body parts
NO_LINK = -1
HIGHEST = 1 << 30
FIELDS = 8  # of a contact
FARTHEST = 2.0  # m from a link's frame; no link is longer
LARGEST_LOAD = 1e6  # N, N m, and length of a normal
LARGEST = 1 << 31  # numbers of contacts come round: they have 32 bits


@dataclass(frozen=True)
class SkinPart:
    """Where a patch sits, in numbers of skinDynLib.

    Parameters
    ----------
    body, link, skin : int
        Of the body part, of its link, of the skin part; 0, -1 and 0 where it is unknown.
    """

    body: int = 0
    link: int = NO_LINK
    skin: int = 0

    def __post_init__(self) -> None:
        for name, lowest in (("body", 0), ("link", NO_LINK), ("skin", 0)):
            check_count(name, getattr(self, name), lowest, HIGHEST, "a number of skinDynLib")


UNKNOWN = SkinPart()
PARTS = {  # name in skinDynLib, and so in the files of taxel positions
    "l_hand": SkinPart(LEFT_ARM, 6, 1),
    "l_forearm": SkinPart(LEFT_ARM, 4, 2),
    "l_upper_arm": SkinPart(LEFT_ARM, 2, 3),
    "r_hand": SkinPart(RIGHT_ARM, 6, 4),
    "r_forearm": SkinPart(RIGHT_ARM, 4, 5),
    "r_upper_arm": SkinPart(RIGHT_ARM, 2, 6),
    "chest": SkinPart(TORSO, 2, 7),
    "l_upper_leg": SkinPart(LEFT_LEG, NO_LINK, 8),
    "l_lower_leg": SkinPart(LEFT_LEG, NO_LINK, 9),
    "l_foot": SkinPart(LEFT_LEG, NO_LINK, 10),
    "r_upper_leg": SkinPart(RIGHT_LEG, NO_LINK, 11),
    "r_lower_leg": SkinPart(RIGHT_LEG, NO_LINK, 12),
    "r_foot": SkinPart(RIGHT_LEG, NO_LINK, 13),
}
BODIES = ("unknown", "torso", "head", "left_arm", "right_arm", "left_leg", "right_leg")
SKINS = {part.skin: name for name, part in PARTS.items()}
PORTS = {  # of these parts, behind /icub/skin/
    "l_upper_arm": "left_arm", "r_upper_arm": "right_arm", "chest": "torso",
    "l_upper_leg": "left_leg_upper", "r_upper_leg": "right_leg_upper",
    "l_lower_leg": "left_leg_lower", "r_lower_leg": "right_leg_lower",
}  # fmt: skip
OTHER_NAMES = {port: part for part, port in PORTS.items()} | {"front_torso": "chest"}
VARIANT = re.compile(r"_(mesh|nomesh|V[0-9]+(_[0-9]+)?)$")  # of a file of positions


def known_name(name: str) -> str:
    """Name in skinDynLib of a patch's name such as ``left_forearm_V2``; empty if it is none."""
    plain = VARIANT.sub("", name.strip().replace(" ", "_"))
    plain = OTHER_NAMES.get(plain, plain)
    for side in ("left", "right"):
        if plain.startswith(f"{side}_"):
            plain = f"{side[0]}_{plain.removeprefix(f'{side}_')}"
    return plain if plain in PARTS else ""


def part_of(name: str) -> SkinPart:
    """Where a patch of that name sits; `UNKNOWN` if the name does not tell."""
    return PARTS.get(known_name(name), UNKNOWN)


def port_of(name: str, robot: str = "icub") -> str:
    """Port on which a robot publishes the skin of that name."""
    known = known_name(name)
    if not known:
        return f"/{robot}/skin/{name}"
    side = {"l_": "left_", "r_": "right_"}.get(known[:2], "")
    return f"/{robot}/skin/{PORTS.get(known, side + known[2:])}"


def parts_of(names: Sequence[str], named: Mapping[str, Sequence[int]]) -> list[SkinPart]:
    """Where patches sit: as given, ``{"palm": [3, 6, 1]}``, else as their names tell.

    Raises
    ------
    InputError
        If something is given for a patch that is not there, or is not three numbers.
    """
    strange = sorted(set(named) - set(names))
    if strange:
        raise InputError(
            f"parts are given for {strange[0]!r}, expected patches among {', '.join(names)}"
        )
    parts = []
    for name in names:
        numbers = named.get(name)
        if numbers is None:
            parts.append(part_of(name))
        elif isinstance(numbers, str) or len(numbers) != 3:
            raise InputError(
                f"part of {name!r} is {numbers!r}, expected [body part, link, skin part]"
            )
        else:
            parts.append(SkinPart(*numbers))
    return parts


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
            *(np.asarray(vector, float).tolist() for vector in vectors),
            [int(taxel) for taxel in self.taxels],
            float(self.pressure),
        ]

    @classmethod
    def of(cls, value: Value) -> "SkinContact":
        """Contact of a list of a bottle; what stands behind the eighth value is passed over.

        Raises
        ------
        InputError
            If it is no list as `values` makes them, or a number is not finite.
        """
        if not isinstance(value, list) or len(value) < FIELDS:
            raise InputError(f"a contact is {value!r:.40}, expected a list of {FIELDS}")
        numbers, taxels = _wholes(value[0], 4), _wholes(value[6])
        place, centre = (_vector(value[at], FARTHEST, "m") for at in (1, 4))
        force, moment, normal = (_vector(value[at], LARGEST_LOAD, "SI units") for at in (2, 3, 5))
        pressure = value[7]
        if isinstance(pressure, str | list) or not np.isfinite(pressure):
            raise InputError(f"pressure of a contact is {pressure!r:.40}, expected a finite number")
        part = SkinPart(*numbers[1:])
        vectors = place, force, moment, centre, normal
        return cls(numbers[0], part, *vectors, taxels, float(pressure))

    def listed(self, spacing: float) -> ListedContact:
        """What a tracker takes, of taxels `spacing` m apart."""
        body, skin = self.part.body, self.part.skin
        return ListedContact.of(
            number=self.number,
            body=BODIES[body] if body < len(BODIES) else str(body),
            link=self.part.link,
            skin=SKINS.get(skin, str(skin) if skin else BODIES[0]),
            position=self.place,
            force=self.force,
            moment=self.moment,
            normal=self.normal,
            taxels=len(self.taxels),
            spacing=spacing,
        )


def _wholes(value: Value, count: int | None = None) -> list[int]:
    """Whole numbers of a list; raises InputError for anything else, or another count."""
    whole = isinstance(value, list) and all(isinstance(each, int) for each in value)
    if not whole or (count is not None and len(value) != count):  # type: ignore[arg-type]
        raise InputError(f"{value!r:.40} stands in a contact, expected {count or 'whole'} numbers")
    return value  # type: ignore[return-value]


def _vector(value: Value, most: float, unit: str) -> Floats:
    """Three numbers of a list, none above `most`; raises InputError for anything else."""
    numbers = isinstance(value, list) and all(isinstance(each, int | float) for each in value)
    if not numbers or len(value) != 3:  # type: ignore[arg-type]
        raise InputError(f"{value!r:.40} stands in a contact, expected three numbers")
    vector = np.array(value, np.float64)
    if not (np.abs(vector) <= most).all():
        raise InputError(f"{value!r:.60} stands in a contact, expected up to {most:g} in {unit}")
    return vector
