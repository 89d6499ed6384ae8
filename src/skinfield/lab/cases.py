"""Simulated and measured cases: what the taxels of a patch read, and what truly pressed on it."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from skinfield.elastic import BaseStress, BondedLayer, Capacitance, Gap, Layer, Quantity
from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_choice,
    check_finite,
    check_positive,
    check_shape,
)
from skinfield.simulate import Press
from skinfield.simulate.pressing.press import parts_of
from skinfield.simulate.rig import Pose
from skinfield.skin import Patch

# As files of cases spell them.
QUANTITIES: dict[str, Quantity] = {
    "capacitance": Capacitance(),
    "gap": Gap(),
    "stress": BaseStress(),
}


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
    shear : (x, y), N
        Tangential force on the skin, in the patch's plane.
    """

    position: tuple[float, float]
    force: float
    area: float = float("nan")
    kind: str = "body"
    shear: tuple[float, float] = (0.0, 0.0)

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
        nodes: int | None = None
        for name, shape, why in (
            ("plane", (2,), "x and y of the nodes, in metres"),
            ("pressure", (), "one per node, in Pa"),
            ("displacement", (3,), "three per node, in metres, or NaN if unknown"),
        ):
            value = np.array(as_floats(name, getattr(self, name)))
            check_shape(name, value, (nodes, *shape), why)
            check_finite(
                name, np.where(np.isnan(value), 0.0, value) if shape == (3,) else value, why
            )
            nodes = len(value)
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    @property
    def force(self) -> float:
        """Of all contacts, N."""
        return float(sum(contact.force for contact in self.contacts))

    @property
    def contact_area(self) -> float:
        """Of all contacts, m²; NaN where that of one is not known."""
        return float(sum(contact.area for contact in self.contacts))


NOTHING = Truth(
    cell=1e-3, plane=np.empty((0, 2)), pressure=np.empty(0), displacement=np.empty((0, 3)),
    contacts=(),
)  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class Case:
    """Readings of a patch with the truth beside them.

    Parameters
    ----------
    name : str
        Of the case; its file is called so, too.
    patch : Patch
    layer : Layer
        What the elastomer is, which an estimate may be told.
    quantity : str
        What a taxel reads: "capacitance" (ΔC/C₀), "gap" (indentation over thickness) or "stress"
        (Pa).
    readings : (L,) or (R, L) array, in the quantity's unit
        Of one instant, or of R that differ in their noise alone. NaN marks a taxel without answer.
    noise_std : float or (L,) array, in the quantity's unit
        Standard deviation of one reading, which a solver may be told. Kept as (L,).
    noisy : bool
        Whether the readings hold that noise; else they are exact.
    truth : Truth
    mechanics : BondedLayer
        How the elastomer is held: with or without an inextensible cover.
    history : (T, L) array, in the quantity's unit
        Readings before, of the same instant each for all draws; files do not hold them.
    history_s : (T,) array, s
        When they were made: negative, before the readings.

    Notes
    -----
    All arrays are copies, and read-only.
    """

    name: str
    patch: Patch
    layer: Layer
    quantity: str
    readings: Floats
    noise_std: Floats
    truth: Truth
    noisy: bool = False
    mechanics: BondedLayer = field(default_factory=BondedLayer)
    history: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    history_s: Floats = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if not self.name.strip() or set(self.name) & set("/\\\0"):
            raise InputError(f"name is {self.name!r}, expected a word that can name a file")
        check_choice("quantity", self.quantity, QUANTITIES, "what taxels read")
        if not isinstance(self.mechanics, BondedLayer):
            raise InputError(
                f"mechanics is {self.mechanics!r}, expected BondedLayer(): a case says what the "
                "skin is; another model is what a solver assumes"
            )
        readings = np.array(as_floats("readings", self.readings))
        wide = readings.ndim in (1, 2) and readings.shape[-1] == len(self.patch)
        if not wide or not len(readings):
            raise InputError(
                f"readings has shape {readings.shape}, expected ({len(self.patch)},) or "
                f"(draws, {len(self.patch)}): one column per taxel"
            )
        if np.isinf(readings).any():
            raise InputError("readings holds an infinity, expected numbers, or NaN for no answer")
        noise = np.array(as_floats("noise_std", self.noise_std))
        noise = np.full(len(self.patch), float(noise)) if noise.ndim == 0 else noise
        check_shape("noise_std", noise, (len(self.patch),), "one per taxel, or one for all")
        check_finite("noise_std", noise, "in the unit of the readings")
        check_positive("noise_std", float(noise.min()), "no reading is exact")
        history, times = np.array(self.history, np.float64), np.array(self.history_s, np.float64)
        if len(times):
            check_shape("history", history, (len(times), len(self.patch)), "as history_s")
        for key, value in (
            ("readings", readings), ("noise_std", noise), ("history", history), ("history_s", times)
        ):  # fmt: skip
            value.setflags(write=False)
            object.__setattr__(self, key, value)

    @classmethod
    def from_press(
        cls,
        name: str,
        press: Press,
        patch: Patch,
        quantity: str = "capacitance",
        pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        noise_std: ArrayLike | None = None,
    ) -> "Case":
        """Case of a simulated press, carried over the patch by a pose; its readings are exact.

        The layer is the same everywhere, so a press that is carried over the skin reads as taxels
        that are carried the other way: nothing is solved again.

        Parameters
        ----------
        press : skinfield.simulate.Press
        patch : Patch
        quantity : str
        pose : (x, y, angle), m, m, rad
            Of the press in the patch's plane: turned about the origin, then shifted.
        noise_std : float or (L,) array, optional
            Default the quantity's `typical_noise`.
        """
        if not isinstance(press.mechanics, BondedLayer):
            raise InputError("press.mechanics is no BondedLayer, expected what the skin truly is")
        where = Pose(*pose)
        taxels = where.taxels(patch.plane)
        readings = press.readings(taxels, patch.pad_diameter, quantity)
        typical = QUANTITIES[quantity].typical_noise
        return cls(
            name=name,
            patch=patch,
            layer=press.layer,
            quantity=quantity,
            readings=readings,
            noise_std=as_floats("noise_std", typical if noise_std is None else noise_std),
            truth=truth_of_press(press, where),
            mechanics=press.mechanics,
        )

    @property
    def draws(self) -> Floats:
        """Readings with a leading axis, (R, L); R is 1 where there is one reading."""
        return np.atleast_2d(self.readings)

    def with_noise(self, seed: int, draws: int = 1, noise_std: ArrayLike | None = None) -> "Case":
        """Case of readings (draws, L) with Gaussian noise; the truth stays.

        Parameters
        ----------
        seed : int
        draws : int
        noise_std : float or (L,) array, optional
            Default the case's own.

        Raises
        ------
        InputError
            If the readings hold noise already.
        """
        if self.noisy or self.readings.ndim != 1:
            raise InputError(f"case {self.name!r} holds noise already, expected exact readings")
        if draws < 1:
            raise InputError(f"draws is {draws}, expected 1 or more")
        noise = self.noise_std if noise_std is None else as_floats("noise_std", noise_std)
        rng = np.random.default_rng(seed)
        added = rng.standard_normal((draws, len(self.patch))) * noise
        history = self.history
        if len(history):
            history = history + rng.standard_normal(history.shape) * noise
        readings = self.readings + added
        return replace(self, readings=readings, noise_std=noise, history=history, noisy=True)


def truth_of_press(press: Press, pose: Pose) -> Truth:
    """All that is known of a simulated press where it is: one contact per indenter that touches."""
    displacement = press.displacement.copy()
    displacement[:, :2] = displacement[:, :2] @ pose.turn.T
    every = parts_of(press)
    touches = [one["force_N"] > 0.0 for one in every]
    parts = [one for one, touching in zip(every, touches, strict=True) if touching]
    places = pose.carried(np.array([(one["x_m"], one["y_m"]) for one in parts]).reshape(-1, 2))
    shears = press.shears[touches] @ pose.turn.T
    return Truth(
        cell=press.grid.pitch,
        plane=pose.carried(press.grid.plane),
        pressure=press.pressure,
        displacement=displacement,
        contacts=tuple(
            TrueContact((x, y), one["force_N"], one["area_m2"], one["body"], (along, across))
            for one, (x, y), (along, across) in zip(
                parts, places.tolist(), shears.tolist(), strict=True
            )
        ),
        source="skinfield.simulate.pressing.press",
    )
