"""Contact lists: contacts of one instant that another program found, in the frames of links."""

import math
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError, check_count, check_positive, check_shape
from skinfield.estimate.contact import Contact

SPACING = 6.5e-3  # m, between taxels of iCub's triangles
REACH, NEAR = 3.0, 6.0  # spacings: of one step of a contact; of two that merge or split


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ListedContact(Contact):
    """A contact as its sender has it, in the frame of a link.

    Area, radius and covariance are not sent: they are told from the number of taxels, see `of`.
    What else a `Contact` has and nobody knows is NaN or empty.

    Attributes
    ----------
    number : int
        That the sender gave it; of iCub's skinManager another one in each reading.
    body, skin : str
        Part of the body and of the skin, such as "right_arm" and "r_forearm".
    link : int
        Of the body part; -1 where it is unknown.
    taxels : int
        That feel it.
    """

    number: int
    body: str
    link: int  # type: ignore[assignment]  # as skinDynLib counts them, not a name
    skin: str
    taxels: int

    @classmethod
    def of(
        cls,
        *,
        position: Floats,
        force: Floats,
        moment: Floats,
        normal: Floats,
        taxels: int,
        spacing: float = SPACING,
        number: int = 0,
        body: str = "",
        link: int = -1,
        skin: str = "",
    ) -> "ListedContact":
        """Contact with what can be told from its taxels.

        Each taxel speaks for one cell of a hexagonal lattice, so the area is that of the cells. One
        taxel tells the centre to within half a spacing, and the force to within itself; n of them
        to 1/√n of that: standard deviations of the place of spacing / (2 √n), and of the normal
        force of force / √n.

        Parameters
        ----------
        position : (3,) array, m
            Centre of pressure, in the link's frame.
        force : (3,) array, N
            On the robot: into the skin.
        moment : (3,) array, N m
        normal : (3,) array
            Outward, of any length; zeros where the sender does not know it.
        taxels : int
            That feel it.
        spacing : float, m
            Between neighbouring taxels.
        number, body, link, skin
            See the class.

        Raises
        ------
        InputError
            If a vector is not (3,) and finite, there is no taxel, or the spacing is not positive.
        """
        vectors = {"position": position, "force": force, "moment": moment, "normal": normal}
        for name, vector in vectors.items():
            check_shape(name, vector, (3,), "x, y, z in the link's frame")
            if not np.isfinite(vector).all():
                raise InputError(f"{name} is {vector}, expected finite numbers")
        check_count("taxels", taxels, 1, 1 << 20, "that feel the contact")
        check_positive("spacing", spacing, "of taxels, in metres")
        length = float(np.linalg.norm(normal))
        unit = np.asarray(normal / length if length > 0.0 else normal, np.float64)
        area = taxels * spacing**2 * math.sqrt(0.75)
        place, strength = (0.5 * spacing) ** 2 / taxels, float(force @ unit) ** 2 / taxels
        radius, unknown = math.sqrt(area / math.pi), float("nan")
        return cls(
            position=position, force=force, moment=moment, normal=unit,
            area=area, area_std=unknown, peak_pressure=unknown,
            covariance=np.diag([place, place, strength]), radius=radius, shape="other",
            outline=np.empty((0, 3)), axes=np.full(2, radius), angle=0.0,
            cells=np.empty(0, np.int64), number=number, body=body, link=link, skin=skin,
            taxels=taxels,
        )  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactList:
    """Contacts of all links of a robot at one instant; a `Tracker` takes them as estimates.

    Attributes
    ----------
    stamp_ns : int, ns
    contacts : tuple of ListedContact
        In the sender's order; empty where nothing touches.
    spacing : float, m
        Between taxels: a contact may step by three spacings from one reading to the next, and
        contacts within six merge and split, or by what the tracker allows where that is more.
    """

    stamp_ns: int
    contacts: tuple[ListedContact, ...]
    spacing: float = SPACING
