"""Judgement of a layout: all maps in numbers and in one sentence."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skinfield.design.design import Places, SkinDesign, Touch
from skinfield.design.detectability import (
    BlindSpots,
    DetectableForce,
    blind_spots,
    detectable_force,
)
from skinfield.design.discrimination import (
    PlaceAccuracy,
    TwoPointDistance,
    place_accuracy,
    two_point_distance,
)
from skinfield.errors import Floats

SHARES = (0.5, 0.9, 0.95, 1.0)  # of the places, in a row


class Row(NamedTuple):
    """One map in numbers, in mm and N: at half of the places it is better than `median`.

    They are infinite where so many places have no finite value.
    """

    name: str
    unit: str
    median: float
    p90: float
    p95: float
    worst: float


@dataclass(frozen=True, eq=False)
class Judgement:
    """Every map of a layout for one touch.

    Attributes
    ----------
    design : SkinDesign
    touch : Touch
    blind : BlindSpots
    detectable : DetectableForce
    accuracy : PlaceAccuracy
    two_points : TwoPointDistance
        At fewer places than the others.
    """

    design: SkinDesign
    touch: Touch
    blind: BlindSpots
    detectable: DetectableForce
    accuracy: PlaceAccuracy
    two_points: TwoPointDistance

    def maps(self) -> Iterator[tuple[str, str, Places, Floats]]:
        """Name, unit, places and values in that unit of every map where less is better."""
        places, force, accuracy = self.blind.places, self.detectable, self.accuracy
        yield "smallest force found", "N", places, force.unknown_place
        yield "place deviation", "mm", places, accuracy.place_std * 1e3
        yield "force deviation", "N", places, accuracy.force_std
        few = self.two_points.places
        yield "two touches told, typical direction", "mm", few, self.two_points.typical * 1e3
        yield "two touches told, worst direction", "mm", few, self.two_points.worst * 1e3

    def rows(self) -> tuple[Row, ...]:
        """Every map in numbers."""
        weak = ("response, of the best place's", "%", None, -100 * self.blind.response)
        response, *others = (
            Row(name, unit, *(abs(part_of(values, share)) for share in SHARES))
            for name, unit, _, values in (weak, *self.maps())
        )
        return (response, *others)

    @property
    def missed_share(self) -> float:
        """Part of the patch where a touch of the stated force is not found."""
        return float((self.detectable.unknown_place > self.touch.force).mean())

    def verdict(self) -> str:
        """What this skin is good for, in a sentence or two."""
        force, accuracy = self.touch.force, self.accuracy
        found = 1.0 - self.missed_share
        place = part_of(accuracy.place_std, 0.5)
        apart = part_of(self.two_points.typical, 0.5) * 1e3
        where = {1.0: "everywhere", 0.0: "nowhere"}.get(found, f"on {_percent(found)} of the patch")
        holes = self.blind.holes
        blind = "no place is blind"
        if holes:
            largest = holes[0].area * 1e6
            blind = (
                f"{_percent(self.blind.blind_share)} of the patch is blind, the largest hole "
                f"{largest:.{0 if largest >= 10 else 1}f} mm²"
            )
        pair = f"tells two from {apart:.2g} mm on" if np.isfinite(apart) else "tells no two apart"
        placed = f"to {place * 1e3:.2g} mm"
        guess = np.sqrt(accuracy.places.plane.var(axis=0).sum())  # anywhere: off its middle by this
        if not place < guess:
            placed = "no better than a guess would"
        return (
            f"A touch of {force:g} N is found {where}; half of the patch places it {placed} and "
            f"{pair}; {blind}."
        )

    def as_csv(self) -> str:
        """One row per place: the plane's coordinates and every map, in mm and N.

        The two touches, judged at fewer places, have those of the nearest place.
        """
        from scipy.spatial import cKDTree

        places = self.blind.places
        columns = {"x_mm": places.plane[:, 0] * 1e3, "y_mm": places.plane[:, 1] * 1e3}
        columns["response_share"] = self.blind.response
        for name, unit, where, values in self.maps():
            near = slice(None) if where is places else cKDTree(where.plane).query(places.plane)[1]
            columns[f"{name.replace(', ', '_').replace(' ', '_')}_{unit}"] = values[near]
        rows = zip(*columns.values(), strict=True)
        lines = [",".join(f"{value:.6g}" for value in row) for row in rows]
        return "\n".join([",".join(columns), *lines]) + "\n"


def _percent(share: float) -> str:
    """Write a share so that neither 0 nor 1 is said of anything else."""
    if share == 0.0 or 0.01 <= share <= 0.99 or share == 1.0:
        return f"{share:.0%}"
    return "less than 1%" if share < 0.01 else "more than 99%"


def part_of(values: Floats, share: float) -> float:
    """Value that a share of all values does not exceed; not interpolated: they may be infinite."""
    return float(np.sort(values)[max(int(np.ceil(share * len(values))) - 1, 0)])


def judge(
    design: SkinDesign,
    touch: Touch,
    places: Places | None = None,
    *,
    two_point_places: Places | None = None,
    false_alarm_rate: float = 1e-3,
    ways: int = 12,
    on_map: Callable[[str], object] = lambda _: None,
) -> Judgement:
    """Every map of a layout for one touch.

    Parameters
    ----------
    design : SkinDesign
    touch : Touch
    places : Places, optional
        Default `Places.over` the patch.
    two_point_places : Places, optional
        Default at most some hundred.
    false_alarm_rate : float
        Of noise alone, per reading of all taxels.
    ways : int
        Directions of a second touch.
    on_map : function of str
        Called with the name of each map before it is made.
    """
    places = Places.over(design.patch) if places is None else places
    on_map("blind spots")
    blind = blind_spots(design, touch, places)
    on_map("smallest force")
    detectable = detectable_force(design, touch, places, false_alarm_rate=false_alarm_rate)
    on_map("place and force")
    accuracy = place_accuracy(design, touch, places)
    on_map("two touches")
    pairs = two_point_distance(design, touch, two_point_places, ways=ways)
    return Judgement(design, touch, blind, detectable, accuracy, pairs)
