"""Sets of simulated cases: each standard kind, and random presses of a seed in any world."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from skinfield.elastic import BondedLayer, Layer, StandardLinearSolid
from skinfield.errors import Floats, InputError
from skinfield.lab.cases import NOTHING, Case
from skinfield.simulate import Bar, Cone, Cylinder, Press, Ring, Sphere, press, press_path
from skinfield.simulate.rig import Pose
from skinfield.skin import Patch

SILICONE = Layer(2e-3, 100e3, 0.5)
AROUND = 14e-3  # m: from a press's middle to the sides of the square of skin that is solved
INSET = 0.6  # of the patch's half width: presses stay away from its rim
SINGLE, SEVERAL, EXTENDED = "single", "several", "extended"
# 12 : 5 : 3, mixed so that any few presses in a row hold about these shares.
GROUPS = tuple({"1": SINGLE, "+": SEVERAL, "=": EXTENDED}[sign] for sign in "1+1=1+11+1=11+1=1+11")
BALLS = (2e-3, 15e-3)  # m: radius, log-uniform
LOADS = (0.2, 3.0)  # N: of each body, log-uniform up to what the layer bears
APART = (10e-3, 14e-3)  # m: least distance of several bodies, uniform
DEEPEST = 0.7  # thicknesses: beyond, linear elasticity is more than 5 % off for balls
CELL = 0.25e-3  # m: of the truth's grid
TRIES, LOADINGS = 200, 40  # until places, and loads, are such as asked for


@dataclass(frozen=True)
class CaseKind:
    """A kind of press: what it is called, the bodies about the origin, the elastomer."""

    name: str
    bodies: tuple[Any, ...]
    layer: Layer = SILICONE
    cover: bool = False


def ball(diameter_mm: float, force: float, x_mm: float = 0.0, y_mm: float = 0.0) -> Sphere:
    """A ball at a place."""
    return Sphere(radius=diameter_mm / 2e3, force=force, position=(x_mm / 1e3, y_mm / 1e3))


def flat(diameter_mm: float, force: float, x_mm: float = 0.0) -> Cylinder:
    """A flat cylinder at a place."""
    return Cylinder(radius=diameter_mm / 2e3, force=force, position=(x_mm / 1e3, 0.0))


ONE = (ball(12, 1.0),)
KINDS = (
    CaseKind("ball12_1N", ONE),
    CaseKind("ball6_1N", (ball(6, 1.0),)),
    CaseKind("flat3_0.5N", (flat(3, 0.5),)),
    CaseKind("flat12_3N", (flat(12, 3.0),)),
    CaseKind("two_balls_12mm_apart", (ball(12, 1.0, -6), ball(12, 1.0, 6))),
    CaseKind("bar_16x3_2N", (Bar(length=16e-3, width=3e-3, force=2.0),)),
    CaseKind("ring_10_2N", (Ring(inner_radius=4e-3, outer_radius=5e-3, force=2.0),)),
    CaseKind("ball12_thick_4mm", ONE, Layer(4e-3, 100e3, 0.5)),
    CaseKind("ball12_foam_nu0.3", ONE, Layer(2e-3, 100e3, 0.3)),
    CaseKind("ball12_0.5N", (ball(12, 0.5),)),
    CaseKind("ball12_3N", (ball(12, 3.0),)),
    CaseKind("ball20_2N", (ball(20, 2.0),)),
    CaseKind("ball6_0.5N", (ball(6, 0.5),)),
    CaseKind("ball6_1.8N", (ball(6, 1.8),)),
    CaseKind("flat6_1N", (flat(6, 1.0),)),
    CaseKind("two_balls_unequal", (ball(6, 0.5, -8), ball(12, 2.0, 8))),
    CaseKind("three_balls", (ball(6, 0.7, -8, -5), ball(6, 0.7, 8, -5), ball(6, 0.7, 0, 8))),
    CaseKind("ball_and_flat", (ball(6, 0.8, -8), flat(6, 1.0, 7))),
    CaseKind("cone_1N", (Cone(radius=6e-3, half_angle=np.radians(75.0), force=1.0),)),
    CaseKind("ball12_thin_1mm", ONE, Layer(1e-3, 100e3, 0.5)),
    CaseKind("ball12_nu0.45", ONE, Layer(2e-3, 100e3, 0.45)),
    CaseKind("ball12_covered", ONE, cover=True),
)


def standard_cases(
    patch: Patch,
    count: int = len(KINDS),
    seed: int = 0,
    quantity: str = "capacitance",
    noise_std: float | None = None,
    draws: int = 1,
    cell: float = 0.25e-3,
) -> Iterator[Case]:
    """Make cases one after another; the same arguments give the same cases.

    The kinds of `KINDS` come in turn, each at a place and an angle of its own; beyond their number
    they come again at others.

    Parameters
    ----------
    patch : Patch
        Presses stay in the middle of it, with 0.6 of its width and height.
    count : int
    seed : int
    quantity : "capacitance", "gap" or "stress"
    noise_std : float, in the quantity's unit, optional
        Default its `typical_noise`.
    draws : int
        Readings per case that differ in their noise; 0 for one exact reading.
    cell : float, m
        Of the truth.
    """
    low, high = patch.plane.min(axis=0), patch.plane.max(axis=0)
    for index in range(count):
        kind = KINDS[index % len(KINDS)]
        rng = np.random.default_rng([seed, index])
        x, y = ((low + high) / 2 + rng.uniform(-INSET / 2, INSET / 2, 2) * (high - low)).tolist()
        pose = Pose(x, y, float(rng.uniform(0.0, 2 * np.pi)))
        name, solved = f"{index:03d}_{kind.name}", _solved(kind, cell)
        case = Case.from_press(name, solved, patch, quantity, pose, noise_std)
        yield case.with_noise(seed * 1_000_003 + index, draws) if draws else case


@lru_cache(maxsize=len(KINDS))
def _solved(kind: CaseKind, cell: float) -> Press:
    """A kind of press at the origin, once."""
    cover = BondedLayer(inextensible_cover=kind.cover)
    return press(kind.layer, list(kind.bodies), extent=2 * AROUND, cell=cell, mechanics=cover)


@dataclass(frozen=True, kw_only=True)
class World:
    """What skin and touch truly are, where a solver is told that they are as stated.

    Parameters
    ----------
    poisson_ratio : float, optional
        Of the layer. Default as stated.
    cover : bool
        An inextensible cover lies on it.
    shear : float
        Tangential force of each body as a part of its normal force, in a random direction.
    friction : float, optional
        Coulomb's coefficient. Default none: all that touches sticks.
    steps : int
        Of the load, with friction from the first touch on; 0 for bodies that are pressed on without
        friction and then pushed.
    elastomer : StandardLinearSolid, optional
        How the layer creeps under a load that comes at once and stands. Its modulus is stated as it
        is after long. Default not at all.
    after : float, s
        From the load, or its release, to the reading.
    released : bool
        The load stood for long, and is off again.
    stated : bool
        Creep is stated, too, and readings go before: from rest on, with their times.
    """

    poisson_ratio: float | None = None
    cover: bool = False
    shear: float = 0.0
    friction: float | None = None
    steps: int = 0
    elastomer: StandardLinearSolid | None = None
    after: float = 0.0
    released: bool = False
    stated: bool = False

    def layer(self, stated: Layer) -> Layer:
        """The layer as it is."""
        if self.poisson_ratio is None:
            return stated
        return replace(stated, poisson_ratio=self.poisson_ratio)

    def press(self, stated: Layer, bodies: list[Any], extent: float, cell: float) -> Press:
        """Solve for bodies with their forces and shears; after release, what is left of it."""
        solved = self._solved(stated, bodies, extent, cell)
        if not self.released:
            return solved
        # Nothing presses: what is left decays everywhere alike, whatever touched (linear creep).
        return _scaled(solved, self.share)

    def _solved(self, stated: Layer, bodies: list[Any], extent: float, cell: float) -> Press:
        where = extent, cell, BondedLayer(inextensible_cover=self.cover), self.friction
        if not self.steps:
            return press(self.layer(stated), bodies, *where)
        path = [
            [replace(body, force=body.force * step / self.steps) for body in bodies]
            for step in range(1, self.steps + 1)
        ]
        return press_path(self.layer(stated), path, *where)[-1]

    @property
    def share(self) -> float:
        """Elastic force of the deformation at the reading, as a part of the load.

        See `StandardLinearSolid`: of a step 1 - (1 - E∞/E₀) exp(-t/τ), and the rest of it once the
        step is taken back.
        """
        if self.elastomer is None:
            return 1.0
        solid = self.elastomer
        left = (1.0 - solid.relaxed_fraction) * np.exp(-self.after / solid.retardation_time)
        return float(left if self.released else 1.0 - left)

    def case(self, made: "RandomPress", stated: Layer, case: Case) -> Case:
        """A case of this world's press as it is stated: by the layer without cover, and the load.

        Parameters
        ----------
        made : RandomPress
        stated : Layer
        case : Case
            Of the press.
        """
        truth = case.truth
        if self.released:
            truth = NOTHING
        elif self.share < 1.0:
            contacts = tuple(
                replace(contact, force=float(force))
                for contact, force in zip(
                    truth.contacts, made.press.forces / self.share, strict=True
                )
            )
            truth = replace(truth, pressure=truth.pressure / self.share, contacts=contacts)
        seen = replace(case, layer=stated, mechanics=BondedLayer(), truth=truth)
        return self._with_history(made, stated, seen) if self.stated else seen

    def _with_history(self, made: "RandomPress", stated: Layer, case: Case) -> Case:
        """The case with its creep stated, and with readings from rest on."""
        solid, press, at = self.elastomer, made.press, made.pose.taxels(case.patch.plane)
        assert solid is not None  # what creeps is stated
        seconds, reads = _times(self.after, self.released), (case.patch.pad_diameter, case.quantity)
        parts = np.linspace(solid.relaxed_fraction, 1.0 if self.released else self.share, 3)
        solved = [self._solved(stated, *_bodies_of(press, part / self.share)) for part in parts]
        terms = np.polynomial.polynomial.polyfit(parts, [p.readings(at, *reads) for p in solved], 2)
        history = np.zeros((len(seconds), len(at)))
        for row, now in enumerate(seconds.tolist()):
            if self.released and now > STOOD:
                left = self.share * np.exp((self.after + STOOD - now) / solid.retardation_time)
                history[row] = _scaled(solved[-1], left).readings(at, *reads)
            elif now > 0.0:
                creep = 1.0 - (1.0 - parts[0]) * np.exp(-now / solid.retardation_time)
                history[row] = np.polynomial.polynomial.polyval(creep, terms)
        layer = replace(case.layer, relaxation=solid)
        end = self.after + (STOOD if self.released else 0.0)
        return replace(case, layer=layer, history=history, history_s=seconds - end)


INTERVAL, SLOW, RESTED = 0.02, 0.25, 5  # s between readings, while nothing changes; before a touch
STOOD = 8.0  # s: what is long


def _times(after: float, released: bool) -> Floats:
    """Times (T,) s, since the load came, of the readings before the last one."""
    end = after + (STOOD if released else 0.0)
    dense = end - INTERVAL * np.arange(1.0, np.ceil(after / INTERVAL) + RESTED)[::-1]
    if not released:
        return np.asarray(dense)
    since = INTERVAL * (np.arange(-RESTED, 10.0) + 0.5)
    return np.concatenate([since, np.arange(SLOW, dense[0], SLOW), dense])


def _bodies_of(press: Press, part: float) -> tuple[list[Any], float, float]:
    """Bodies of a press with a part of their forces, its extent and its cell."""
    every = zip(press.indenters, press.forces.tolist(), strict=True)
    bodies = [replace(body, force=part * force) for body, force in every]
    return bodies, press.grid.pitch * max(press.grid.shape), press.grid.pitch


def _scaled(press: Press, part: float) -> Press:
    """The field of a part of all tractions, whatever it takes to make them."""
    return replace(
        press, touches=tuple(replace(t, traction=part * t.traction) for t in press.touches)
    )


CREEP = StandardLinearSolid(relaxed_fraction=0.85, time_constant=1.0)
WORLDS = {
    "as-stated": World(),
    "sticking": World(shear=0.5),
    "slipping": World(shear=0.5, friction=0.5),
    "friction": World(friction=0.5, steps=4),
    "nu-0.49": World(poisson_ratio=0.49),
    "nu-0.45": World(poisson_ratio=0.45),
    "nu-0.40": World(poisson_ratio=0.40),
    "cover": World(cover=True),
    "creep-0.1s": World(elastomer=CREEP, after=0.1),
    "creep-1s": World(elastomer=CREEP, after=1.0),
    "released-0.1s": World(elastomer=CREEP, after=0.1, released=True),
    "creep-0.1s-stated": World(elastomer=CREEP, after=0.1, stated=True),
    "creep-1s-stated": World(elastomer=CREEP, after=1.0, stated=True),
    "released-0.1s-stated": World(elastomer=CREEP, after=0.1, released=True, stated=True),
}
AS_STATED = WORLDS["as-stated"]


class RandomPress(NamedTuple):
    """A press that is solved about the origin, and where it is on the patch.

    Attributes
    ----------
    name : str
    group : "single", "several" or "extended"
        One ball or cone; two or three bodies; a flat, a bar or a ring.
    press : Press
    pose : Pose
    """

    name: str
    group: str
    press: Press
    pose: Pose


def random_press(
    patch: Patch,
    index: int,
    seed: int = 0,
    layer: Layer = SILICONE,
    cell: float = CELL,
    world: World = AS_STATED,
    group: str | None = None,
) -> RandomPress:
    """Make one press of a campaign; the same arguments give the same press.

    Of twenty, twelve are single balls (some cones), five are two or three bodies 10 to 14 mm apart
    or more, and three are flats with sharp or rounded edges, bars and rings. Radii of balls (2 to
    15 mm) and loads (0.2 to 3 N each) are log-uniform; loads are drawn again where a body sinks
    deeper than 0.7 of the layer.

    Parameters
    ----------
    patch : Patch
        Bodies stay in the middle of it, with 0.6 of its width and height.
    index : int
        Of the press in its campaign.
    seed : int
    layer : Layer
    cell : float, m
        Of the truth's grid.
    world : World
        In which it happens. Places, bodies and first loads are the same in all of them.
    group : "single", "several" or "extended", optional
        Default each in its turn.
    """
    rng = np.random.default_rng([seed, index])
    group = GROUPS[index % len(GROUPS)] if group is None else group
    low, high = patch.plane.min(axis=0), patch.plane.max(axis=0)
    middle, half = (low + high) / 2, INSET / 2 * (high - low)
    places, apart = _places(rng, group, half)
    centre = places.mean(axis=0)
    bodies = [
        replace(body, position=(float(x), float(y)))
        for body, (x, y) in zip(
            _bodies(rng, group, len(places), apart), places - centre, strict=True
        )
    ]
    extent = 2 * (float(np.abs(places - centre).max()) + AROUND)
    ways = np.random.default_rng([seed, index, 2]).uniform(0.0, 2 * np.pi, len(bodies))
    solved = _pressed(rng, layer, bodies, extent, cell, world, ways)
    angle = float(rng.uniform(0.0, 2 * np.pi)) if group == EXTENDED else 0.0
    x, y = (middle + centre).tolist()
    what = "_".join(sorted({body.kind.replace(" ", "-") for body in bodies}))
    load = solved.force / world.share
    name = f"{index:04d}_{len(bodies) if len(bodies) > 1 else ''}{what}_{load:.2f}N"
    return RandomPress(name, group, solved, Pose(x, y, angle))


def random_cases(
    patch: Patch,
    count: int = 200,
    seed: int = 0,
    quantity: str = "capacitance",
    noise_std: float | None = None,
    draws: int = 1,
    layer: Layer = SILICONE,
    cell: float = CELL,
) -> Iterator[Case]:
    """Make cases of random presses one after another; see `random_press`.

    Parameters
    ----------
    patch : Patch
    count, seed : int
    quantity : "capacitance", "gap" or "stress"
    noise_std : float, in the quantity's unit, optional
        Default its `typical_noise`.
    draws : int
        Readings per case that differ in their noise; 0 for one exact reading.
    layer, cell
        See `random_press`.
    """
    for index in range(count):
        made = random_press(patch, index, seed, layer, cell)
        case = Case.from_press(made.name, made.press, patch, quantity, made.pose, noise_std)
        yield case.with_noise(seed * 1_000_003 + index, draws) if draws else case


def _places(rng: np.random.Generator, group: str, half: Floats) -> tuple[Floats, float]:
    """Places (N, 2) m of the bodies about the patch's middle, and their least distance."""
    if group != SEVERAL:
        return rng.uniform(-half, half)[None], np.inf
    count, apart = int(rng.choice([2, 3], p=[0.6, 0.4])), float(rng.uniform(*APART))
    for _ in range(TRIES):
        places = rng.uniform(-half, half, (count, 2))
        distance = np.linalg.norm(places[:, None] - places, axis=2)
        if distance[np.triu_indices(count, 1)].min() >= apart:
            return places, apart
    raise InputError(
        f"the middle of the patch is {2e3 * half[0]:.0f} x {2e3 * half[1]:.0f} mm, expected room "
        f"for {count} bodies that are {apart * 1e3:.0f} mm apart: take a larger patch"
    )


def _bodies(rng: np.random.Generator, group: str, count: int, apart: float) -> list[Any]:
    """Bodies at the origin, without a load; several do not overlap."""
    makers, weights = MAKERS[group]
    chosen = [makers[int(rng.choice(len(makers), p=weights))] for _ in range(count)]
    return [make(rng, 0.48 * apart) for make in chosen]


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _ball(rng: np.random.Generator, widest: float) -> Sphere:
    return Sphere(radius=_log(rng, BALLS[0], min(BALLS[1], widest)))


def _cone(rng: np.random.Generator, widest: float) -> Cone:
    half_angle = float(np.radians(rng.uniform(65.0, 80.0)))
    return Cone(radius=min(7e-3, widest), half_angle=half_angle)


def _flat(rng: np.random.Generator, widest: float) -> Cylinder:
    radius = _log(rng, 2e-3, min(7e-3, widest))
    return Cylinder(radius=radius, edge_radius=_edge(rng, radius / 2))


def _bar(rng: np.random.Generator, _: float) -> Bar:
    length, width = float(rng.uniform(8e-3, 20e-3)), float(rng.uniform(2e-3, 4e-3))
    return Bar(length=length, width=width, edge_radius=_edge(rng, width / 2))


def _ring(rng: np.random.Generator, _: float) -> Ring:
    outer, wall = float(rng.uniform(4e-3, 7e-3)), float(rng.uniform(0.8e-3, 2e-3))
    return Ring(inner_radius=outer - wall, outer_radius=outer, edge_radius=_edge(rng, wall / 2))


def _edge(rng: np.random.Generator, most: float) -> float:
    """Radius of an edge; every other one is sharp."""
    rounded = bool(rng.integers(2))
    return float(rng.uniform(0.2, 1.0) * most) if rounded else 0.0


Maker = Callable[[np.random.Generator, float], Any]
MAKERS: dict[str, tuple[tuple[Maker, ...], tuple[float, ...]]] = {  # with their shares
    SINGLE: ((_ball, _cone), (0.9, 0.1)),
    SEVERAL: ((_ball, _flat, _cone), (0.8, 0.15, 0.05)),
    EXTENDED: ((_flat, _bar, _ring), (0.4, 0.3, 0.3)),
}


def _pressed(
    rng: np.random.Generator,
    layer: Layer,
    bodies: list[Any],
    extent: float,
    cell: float,
    world: World,
    ways: Floats,
) -> Press:
    """Solve with random loads, drawn again where the layer does not bear them.

    A shear goes one of the `ways` (bodies,) rad.
    """
    for _ in range(LOADINGS):
        part = 1.0 if world.released else world.share
        forces = [part * _log(rng, *LOADS) for _ in bodies]
        loaded = [
            replace(body, force=force, shear=(along * np.cos(way), along * np.sin(way)))
            for body, force, way in zip(bodies, forces, ways.tolist(), strict=True)
            for along in (world.shear * force,)
        ]
        try:
            solved = world.press(layer, loaded, extent, cell)
        except InputError as error:
            if "sinks" not in str(error):
                raise
            continue
        if solved.approach.max() <= DEEPEST * layer.thickness:
            return solved
    raise InputError(
        f"layer is {layer}, expected one that bears {LOADS[0]:g} N: bodies sink deeper than "
        f"{DEEPEST:g} of it"
    )
