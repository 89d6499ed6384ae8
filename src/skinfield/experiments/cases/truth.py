"""What truly presses on a skin, whoever computed or measured it."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_finite,
    check_positive,
    check_shape,
)


@dataclass(frozen=True)
class TrueContact:
    """One body on the skin.

    Parameters
    ----------
    position : (x, y), m
        Centre of pressure in the patch's plane.
    force : float, N
        Into the skin.
    area : float, m²
        That touches; NaN where it is not known.
    kind : str
        What pressed, in words.
    """

    position: tuple[float, float]
    force: float
    area: float = float("nan")
    kind: str = "body"

    def __post_init__(self) -> None:
        position = as_floats("position", self.position)
        check_shape("position", position, (2,), "x and y in the patch's plane, in metres")
        check_finite("position", position, "x and y in the patch's plane, in metres")
        object.__setattr__(self, "position", (float(position[0]), float(position[1])))
        check_positive("force", self.force, "of a contact into the skin, in newtons")
        if not self.area >= 0.0 and not np.isnan(self.area):
            raise InputError(f"area is {self.area!r} m², expected 0 or more, or NaN if unknown")


@dataclass(frozen=True, eq=False, kw_only=True)
class Truth:
    """Contacts and, where known, the fields on a fine mesh.

    Parameters
    ----------
    cell : float, m
        Each node stands for `cell` x `cell` of skin.
    plane : (K, 2) array, m
        Nodes in the patch's plane; none where only the contacts are known.
    pressure : (K,) array, Pa
        Positive in compression; 0 away from the nodes.
    displacement : (K, 3) array, m
        Of the surface along the plane's x, its y, and the outward normal; NaN where unknown. Away
        from the nodes it is not known.
    contacts : tuple of TrueContact
        None where nothing presses.
    source : str
        Where it comes from.
    """

    cell: float
    plane: Floats
    pressure: Floats
    displacement: Floats
    contacts: tuple[TrueContact, ...]
    source: str = ""

    def __post_init__(self) -> None:
        check_positive("cell", self.cell, "side of a cell of the truth, in metres")
        object.__setattr__(self, "contacts", tuple(self.contacts))
        plane = np.array(as_floats("plane", self.plane))
        check_shape("plane", plane, (None, 2), "x and y of the nodes, in metres")
        check_finite("plane", plane, "x and y of the nodes, in metres")
        pressure = np.array(as_floats("pressure", self.pressure))
        check_shape("pressure", pressure, (len(plane),), "one per node, in Pa")
        check_finite("pressure", pressure, "one per node, in Pa")
        displacement = np.array(as_floats("displacement", self.displacement))
        check_shape("displacement", displacement, (len(plane), 3), "three per node, in metres")
        if np.isinf(displacement).any():
            raise InputError("displacement holds an infinity, expected metres, or NaN if unknown")
        named = (("plane", plane), ("pressure", pressure), ("displacement", displacement))
        for key, value in named:
            value.setflags(write=False)
            object.__setattr__(self, key, value)

    @property
    def force(self) -> float:
        """Of all contacts, N."""
        return float(sum(contact.force for contact in self.contacts))

    @property
    def field_force(self) -> float:
        """Sum of the pressure, N; 0 where the fields are not known."""
        return float(self.pressure.sum() * self.cell**2)

    @property
    def contact_area(self) -> float:
        """Of all contacts, m²; NaN where that of one is not known."""
        return float(sum(contact.area for contact in self.contacts))
