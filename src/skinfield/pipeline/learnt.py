"""Learning from simulated presses how far a reconstructor's contacts are from the truth."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_range
from skinfield.fields import Contact, Estimate
from skinfield.layout import Patch
from skinfield.pipeline.intervals import (
    LEAST,
    Group,
    Intervals,
    Ratio,
    features_of,
    relative_deviation,
)
from skinfield.pipeline.rehearsal import BODIES, Rehearsal, rehearse

if TYPE_CHECKING:
    from skinfield.pipeline.reconstructor import Reconstructor

GATE = 8e-3  # m: farther away, a contact is not that of the press
TRAINING = 1 / 3  # of the presses; the others make the quantiles
GROUPS = 3
FLOORS = np.concatenate([[0.0], np.geomspace(1e-3, 3.0, 48)])  # relative deviations that are tried
PITCHES = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 48)])  # the same for places
AGREED = 1e-3  # of ln(true / stated), below which an error counts in full in the fit of the centre


@dataclass(frozen=True, eq=False)
class Lesson:
    """What was stated of N presses that were found, and what was true.

    Attributes
    ----------
    features : (N, 3) array
        See `features_of`.
    deviation : (N,) array
        Stated relative deviation of the force.
    blocks : (N, 2, 2) array, m²
        Stated covariance of the place.
    force, area : (N,) arrays
        ln(true / stated).
    place : (N, 2) array, m
        True less stated.
    """

    features: Floats
    deviation: Floats
    blocks: Floats
    force: Floats
    area: Floats
    place: Floats

    def __len__(self) -> int:
        return len(self.force)

    def part(self, rows: NDArray[Any]) -> "Lesson":
        """Some of the presses, by a mask or a slice."""
        return Lesson(*(values[rows] for values in vars(self).values()))


def intervals_of(
    reconstruct: "Reconstructor", presses: int, seed: int = 0, bodies: Sequence[Any] | None = None
) -> Intervals:
    """Intervals of a reconstructor; see `Reconstructor.calibrated`."""
    check_range("presses", presses, 1, 1_000_000, "simulated, with a truth to compare with")
    rehearsal = rehearse(
        reconstruct.patch,
        reconstruct.layer,
        reconstruct.mechanics,
        reconstruct.quantity,
        presses,
        seed,
        BODIES if bodies is None else bodies,
    )
    raw = reconstruct.with_intervals(None)

    def solve(readings: Floats) -> Estimate:
        raw.reset()
        return raw(readings)

    solver, quantity, _, _ = reconstruct.kind
    noise = reconstruct.model.noise_std
    intervals = learn(solve, reconstruct.patch, rehearsal, noise, solver, quantity, seed)
    raw.reset()
    return intervals


def learn(
    solve: Callable[[Floats], Estimate],
    patch: Patch,
    rehearsal: Rehearsal,
    noise: Floats,
    solver: str,
    quantity: str,
    seed: int = 0,
) -> Intervals:
    """Learn intervals.

    Parameters
    ----------
    solve : function of readings (L,)
        Estimate from one reading, without any before.
    patch : Patch
    rehearsal : Rehearsal
    noise : (L,) array, in the quantity's unit
        Standard deviation of one reading.
    solver, quantity : str
        To be kept with the intervals.
    seed : int
        Of the noise.

    Raises
    ------
    InputError
        If so few presses are found that there is no 90 % interval.
    """
    rng = np.random.default_rng([seed, 2])
    readings = rehearsal.readings + noise * rng.standard_normal(rehearsal.readings.shape)
    lesson = _lesson(solve, patch, rehearsal, readings)
    needed = int(np.ceil(LEAST / (1 - TRAINING))) + 1
    if len(lesson) < needed:
        raise InputError(
            f"presses is {len(readings)}, of which {len(lesson)} were found, expected {needed} or "
            "more: give more presses, or less noise"
        )
    split = int(len(lesson) * TRAINING)
    training, rest = lesson.part(np.arange(split)), lesson.part(np.arange(split, len(lesson)))
    force, area = _ratio(training, training.force), _ratio(training, training.area)
    floor = _place_floor(training, patch.pitch)
    edges = _edges(rest.deviation)
    which = np.searchsorted(edges, rest.deviation)
    parts = [rest.part(which == group) for group in range(len(edges) + 1)]
    return Intervals(
        solver=solver,
        quantity=quantity,
        taxels=len(patch),
        noise_std=float(noise.mean()),
        presses=len(readings),
        found=len(lesson),
        force=force,
        area=area,
        place_floor=floor,
        edges=edges,
        groups=tuple(_group(part, force, area, floor) for part in parts),
    )


def _lesson(
    solve: Callable[[Floats], Estimate], patch: Patch, rehearsal: Rehearsal, readings: Floats
) -> Lesson:
    positions = patch.surface.position_from_plane(rehearsal.places)
    frames = patch.surface.frame_from_plane(rehearsal.places)
    rows = []
    for row, reading in enumerate(readings):
        contact = nearest(solve(reading).contacts, positions[row])
        if contact is None:
            continue
        deviation = relative_deviation(contact)
        rows.append(
            (
                features_of(deviation, contact.normal_force),
                deviation,
                contact.covariance[:2, :2],
                np.log(rehearsal.forces[row] / contact.normal_force),
                np.log(rehearsal.areas[row] / contact.area),
                (positions[row] - contact.position) @ frames[row][:, :2],
            )
        )
    shapes = ((0, 3), (0,), (0, 2, 2), (0,), (0,), (0, 2))
    columns = zip(*rows, strict=True) if rows else map(np.zeros, shapes)
    return Lesson(*(np.array(column) for column in columns))


def nearest(contacts: tuple[Contact, ...], position: Floats) -> Contact | None:
    """Contact nearest to the true position (3,) m, if it is within the gate and presses."""
    pressing = [each for each in contacts if each.normal_force > 0.0 and each.area > 0.0]
    apart = [float(np.linalg.norm(each.position - position)) for each in pressing]
    return pressing[int(np.argmin(apart))] if apart and min(apart) <= GATE else None


def _ratio(lesson: Lesson, errors: Floats) -> Ratio:
    """Centre by a regression that outliers do not rule; the floor that gives short intervals."""
    from scipy.optimize import least_squares

    start = np.array([np.median(errors), 0.0, 0.0])
    size = max(float(np.median(np.abs(errors - start[0]))), AGREED)

    def wrong(weights: Floats) -> Floats:
        return np.asarray((errors - lesson.features @ weights) / size)

    centre = least_squares(wrong, start, loss="soft_l1").x
    missing = errors - lesson.features @ centre
    costs = []
    for floor in FLOORS:
        sizes = np.hypot(lesson.deviation, floor)
        low, high = np.quantile(missing / sizes, [0.05, 0.95])
        costs.append(np.log(sizes).mean() + np.log(max(high - low, 1e-12)))
    return Ratio(centre=centre, floor=float(FLOORS[int(np.argmin(costs))]))


def _place_floor(lesson: Lesson, pitch: float) -> float:
    costs = []
    for floor in PITCHES * pitch:
        blocks = lesson.blocks + max(floor, 1e-9) ** 2 * np.eye(2)
        reach = np.quantile(_metric(lesson.place, blocks), 0.9)
        costs.append(np.log(np.linalg.det(blocks)).mean() / 4 + np.log(max(reach, 1e-12)))
    return float(max(PITCHES[int(np.argmin(costs))] * pitch, 1e-9))


def _metric(errors: Floats, blocks: Floats) -> Floats:
    """Root of e^T C^-1 e for errors (N, 2) and covariances (N, 2, 2)."""
    solved = np.linalg.solve(blocks, errors[:, :, None])[:, :, 0]
    return np.asarray(np.sqrt(np.maximum((errors * solved).sum(axis=1), 0.0)))


def _edges(deviation: Floats) -> Floats:
    """Where groups are cut, so that each has enough presses: many may be equally sure."""
    kept: list[float] = []
    below = 0
    for share in np.arange(1, GROUPS) / GROUPS:
        edge = float(np.quantile(deviation, share)) * (1 + 1e-9)
        here = int((deviation <= edge).sum())
        if here - below >= LEAST and len(deviation) - here >= LEAST:
            kept.append(edge)
            below = here
    return np.array(kept)


def _group(lesson: Lesson, force: Ratio, area: Ratio, floor: float) -> Group:
    force_size = np.hypot(lesson.deviation, force.floor)
    area_size = np.hypot(lesson.deviation, area.floor)
    blocks = lesson.blocks + floor**2 * np.eye(2)
    width = np.sqrt(np.trace(blocks, axis1=1, axis2=2) / 2)
    return Group(
        force=np.sort((lesson.force - lesson.features @ force.centre) / force_size),
        area=np.sort((lesson.area - lesson.features @ area.centre) / area_size),
        force_size=np.sort(np.abs(np.expm1(lesson.force)) / force_size),
        place=np.sort(_metric(lesson.place, blocks)),
        distance=np.sort(np.linalg.norm(lesson.place, axis=1) / width),
    )
