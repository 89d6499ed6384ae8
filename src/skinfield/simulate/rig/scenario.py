"""All that a rig needs to know, in SI units."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from skinfield.errors import InputError, as_floats, check_positive, check_range, check_shape
from skinfield.layout import Patch
from skinfield.layout.generators import icub_hexagon
from skinfield.mechanics import BondedLayer, Layer, StandardLinearSolid, Viscoelastic
from skinfield.simulate.electronics import Electronics, icub_electronics
from skinfield.simulate.electronics.thermal import ROOM
from skinfield.simulate.indenters import Indenter, Sphere
from skinfield.simulate.rig.load_cell import LoadCell
from skinfield.simulate.rig.places import OverTaxels, Places, Pose
from skinfield.simulate.rig.profile import Profile

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+=,-]{0,39}", re.ASCII)
Words = tuple[tuple[str, object], ...]


@dataclass(frozen=True, kw_only=True)
class Tool:
    """An indenter that can be mounted.

    Parameters
    ----------
    name : str
        In file names and tables.
    indenter : Indenter
        Its own force or depth is ignored.
    words : tuple of (str, value)
        Settings that it was made from, where it is more than its fields tell: the file of a mesh.
    """

    name: str
    indenter: Indenter
    words: Words = ()

    def __post_init__(self) -> None:
        _check_name(self.name)


@dataclass(frozen=True, kw_only=True)
class Loads:
    """Loads of the presses at each place: forces, N, or else depths, m; the other is empty."""

    forces: tuple[float, ...] = ()
    depths: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if bool(self.forces) == bool(self.depths):
            raise InputError(
                f"forces is {self.forces} and depths is {self.depths}, expected one of the two"
            )
        for name in ("forces", "depths"):
            values = as_floats(name, getattr(self, name))
            check_shape(name, values, (None,), "one per press")
            for value in values:
                check_positive(name, float(value), "in newtons or metres")

    def __len__(self) -> int:
        return len(self.forces) + len(self.depths)


@dataclass(frozen=True, kw_only=True)
class Temperature:
    """Of the surroundings, from the start of a recording to its end, K, by a straight line."""

    start: float = ROOM
    end: float = ROOM

    def __post_init__(self) -> None:
        for name in ("start", "end"):
            check_range(name, getattr(self, name), 200.0, 500.0, "in kelvin: 25 °C is 298.15")


@dataclass(frozen=True, kw_only=True)
class Solving:
    """How finely contact is solved.

    Parameters
    ----------
    extent : float, m
        Side of the square of skin in which the indenter may touch.
    cell : float, m
        Side of a cell of the truth's fields; touch is solved more finely.
    rungs : int
        Loads at which a press is solved; between them readings are interpolated in √force.
    """

    extent: float = 24e-3
    cell: float = 0.5e-3
    rungs: int = 12

    def __post_init__(self) -> None:
        check_range("extent", self.extent, 1e-4, 1.0, "side of the square of skin, in metres")
        check_range("cell", self.cell, self.extent / 2000, self.extent / 4, "in metres")
        if isinstance(self.rungs, bool) or not isinstance(self.rungs, int | np.integer):
            raise InputError(f"rungs is {self.rungs!r}, expected a whole number from 4 to 200")
        check_range("rungs", self.rungs, 4, 200, "loads at which a press is solved")


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """A rig and its programme.

    Each tool presses in a recording of its own: at every place, with every load in order; all of
    that `repeats` times. The skin, its electronics and random places are the same in all of them.

    Parameters
    ----------
    name : str
    seed : int
        Of all that is random.
    repeats, first_repeat : int
        Recordings per tool, and the number of the first.
    patch : Patch
    layout : str
        Where the patch is from, for a file: a layout file, or a generator by name.
    patch_name : str
        Which patch of that layout; "" where it has one.
    layer : Layer
    cover : bool
        The layer's surface cannot stretch (a fabric on it).
    elastomer : Viscoelastic
        How the layer creeps; its relaxed modulus is the layer's.
    tools : tuple of Tool
    places : tuple of Places
    loads : Loads
    profile : Profile
    load_cell : LoadCell
    electronics : Electronics
    temperature : Temperature
    solving : Solving
    """

    name: str = "rig"
    seed: int = 0
    repeats: int = 1
    first_repeat: int = 0
    patch: Patch = field(default_factory=icub_hexagon, compare=False)
    layout: str = "icub_hexagon"
    patch_name: str = ""
    layer: Layer = field(default_factory=Layer)
    cover: bool = False
    elastomer: Viscoelastic = field(default_factory=StandardLinearSolid)
    tools: tuple[Tool, ...] = field(
        default_factory=lambda: (Tool(name="sphere6", indenter=Sphere(radius=6e-3)),)
    )
    places: tuple[Places, ...] = (OverTaxels(),)
    loads: Loads = field(default_factory=lambda: Loads(forces=(0.2, 0.5, 1.0)))
    profile: Profile = field(default_factory=Profile)
    load_cell: LoadCell = field(default_factory=LoadCell)
    electronics: Electronics = field(default_factory=icub_electronics)
    temperature: Temperature = field(default_factory=Temperature)
    solving: Solving = field(default_factory=Solving)

    def __post_init__(self) -> None:
        _check_name(self.name)
        for name, low, high in (
            ("seed", 0, 2**63 - 1), ("repeats", 1, 10_000), ("first_repeat", 0, 10_000),
        ):  # fmt: skip
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | np.integer):
                raise InputError(f"{name} is {value!r}, expected a whole number")
            check_range(name, int(value), low, high, "a whole number")
        names = [tool.name for tool in self.tools]
        if not names or len(set(names)) < len(names):
            raise InputError(f"tools are named {names}, expected one or more, of different names")
        if not self.places:
            raise InputError("places is empty, expected at least one place to press at")

    @property
    def mechanics(self) -> BondedLayer:
        """Model of the layer."""
        return BondedLayer(inextensible_cover=self.cover)

    @property
    def poses(self) -> list[Pose]:
        """Where to press, in order; random ones are drawn from a stream of their own."""
        found = []
        for row, places in enumerate(self.places):
            found += places.poses(self.patch, self.random(1, row))
        return found

    @property
    def presses(self) -> int:
        """Of one recording."""
        return len(self.poses) * len(self.loads)

    def random(self, *key: int) -> np.random.Generator:
        """Random numbers for one purpose: other purposes do not shift them."""
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=key))

    def runs(self) -> Iterator[tuple[str, "Scenario"]]:
        """Each recording as a name and a scenario of that recording alone."""
        numbered = self.repeats > 1 or self.first_repeat > 0
        for tool in self.tools:
            for repeat in range(self.first_repeat, self.first_repeat + self.repeats):
                name = f"{self.name}-{tool.name}" + (f"-{repeat}" if numbered else "")
                yield name, replace(self, tools=(tool,), repeats=1, first_repeat=repeat)


def _check_name(name: str) -> None:
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise InputError(
            f"name is {name!r}, expected up to 40 letters, digits and ._+=,- that begin with a "
            "letter or digit: it becomes part of the names of folders"
        )
