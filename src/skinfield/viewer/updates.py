"""From cycles to what the page draws."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.engine.state import Answer
from skinfield.errors import Floats, InputError
from skinfield.live.snapshot import Snapshot
from skinfield.viewer.outlines import outline_of
from skinfield.viewer.stage import Stage, Standing
from skinfield.viewer.update_rows import contact_of, finite, newest_of, outline_near, plain
from skinfield.viewer.wire import packed, scaled

Array = NDArray[Any]
QUANTITIES = {"pressure": "Pa", "deformation": "m", "uncertainty": "Pa", "taxels": ""}
DEAD = 255  # of a taxel that is left out; others reach 254
FULL = 254
STRONG = 30.0  # noise deviations that a dot of a taxel is full at, at the least
BY_FIT = "fit"


class Fitted(Protocol):
    """Contacts that were worked out beside the engine."""

    def pressure(self, patch: str) -> Floats | None:
        """On the finest grid, (K,) Pa; None where there is no recent one."""
        ...


class Seen(NamedTuple):
    """One engine at the time of an update.

    Attributes
    ----------
    snapshot : Snapshot or None
    contacts : structured (N,) array
    by : sequence of str
        Who found each: "engine" or "fit".
    fit : Fitted or None
    """

    snapshot: Snapshot | None
    contacts: Array
    by: Sequence[str]
    fit: Fitted | None = None


def seen_plainly(snapshot: Snapshot | None) -> Seen:
    """A cycle as the engine answered it."""
    rows = np.zeros(0) if snapshot is None else snapshot.contacts
    return Seen(snapshot, rows, ["engine"] * len(rows))


@dataclass
class Parcel:
    """What an update is made of, until it is packed."""

    arrays: list[tuple[str, Array]] = field(default_factory=list)
    geometry: list[bytes] = field(default_factory=list)
    highest: float = 0.0

    def put(self, name: str, array: Array) -> int:
        """Add an array; its place among them."""
        self.arrays.append((name, array))
        return len(self.arrays) - 1


class Updates:
    """Makes the updates of one browser; knows what it has already.

    Parameters
    ----------
    stage : Stage
    """

    def __init__(self, stage: Stage) -> None:
        self.stage = stage
        self.quantity = "pressure"
        self._grids: set[tuple[int, int]] = set()
        self._sent: dict[int, tuple[Any, ...]] = {}
        self._strongest: dict[int, float] = {}

    def show(self, quantity: Any) -> None:
        """Choose what the colours mean.

        Raises
        ------
        InputError
            For none of `QUANTITIES`.
        """
        if quantity not in QUANTITIES:
            raise InputError(f"quantity is {quantity!r}, expected one of {', '.join(QUANTITIES)}")
        self.quantity = str(quantity)
        self._sent.clear()

    def make(
        self,
        number: int,
        seen: Sequence[Seen],
        truth: Sequence[Mapping[str, Any]],
        time_s: float | None = None,
    ) -> list[bytes]:
        """Messages of one update: geometry that it needs, then the update itself.

        Parameters
        ----------
        number : int
            By which the page says that it has drawn it.
        seen : sequence of Seen
            As many as the stage has feeds.
        truth : sequence of dict
            Presses of a virtual skin as it tells them.
        time_s : float, s, optional
            On the time bar of a replay.
        """
        parcel, patches, contacts = Parcel(), [], []
        for place, each in enumerate(self.stage.standing):
            its = seen[self.stage.feeds.index(each.feed)]
            if its.snapshot is None:
                continue
            row = self._patch(place, each, its, parcel)
            if row is not None:
                patches.append(row)
            contacts += self._contacts(place, each, its)
        head = newest_of([each.snapshot for each in seen if each.snapshot is not None])
        head |= {
            "kind": "update",
            "number": number,
            "quantity": self.quantity,
            "unit": self._unit(seen),
            "range": [0.0, parcel.highest],
            "patches": patches,
            "contacts": contacts,
            "truth": [found for press in truth if (found := self._truth(press)) is not None],
        }
        if time_s is not None:
            head["time_s"] = time_s
        return [*parcel.geometry, packed(head, parcel.arrays)]

    def _unit(self, seen: Sequence[Seen]) -> str:
        if self.quantity != "taxels":
            return QUANTITIES[self.quantity]
        known = [each.snapshot for each in seen if each.snapshot is not None]
        return known[0].recipe.quantity.unit if known else ""

    def _patch(
        self, number: int, each: Standing, its: Seen, parcel: Parcel
    ) -> dict[str, Any] | None:
        """Row of a patch with what changed of it; None where nothing did."""
        snapshot = its.snapshot
        assert snapshot is not None  # whoever calls has looked
        row, name = snapshot.patches[each.place], each.patch.name
        fitted = None if its.fit is None else its.fit.pressure(name)
        answer = Answer(int(row["answer"]))
        rung = int(row["rung"]) if fitted is None else snapshot.recipe.rungs[-1]
        key = (int(row["stamp_ns"]), int(answer), rung, fitted is not None)
        if fitted is None and self._sent.get(number) == key:
            return None
        self._sent[number] = key
        shown = rung if answer >= Answer.LINEAR else snapshot.recipe.rungs[-1]
        if (number, shown) not in self._grids:
            first = not any(have == number for have, _ in self._grids)
            parcel.geometry.append(self.stage.geometry(number, shown, first))
            self._grids.add((number, shown))
        gap = float(row["gap"])
        told: dict[str, Any] = {
            "i": number,
            "answer": "searched" if answer == Answer.FEASIBLE else answer.name.lower(),
            "rung": shown,
            "force": float(row["force"]),
            "age_s": finite(snapshot.ages()[name]),
            "gap": finite(gap),
            "invalid": int(row["invalid"]),
            "taxels": parcel.put("taxels", self._taxels(number, each, snapshot, parcel)),
        }
        told["taxels_full"] = self._strongest[number]  # what a full byte of them stands for
        told |= {"height": -1, "colour": -1, "height_scale": 0.0}
        if answer >= Answer.LINEAR:
            told |= self._fields(name, snapshot, fitted, parcel)
        return told

    def _fields(
        self, name: str, snapshot: Snapshot, fitted: Floats | None, parcel: Parcel
    ) -> dict[str, Any]:
        """Deformation and colours of a patch that is touched."""
        told: dict[str, Any] = {}
        heights = snapshot.indentation(name, fitted)
        if heights is not None:
            scale = float(max(heights.max(initial=0.0), 1e-9)) / 65535.0
            told["height_scale"] = scale
            told["height"] = parcel.put("height", scaled(heights, 0.0, 65535.0 * scale))
        values = self._values(name, snapshot, fitted, heights)
        if values is not None:
            high = float(values.max(initial=0.0))
            parcel.highest = max(parcel.highest, high)
            told |= {"colour_lo": 0.0, "colour_hi": high}
            told["colour"] = parcel.put("colour", scaled(values, 0.0, high))
        return told

    def _values(
        self, name: str, snapshot: Snapshot, fitted: Floats | None, heights: Floats | None
    ) -> Floats | None:
        if self.quantity == "pressure":
            return snapshot[name].pressure if fitted is None else fitted
        if self.quantity == "deformation":
            return heights
        if self.quantity == "uncertainty" and snapshot.prepared:
            return np.asarray(snapshot[name].pressure_std)
        return None

    def _taxels(self, number: int, each: Standing, snapshot: Snapshot, parcel: Parcel) -> Array:
        """Readings of a patch as bytes; full is the strongest one seen, or far above the noise."""
        values, valid, noise = snapshot.taxels(each.patch.name)
        strength = np.abs(values)
        floor = STRONG * float(np.median(noise))
        seen = float(strength[valid].max(initial=0.0))
        full = self._strongest[number] = max(self._strongest.get(number, floor), seen, floor)
        if self.quantity == "taxels":
            parcel.highest = max(parcel.highest, full)
        shown = np.clip(strength * (FULL / full), 0, FULL) if full > 0 else np.zeros(len(strength))
        return np.where(valid, np.nan_to_num(shown), DEAD).astype(np.uint8)

    def _contacts(self, number: int, each: Standing, its: Seen) -> list[dict[str, Any]]:
        rows = []
        for row, by in zip(its.contacts, its.by, strict=True):
            if int(row["patch"]) != each.place:
                continue
            found = None
            if by != BY_FIT and its.snapshot is not None and its.snapshot.prepared:
                found = outline_near(its.snapshot[each.patch.name].contacts, row["position"])
            border = outline_of(each.patch, row) if found is None else found
            rows.append(contact_of(row, number, by) | {
                "key": f"{each.feed.name} {int(row['track'])}",  # each engine counts for itself
                "position": plain(each.shown(row["position"][None])[0]),
                "normal": plain(each.turned(row["normal"][None])[0]),
                "outline": np.round(each.shown(border), 6).tolist(),
            })  # fmt: skip
        return rows

    def _truth(self, press: Mapping[str, Any]) -> dict[str, Any] | None:
        """A press as the picture shows it; None where its patch is none of the picture's."""
        for number, each in enumerate(self.stage.standing):
            if each.patch.name != press["patch"]:
                continue
            surface, plane = each.patch.surface, np.array([[press["x"], press["y"]]])
            normal = surface.frame_from_plane(plane)[:, :, 2]
            names = ("id", "x", "y", "force", "shape", "radius", "contact_radius")
            return {name: press[name] for name in names} | {
                "patch": number,
                "position": plain(each.shown(surface.position_from_plane(plane))[0]),
                "normal": plain(each.turned(normal)[0]),
            }
        return None
