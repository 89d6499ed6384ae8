"""Scenario of a rig, in SI units: places, one press in time, load cell."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import BondedLayer, Layer, StandardLinearSolid
from skinfield.errors import (
    Floats,
    InputError,
    Ints,
    as_floats,
    check_finite,
    check_positive,
    check_range,
    check_shape,
)
from skinfield.settings import Positive, Range, Section
from skinfield.simulate.electronics.array import Electronics, icub_electronics
from skinfield.simulate.electronics.noise import ROOM
from skinfield.simulate.habits import Habits, Tolerances
from skinfield.simulate.indenters.body import Indenter
from skinfield.simulate.indenters.shapes import Sphere
from skinfield.skin import Patch
from skinfield.skin.generators import icub_hexagon


@dataclass(frozen=True, eq=False)
class LoadSeries:
    """What a load cell has recorded.

    Attributes
    ----------
    stamp_ns : (R,) int64 array, ns
    force : (R,) array, N
        Into the skin, as measured.
    saturated : (R,) bool array
        At the end of the cell's range: the true force is higher.
    """

    stamp_ns: NDArray[np.int64]
    force: Floats
    saturated: NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class LoadCell(Section):
    """A cell for compression.

    Parameters
    ----------
    full_scale : float, N
        Beyond it, to either side, the cell says no more.
    rate : float, 1/s
    noise : float, N
        Standard deviation of a sample.
    offset : float, N
        What it says of no load.
    gain_error : float
        Relative: 0.01 says 1 % too much.
    resolution : float, N
        Step of its numbers; 0 for none.
    delay : float, s
        By which its stamps are late.
    """

    full_scale: Annotated[float, Positive("in newtons")] = 3.0
    rate: Annotated[float, Positive("samples per second")] = 100.0
    noise: float = 3e-3
    offset: float = 0.0
    gain_error: Annotated[float, Range(-0.5, 0.5, "relative; 0 is off")] = 0.0
    resolution: float = 0.0
    delay: Annotated[float, Range(0.0, 10.0, "in seconds; 0 is off")] = 0.0

    def check(self) -> None:
        """See `Section`."""
        check_range("rate", self.rate, 0.0, 1e5, "samples per second")
        for name in ("noise", "resolution"):
            check_range(name, getattr(self, name), 0.0, self.full_scale, "in newtons; 0 is off")
        check_range("offset", self.offset, -self.full_scale, self.full_scale, "in newtons")

    def measure(self, time: Floats, force: Floats, rng: np.random.Generator) -> LoadSeries:
        """Sample a force.

        Parameters
        ----------
        time, force : (T,) arrays, s and N
            Of the true force into the skin; stamp 0 is time 0.
        rng : numpy Generator
        """
        own = np.arange(time[0], time[-1], 1.0 / self.rate)
        level = (1.0 + self.gain_error) * np.interp(own, time, force) + self.offset
        level = level + self.noise * rng.standard_normal(len(own))
        if self.resolution:
            level = self.resolution * np.rint(level / self.resolution)
        shown = np.clip(level, -self.full_scale, self.full_scale)
        stamps = np.rint((own + self.delay) * 1e9).astype(np.int64)
        return LoadSeries(stamps, shown, np.abs(level) >= self.full_scale)


LONGEST = 3600.0  # s, of one part of a press


@dataclass(frozen=True, kw_only=True)
class LoadProfile(Section):
    """Durations of the parts of a press, and how load rises and falls in it.

    Parameters
    ----------
    rest : float, s
        Nothing touches, before the first press and after the last: baselines are taken there.
    approach : float, s
        From the clearance down to the surface.
    ramp : float, s
        From touch to full load.
    hold : float, s
    release : float, s
        From full load to none.
    pause : float, s
        Up to the clearance again, while the positioners move to the next place.
    smooth : bool
        Load follows a quintic without jumps of speed or acceleration; else straight lines, a
        trapezoid.
    clearance : float, m
        Height above the surface between presses.
    """

    rest: Annotated[float, Range(0.0, LONGEST, "in seconds")] = 2.5
    approach: Annotated[float, Range(0.0, LONGEST, "in seconds")] = 0.5
    ramp: float = 0.5
    hold: Annotated[float, Range(0.0, LONGEST, "in seconds")] = 2.0
    release: float = 0.5
    pause: Annotated[float, Range(0.0, LONGEST, "in seconds")] = 0.5
    smooth: bool = True
    clearance: Annotated[float, Range(0.0, 1.0, "in metres")] = 5e-3

    def check(self) -> None:
        """See `Section`."""
        for name in ("ramp", "release"):
            check_positive(name, getattr(self, name), "in seconds; load cannot jump")
            check_range(name, getattr(self, name), 0.0, LONGEST, "in seconds")

    @property
    def period(self) -> float:
        """From the start of one press to that of the next, s."""
        return self.approach + self.ramp + self.hold + self.release + self.pause

    def duration(self, presses: int) -> float:
        """Of a recording of some presses, s."""
        return 2 * self.rest + presses * self.period

    def starts(self, presses: int) -> Floats:
        """When each press begins to come down, (presses,) s."""
        return np.asarray(self.rest + self.period * np.arange(presses), dtype=np.float64)

    def load(self, time: Floats) -> Floats:
        """Load at times (T,) s after the start of a press, as a part of the full one."""
        touch = self.approach
        full, over = touch + self.ramp, touch + self.ramp + self.hold
        times = [touch, full, over, over + self.release]
        return self._shaped(np.interp(time, times, [0.0, 1.0, 1.0, 0.0]))

    def height(self, time: Floats) -> Floats:
        """Of the indenter above the surface where it does not press, (T,) m; 0 where it does."""
        touch, off = self.approach, self.period - self.pause
        times = [0.0, touch, off, self.period]
        return self.clearance * self._shaped(np.interp(time, times, [1.0, 0.0, 0.0, 1.0]))

    def _shaped(self, part: Floats) -> Floats:
        return part**3 * (10.0 - 15.0 * part + 6.0 * part**2) if self.smooth else part


TRIES = 10_000
NEXT = 1.1  # pitches between taxels that are next to each other


class Pose(NamedTuple):
    """Of the indenter on the patch: x and y in the patch's plane, m, and angle about z, rad.

    As the layer is the same everywhere, a press there is one at the origin with the taxels moved
    the other way.
    """

    x: float
    y: float
    angle: float = 0.0

    @property
    def turn(self) -> Floats:
        """Rotation matrix (2, 2)."""
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        return np.array([[cos, -sin], [sin, cos]])

    def carried(self, plane: Floats) -> Floats:
        """Points (N, 2) m of a press at the origin, carried with it."""
        return np.asarray(plane @ self.turn.T + [self.x, self.y])

    def taxels(self, plane: ArrayLike) -> Floats:
        """Taxels at (L, 2) m of the patch's plane as the indenter sees them, (L, 2) m."""
        return np.asarray((as_floats("plane", plane) - [self.x, self.y]) @ self.turn)


class Places(Protocol):
    """Anything that chooses poses on a patch."""

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """Where to press, in order."""
        ...


@dataclass(frozen=True, kw_only=True)
class At:
    """Given places.

    Parameters
    ----------
    positions : tuple of (x, y), m
        In the patch's plane.
    angle : float, rad
    """

    positions: tuple[tuple[float, float], ...]
    angle: float = 0.0

    def __post_init__(self) -> None:
        values = as_floats("positions", self.positions)
        check_shape("positions", values, (None, 2), "x and y of each place, in metres")
        check_finite("positions", values, "x and y of each place, in metres")
        if not len(values):
            raise InputError("positions is empty, expected at least one place")

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """See `Places.poses`."""
        return [Pose(x, y, self.angle) for x, y in self.positions]


@dataclass(frozen=True, kw_only=True)
class OverTaxels:
    """Over the middle of taxels: given rows, or the one nearest to the patch's middle."""

    taxels: tuple[int, ...] = ()
    angle: float = 0.0

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """See `Places.poses`."""
        groups = [(row,) for row in self.taxels]
        return _over_groups(patch, groups, np.arange(len(patch))[:, None], self.angle)


@dataclass(frozen=True, kw_only=True)
class BetweenTwo:
    """Half-way between two taxels: given pairs, or the neighbours nearest to the middle."""

    pairs: tuple[tuple[int, int], ...] = ()
    angle: float = 0.0

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """See `Places.poses`."""
        return _over_groups(patch, self.pairs, patch.neighbours, self.angle)


@dataclass(frozen=True, kw_only=True)
class BetweenThree:
    """Amid three taxels: given triples, or the triangle nearest to the patch's middle."""

    triples: tuple[tuple[int, int, int], ...] = ()
    angle: float = 0.0

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """See `Places.poses`."""
        return _over_groups(patch, self.triples, patch.triangles, self.angle)


@dataclass(frozen=True, kw_only=True)
class Random(Section):
    """Drawn evenly from where taxels are.

    Parameters
    ----------
    count : int
    within : float, m
        Of the centre of some taxel.
    turned : bool
        At random angles too.
    """

    count: Annotated[int, Range(1, 10_000, "places to press at")] = 10
    within: Annotated[float, Range(1e-9, 1.0, "of the centre of some taxel, in metres")] = 3e-3
    turned: bool = False

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """See `Places.poses`."""
        plane = patch.plane
        low, high = plane.min(axis=0) - self.within, plane.max(axis=0) + self.within
        found: list[Pose] = []
        for _ in range(TRIES * self.count):
            place, turn = rng.uniform(low, high), float(rng.uniform(-np.pi, np.pi))
            if np.hypot(*(plane - place).T).min() <= self.within:
                found.append(Pose(float(place[0]), float(place[1]), turn if self.turned else 0.0))
                if len(found) == self.count:
                    return found
        raise InputError(
            f"within is {self.within:g} m, expected a wider distance: {TRIES} draws per place "
            f"found {len(found)} of {self.count} that near to a taxel"
        )


@dataclass(frozen=True, kw_only=True)
class Raster(Section):
    """A lattice of `rows` by `columns` over the patch's middle; `step` in m, and an `angle`."""

    rows: Annotated[int, Range(1, 10_000, "places to press at")] = 3
    columns: Annotated[int, Range(1, 10_000, "places to press at")] = 3
    step: Annotated[float, Range(1e-9, 1.0, "between places, in metres")] = 5e-3
    angle: float = 0.0

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """See `Places.poses`; row by row, to and fro, as a positioner goes."""
        middle = patch.plane.mean(axis=0)
        across = (np.arange(self.columns) - (self.columns - 1) / 2) * self.step + middle[0]
        along = (np.arange(self.rows) - (self.rows - 1) / 2) * self.step + middle[1]
        return [
            Pose(float(x), float(y), self.angle)
            for row, y in enumerate(along)
            for x in (across if row % 2 == 0 else across[::-1])
        ]


def _over_groups(
    patch: Patch, wanted: Sequence[tuple[int, ...]], every: Ints, angle: float
) -> list[Pose]:
    """Poses in the middle of groups of taxels, or of the most central of all groups (N, G).

    That one is of taxels that are a pitch from each other, if there are such.
    """
    if wanted:
        groups = np.array(wanted, np.int64)
    elif len(every):
        corners = patch.plane[every]
        wide = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=-1).max(axis=(1, 2))
        close = wide <= NEXT * patch.pitch
        groups = every[close] if close.any() else every
        middles = patch.plane[groups].mean(axis=1)
        far = np.hypot(*(middles - patch.plane.mean(axis=0)).T)
        groups = groups[[int(np.argmin(np.round(far, 9)))]]
    else:
        raise InputError(
            f"patch {patch.name!r} has no such taxels next to each other, expected some: "
            "name them, or choose other places"
        )
    if (groups < 0).any() or (groups >= len(patch)).any():
        raise InputError(
            f"taxels holds {groups.tolist()}, expected rows from 0 to {len(patch) - 1} of patch "
            f"{patch.name!r}"
        )
    return [Pose(float(x), float(y), angle) for x, y in patch.plane[groups].mean(axis=1)]


NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+=,-]{0,39}", re.ASCII)


@dataclass(frozen=True, kw_only=True)
class Tool:
    """An indenter that can be mounted.

    Parameters
    ----------
    name : str
        In file names and tables.
    indenter : Indenter
        Its own force or depth is ignored.
    """

    name: str
    indenter: Indenter

    def __post_init__(self) -> None:
        _check_name(self.name)


@dataclass(frozen=True, kw_only=True)
class Loads:
    """Loads of the presses at each place.

    Parameters
    ----------
    forces, depths : tuple of float, N and m
        One of the two; the other is empty.
    shear_part : (x, y)
        Tangential force along the axes of the indenter's plane, as a part of the normal force: a
        horizontal actuator pushes in proportion to the vertical one. With forces only.
    friction : float
        Coulomb's coefficient; 0 is no limit: all that touches sticks.
    """

    forces: tuple[float, ...] = ()
    depths: tuple[float, ...] = ()
    shear_part: tuple[float, float] = (0.0, 0.0)
    friction: float = 0.0

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
        part = as_floats("shear_part", self.shear_part)
        check_shape("shear_part", part, (2,), "parts of the normal force along x and y")
        check_finite("shear_part", part, "parts of the normal force along x and y")
        why = "Coulomb's coefficient; 0 is no limit"
        check_range("friction", self.friction, 0.0, 10.0, why)
        if part.any() and self.depths:
            raise InputError(
                f"shear_part is {self.shear_part} beside depths, expected forces: it is a part of "
                "them"
            )

    def __len__(self) -> int:
        return len(self.forces) + len(self.depths)


@dataclass(frozen=True, kw_only=True)
class Temperature(Section):
    """Of the surroundings, from the start of a recording to its end, K, by a straight line."""

    start: Annotated[float, Range(200.0, 500.0, "in kelvin: 25 °C is 298.15")] = ROOM
    end: Annotated[float, Range(200.0, 500.0, "in kelvin: 25 °C is 298.15")] = ROOM


@dataclass(frozen=True, kw_only=True)
class ContactAccuracy(Section):
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

    extent: Annotated[float, Range(1e-4, 1.0, "side of the square of skin, in metres")] = 24e-3
    cell: float = 0.5e-3
    rungs: Annotated[int, Range(4, 200, "loads at which a press is solved")] = 12

    def check(self) -> None:
        """See `Section`."""
        check_range("cell", self.cell, self.extent / 2000, self.extent / 4, "in metres")


@dataclass(frozen=True, kw_only=True)
class Scenario(Section):
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
    layer : Layer
        As stated.
    tolerances : Tolerances
        By how much layer and places are not as stated.
    cover : bool
        The layer's surface cannot stretch (a fabric on it).
    elastomer : StandardLinearSolid
        How the layer creeps; its relaxed modulus is the layer's.
    tools : tuple of Tool
    places : tuple of Places
    loads : Loads
    profile : LoadProfile
    load_cell : LoadCell
    electronics : Electronics
    temperature : Temperature
    solving : ContactAccuracy
    """

    name: str = "rig"
    seed: Annotated[int, Range(0, 2**63 - 1, "of all that is random")] = 0
    repeats: Annotated[int, Range(1, 10_000, "recordings per tool")] = 1
    first_repeat: Annotated[int, Range(0, 10_000, "number of the first recording")] = 0
    patch: Patch = field(default_factory=icub_hexagon, compare=False)
    layer: Layer = field(default_factory=Layer)
    tolerances: Tolerances = field(default_factory=Tolerances)
    cover: bool = False
    elastomer: StandardLinearSolid = field(default_factory=StandardLinearSolid)
    tools: tuple[Tool, ...] = field(
        default_factory=lambda: (Tool(name="sphere6", indenter=Sphere(radius=6e-3)),)
    )
    places: tuple[Places, ...] = (OverTaxels(),)
    loads: Loads = field(default_factory=lambda: Loads(forces=(0.2, 0.5, 1.0)))
    profile: LoadProfile = field(default_factory=LoadProfile)
    load_cell: LoadCell = field(default_factory=LoadCell)
    electronics: Electronics = field(default_factory=icub_electronics)
    temperature: Temperature = field(default_factory=Temperature)
    solving: ContactAccuracy = field(default_factory=ContactAccuracy)

    def check(self) -> None:
        """See `Section`."""
        _check_name(self.name)
        names = [tool.name for tool in self.tools]
        if not names or len(set(names)) < len(names):
            raise InputError(f"tools are named {names}, expected one or more, of different names")
        if not self.places:
            raise InputError("places is empty, expected at least one place to press at")

    def with_habits(self, habits: Habits) -> "Scenario":
        """The same with a skin's habits, and with fingers as its tools where they have some."""
        warmer = habits.warming * self.profile.duration(self.presses) if habits.warming else 0.0
        fingers = [Tool(name=f"finger-{n}", indenter=f) for n, f in enumerate(habits.fingers, 1)]
        return replace(
            self,
            tolerances=habits.tolerances,
            elastomer=habits.elastomer or self.elastomer,
            electronics=habits.electronics(self.electronics),
            temperature=replace(self.temperature, end=self.temperature.end + warmer),
            tools=tuple(fingers) or self.tools,
        )

    @property
    def true_layer(self) -> Layer:
        """Layer as it is: `layer` within the tolerances."""
        return self.tolerances.layer(self.layer, self.random(3))

    @property
    def true_plane(self) -> Floats:
        """Where the taxels are, (L, 2) m: places of the patch within the tolerances."""
        return self.tolerances.plane(self.patch, self.random(4))

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
