"""Validation of solvers: any solver on any cases, at noises that are added to exact readings."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from skinfield.elastic import HalfSpace, Mechanics
from skinfield.errors import InputError, check_choice
from skinfield.estimate import Contact
from skinfield.lab.cases import QUANTITIES, Case
from skinfield.lab.runner import canonical
from skinfield.lab.score import GATE, Judge, Row, matched
from skinfield.reconstruct import Reconstructor
from skinfield.skin import Grid
from skinfield.solve import Auto, GaussianField, PseudoInverse, Solver

CACHED = 8  # reconstructions that stay prepared: cases of one skin share theirs
PLACE_90, FORCE_90 = 4.605, 2.706  # squared deviations that hold 90 %: of two numbers, and of one
NOW_NS = 1_000_000_000_000  # stamp of readings that others go before
RUNS = 2  # readings of each press: a cold one, which is scored, and a warm one
# Of readings without noise a solver is still told one, the truth's own error: about 1e-3 of the
# stress below a light press, and of the capacitance that the field in the gap is known to.
FLOORS = {"stress": 10.0, "capacitance": 1e-4, "gap": 1e-4}
PAPER, GAUSSIAN, AUTO = "paper", "gaussian", "auto"


@dataclass(frozen=True)
class NoiseLevel:
    """A noise of one quantity, in its unit; 0 for exact readings."""

    quantity: str
    noise: float

    def __post_init__(self) -> None:
        check_choice("quantity", self.quantity, FLOORS, "what taxels read")
        if not 0.0 <= self.noise < float("inf"):
            raise InputError(f"noise is {self.noise!r}, expected 0 for exact readings, or more")

    @property
    def stated(self) -> float:
        """What a solver is told: never less than the floor of `FLOORS`."""
        return max(self.noise, FLOORS[self.quantity])

    def __str__(self) -> str:
        return f"{self.quantity} {self.noise:g}"


@dataclass(frozen=True, kw_only=True)
class Entrant:
    """A solver with what it assumes, ready for any case.

    Parameters
    ----------
    solver : Solver
    mechanics : Mechanics, optional
        Model of the elastomer. Default what the case says that the skin is.
    nodes : int
        On a side of the grid.
    gate : float, m
        Up to which contacts may belong together.
    name : str
        In tables.
    """

    solver: Solver
    mechanics: Mechanics | None = None
    nodes: int = 40
    gate: float = GATE
    name: str = ""
    _prepared: dict[str, Reconstructor] = field(
        default_factory=dict, init=False, compare=False, repr=False
    )

    def rows(self, case: Case, scored: int | None = None) -> list[Row]:
        """Take up the readings of a case one by one; a row for each of the first `scored`, or all.

        The entrant is told the layer, the quantity and the noise that the case states. Beside the
        score's row there are ``cold_ms`` and ``warm_ms``, of the first reading, after nothing, and
        of those right after it, and ``place_held`` and ``force_held``: the matched contacts whose
        stated 90 % region holds the true place, and force.
        """
        reconstruct = self.reconstructor(case)
        reconstruct.reset()
        estimates, times = [], []
        if len(case.history):
            stamps = np.rint(NOW_NS + 1e9 * case.history_s).astype(np.int64)
            reconstruct(case.history, stamp_ns=stamps)
        for reading in case.draws:
            start = time.perf_counter()
            estimates.append(reconstruct(reading, stamp_ns=NOW_NS if len(case.history) else 0))
            times.append(1e3 * (time.perf_counter() - start))
        warm = float(np.median(times[1:])) if len(times) > 1 else float("nan")
        judge = Judge(case, reconstruct.grid, self.gate)
        head = {"quantity": case.quantity, "method": self.name}
        rows = []
        for estimate in estimates[:scored]:
            matches, *_ = matched(case.patch, case.truth.contacts, estimate.contacts, self.gate)
            held = [_held(estimate.contacts[m.estimated], case, m.true) for m in matches]
            place, force = np.array(held, dtype=np.int64).reshape(-1, 2).sum(axis=0).tolist()
            about = {"cold_ms": times[0], "warm_ms": warm, "place_held": place, "force_held": force}
            rows.append(head | judge(estimate) | about)
        return rows

    def false_contacts(self, case: Case, draws: int, seed: int) -> list[int]:
        """Contacts found in each of some readings of the case's skin at rest, with its noise."""
        idle = np.random.default_rng(seed).standard_normal((draws, len(case.patch)))
        reconstruct = self.reconstructor(case)
        reconstruct.reset()
        return [len(found) for found in reconstruct(idle * case.noise_std).contacts]

    def reconstructor(self, case: Case) -> Reconstructor:
        """Reconstruction of the case's skin, told its noise; kept for the next such case."""
        mechanics = case.mechanics if self.mechanics is None else self.mechanics
        key = canonical((case.patch, case.layer, case.quantity, mechanics, case.noise_std))
        if key not in self._prepared:
            if len(self._prepared) >= CACHED:
                self._prepared.pop(next(iter(self._prepared)))
            self._prepared[key] = Reconstructor(
                case.patch,
                case.layer,
                Grid.square(case.patch, nodes=self.nodes),
                mechanics=mechanics,
                quantity=QUANTITIES[case.quantity],
                solver=self.solver,
                noise_std=case.noise_std,
            )
        return self._prepared[key]


def _held(estimated: Contact, case: Case, true: int) -> tuple[bool, bool]:
    """Whether the regions that hold 90 %, as the contact states them, hold place and force."""
    contact = case.truth.contacts[true]
    place = case.patch.surface.position_from_plane(np.array([contact.position]))[0]
    apart = (estimated.position - place)[:2]  # of a flat patch
    spread = estimated.covariance[:2, :2]
    if not np.isfinite(estimated.covariance).all() or np.linalg.det(spread) <= 0.0:
        return False, False
    square = float(apart @ np.linalg.solve(spread, apart))
    force = (estimated.normal_force - contact.force) ** 2 / float(estimated.covariance[2, 2])
    return square <= PLACE_90, force <= FORCE_90


def known_entrants(nodes: int = 40) -> tuple[Entrant, ...]:
    """The paper's on its 20 x 20 nodes, the Gaussian field, and what `Auto` chooses, on `nodes`."""
    return (
        Entrant(name=PAPER, solver=PseudoInverse(resample=True), mechanics=HalfSpace(), nodes=20),
        Entrant(name=GAUSSIAN, solver=GaussianField(), nodes=nodes),
        Entrant(name=AUTO, solver=Auto(), nodes=nodes),
    )


@lru_cache(maxsize=32)
def once(entrant: Entrant) -> Entrant:
    """One of equal entrants per process, so that what it prepares is prepared once."""
    return entrant


def noise_seed(seed: int, index: int) -> int:
    """Of the noise of a press of a campaign: another one for each."""
    return seed * 1_000_003 + index


def at_level(case: Case, level: NoiseLevel, seed: int) -> Case:
    """Two readings of an exact case at a level; of exact ones the solver is told the floor."""
    if level.noise > 0:
        return case.with_noise(seed, RUNS, level.noise)
    noise = np.full(len(case.patch), level.stated)
    return replace(case, noise_std=noise, readings=np.repeat(case.draws, RUNS, axis=0), noisy=True)


def rows_of_case(
    case: Case, levels: Sequence[NoiseLevel], entrants: Sequence[Entrant], seed: int
) -> Iterator[Row]:
    """Rows of one case of exact readings, level by level and entrant by entrant.

    All see the same noise, which grows from level to level. Without levels the readings are scored
    as they are. Errors are parts of the truth where no unit is named.
    """
    every: Sequence[NoiseLevel | None] = levels or [None]
    for level in every:
        drawn = case if level is None else at_level(case, level, seed)
        noise, scored = (None, None) if level is None else (level.noise, 1)
        for entrant in entrants:
            yield from ({"noise": noise} | row for row in once(entrant).rows(drawn, scored))
