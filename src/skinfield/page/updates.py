"""Updates of the page: what a cycle's fields, taxels and contacts become on the wire."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.emulator.scenes import STAMPS, SceneTool
from skinfield.errors import Floats, InputError
from skinfield.estimate import Estimate
from skinfield.estimate.contact_table import RELATIVE
from skinfield.estimate.row_contacts import covariance_of, outline_of, shape_name, shear_of
from skinfield.loop import Answer
from skinfield.loop.slots import CycleHead
from skinfield.loop.snapshot import Snapshot
from skinfield.page.contact_shapes import NOT_HERE, ContactShapes
from skinfield.page.scene_layout import PlacedPatch, SceneLayout
from skinfield.page.source import OLD, EngineView
from skinfield.page.timeline import lines, rows_of
from skinfield.page.wire import packed, scaled
from skinfield.reconstruct.engine.report import WORDS


def newest_of(snapshots: Sequence[Snapshot]) -> dict[str, Any]:
    """Numbers of the cycle with the newest reading."""
    if not snapshots:
        return {"cycle": 0, "stamp_ns": 0, "age_s": None, "fresh": False, "late": False}
    newest = max(snapshots, key=lambda each: each.stamp_ns)
    took = round(newest.took * 1e9)
    published = int(newest.slot.head[CycleHead.WALL_NS]) + took
    return {
        "cycle": newest.number,
        "stamp_ns": newest.stamp_ns,
        "age_s": finite(newest.age),
        "fresh": newest.fresh,
        "late": newest.late,
        "ready_us": took * 1e-3,
        "latency_us": (published - newest.stamp_ns) * 1e-3 if newest.stamp_ns else None,
    }


def finite(value: Any) -> float | None:
    """A number for JSON; None for what is none."""
    found = float(value)
    return found if math.isfinite(found) else None


def shear_told(shear: Floats, vector: Floats) -> dict[str, Any]:
    """A force along the skin by the plane's x and y, and as a vector of the picture, N and rad."""
    angle = math.atan2(shear[1], shear[0])
    return {"size": float(np.hypot(*shear)), "angle": angle, "vector": vector.tolist()}


Array = NDArray[Any]
QUANTITIES = {"pressure": "Pa", "deformation": "m", "uncertainty": "Pa", "taxels": ""}
DEAD = 255  # of a taxel that is left out; others reach 254
FULL = 254
LASTS = 5.0  # s for which the last contacts of a patch are shown while no reading comes
DOUBT = 3.0  # noise deviations of a linear answer's pressure, up to which it has no colour
SURE = 4.605  # quantile of χ² of two numbers at 0.9: a shear beyond it is shown, others are not
STRONG = 30.0  # noise deviations that a dot of a taxel is full at, at the least


def beyond_noise(snapshot: Snapshot, place: int) -> Floats:
    """Pressure of a patch as it is coloured: of a linear answer what noise does not explain.

    It is faded in from `DOUBT` deviations to twice as many. Until the deviations are prepared,
    there is none where no contact was found.
    """
    name = snapshot.model_config.skin[place].name
    pressure: Floats = snapshot[name].pressure
    if int(snapshot.patches["answer"][place]) != int(Answer.LINEAR):
        return pressure
    noise = snapshot.noise_pressure(name)
    if noise is None:
        return pressure if snapshot.patches["contacts"][place] else np.zeros_like(pressure)
    return pressure * np.clip(np.abs(pressure) / (DOUBT * noise) - 1.0, 0.0, 1.0)


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


def stamp_of(press: Mapping[str, Any]) -> SceneTool | None:
    """The stamp that presses, if one does."""
    return SceneTool(press["radius"], press["shape"]) if press["shape"] in STAMPS else None


class SeenContacts(NamedTuple):
    """Contacts of a patch's newest reading.

    Attributes
    ----------
    rows : list of dict
    stamp_ns : int, ns
        Of the reading.
    age : float, s
        Of it, at `at`.
    at : float, s
        By `time.monotonic`.
    """

    rows: list[dict[str, Any]]
    stamp_ns: int
    age: float
    at: float


class Updates:
    """Makes the updates of one browser; knows what it has already."""

    def __init__(self, layout: SceneLayout) -> None:
        self.layout = layout
        self.quantity = "pressure"
        self._grids: set[tuple[int, int]] = set()
        self._sent: dict[int, tuple[Any, ...]] = {}
        self._strongest: dict[int, float] = {}
        self._seen: dict[int, SeenContacts] = {}
        self._start_ns = 0  # of the first reading that was shown

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
        views: Sequence[EngineView],
        truth: Sequence[Mapping[str, Any]],
        time_s: float | None = None,
        shapes: Sequence[ContactShapes | None] | None = None,
    ) -> list[bytes]:
        """Messages of one update: geometry that it needs, then the update itself.

        Parameters
        ----------
        number : int
            By which the page says that it has drawn it.
        views : sequence of EngineView
            As many as the layout has sources.
        truth : sequence of dict
            Presses of a virtual skin as it tells them.
        time_s : float, s, optional
            On the time bar of a replay.
        shapes : sequence of ContactShapes or None, optional
            As many as the layout has sources: those that make images. Default nobody looks.
        """
        parcel, patches, contacts = Parcel(), [], []
        for place, each in enumerate(self.layout.placed):
            its = views[self.layout.sources.index(each.source)]
            if its.snapshot is None:
                continue
            row = self._patch(place, each, its, parcel)
            if row is not None:
                patches.append(row)
            contacts += self._contacts_seen(place, each, its)
        known = [each.snapshot for each in views if each.snapshot is not None]
        relative = any(each.model_config.relative for each in known)
        head = newest_of(known)
        if head["age_s"] is not None:
            head["age_s"] += max(each.since for each in views)
        head |= {
            "kind": "update",
            "fades_s": max((each.fades for each in views), default=OLD),
            "number": number,
            "quantity": self.quantity,
            "unit": self._unit(known, relative),
            "relative": relative,
            "range": [0.0, parcel.highest],
            "patches": patches,
            "contacts": contacts,
            "old": bool(known) and all(each.old for each in views if each.snapshot is not None),
            "truth": [found for press in truth if (found := self._truth(press)) is not None],
        }
        if shapes is not None:
            head["shapes"] = self._shapes(shapes)
        if time_s is not None:
            head["time_s"] = time_s
        else:
            head["rows"] = self._rows(known)
        return [*parcel.geometry, packed(head, parcel.arrays)]

    def _shapes(self, processes: Sequence[ContactShapes | None]) -> dict[str, Any]:
        """Images of contacts with the numbers of their patches; why there are none, if so."""
        images: list[dict[str, Any]] = []
        for number, each in enumerate(self.layout.placed):
            process = processes[self.layout.sources.index(each.source)]
            found = () if process is None else process.newest()
            images += [one | {"patch": number} for one in found if one["patch"] == each.patch.name]
        there = [each for each in processes if each is not None]
        why = "" if there else NOT_HERE
        if there and not any(each.ready for each in there):
            why = "being prepared"
        return {"images": images, "why": why}

    def _rows(self, known: Sequence[Snapshot]) -> list[str]:
        """Lines of the table of contacts; the time of the first is 0."""
        stamps = [each.stamp_ns for each in known if each.stamp_ns]
        self._start_ns = self._start_ns or min(stamps, default=0)
        return [line for each in known for line in lines(rows_of(each, self._start_ns))]

    def _unit(self, known: Sequence[Snapshot], relative: bool) -> str:
        if self.quantity != "taxels":
            unit = QUANTITIES[self.quantity]
            return RELATIVE if relative and unit == "Pa" else unit
        return known[0].model_config.quantity.unit if known else ""

    def _patch(
        self, number: int, each: PlacedPatch, its: EngineView, parcel: Parcel
    ) -> dict[str, Any] | None:
        """Row of a patch with what changed of it; None where nothing did."""
        snapshot = its.snapshot
        assert snapshot is not None  # whoever calls has looked
        row, name = snapshot.patches[each.place], each.patch.name
        answer, rung = Answer(int(row["answer"])), int(row["rung"])
        key = (int(row["stamp_ns"]), int(answer), rung, snapshot.prepared)
        if self._sent.get(number) == key or self._rests(number, answer, its):
            return None
        self._sent[number] = key
        shown = rung if answer >= Answer.LINEAR else snapshot.model_config.rungs[-1]
        if (number, shown) not in self._grids:
            first = not any(have == number for have, _ in self._grids)
            parcel.geometry.append(self.layout.geometry(number, shown, first))
            self._grids.add((number, shown))
        gap = float(row["gap"])
        fields: dict[str, Any] = {
            "i": number,
            "answer": WORDS[answer],
            "rung": shown,
            "force": float(row["force"]),
            "age_s": finite(snapshot.ages()[name]),
            "gap": finite(gap),
            "invalid": int(row["invalid"]),
            "taxels": parcel.put("taxels", self._taxels(number, each, snapshot, parcel)),
        }
        looked_at = self.quantity == "taxels" and answer != Answer.MISSING
        if looked_at and fields["invalid"] and snapshot.prepared:
            fields["repaired"] = parcel.put("repaired", self._repaired(number, snapshot[name]))
        fields["taxels_full"] = self._strongest[number]  # what a full byte of them stands for
        fields |= {"height": -1, "colour": -1, "height_scale": 0.0, "height_zero": 0}
        if answer >= Answer.LINEAR:
            fields |= self._fields(each.place, snapshot, parcel)
        return fields

    def _fields(self, place: int, snapshot: Snapshot, parcel: Parcel) -> dict[str, Any]:
        """Deformation and colours of a patch that is touched."""
        fields: dict[str, Any] = {}
        name = snapshot.model_config.skin[place].name
        pressure = beyond_noise(snapshot, place)
        heights = snapshot.indentation(name) if pressure.any() else None
        if heights is not None:
            # A dent swells around itself: heights go both ways from the skin at rest
            low, high = float(heights.min(initial=0.0)), float(heights.max(initial=0.0))
            scale = max(high - low, 1e-9) / 65535.0
            zero = round(-low / scale)
            bounds = -zero * scale, (65535 - zero) * scale
            fields |= {"height_scale": scale, "height_zero": zero}
            fields["height"] = parcel.put("height", scaled(heights, *bounds))
        values = self._values(name, snapshot, pressure, heights)
        if values is not None:
            high = float(values.max(initial=0.0))
            parcel.highest = max(parcel.highest, high)
            fields |= {"colour_lo": 0.0, "colour_hi": high}
            fields["colour"] = parcel.put("colour", scaled(values, 0.0, high))
        return fields

    def _values(
        self, name: str, snapshot: Snapshot, pressure: Floats, heights: Floats | None
    ) -> Floats | None:
        if self.quantity == "pressure":
            return pressure
        if self.quantity == "deformation":
            return heights
        if self.quantity == "uncertainty" and snapshot.prepared:
            return np.asarray(snapshot[name].pressure_std)
        return None

    def _taxels(self, number: int, each: PlacedPatch, snapshot: Snapshot, parcel: Parcel) -> Array:
        """Readings of a patch as bytes; full is the strongest one views, or far above the noise."""
        values, valid, noise = snapshot.taxels(each.patch.name)
        strength = np.abs(values)
        floor = STRONG * float(np.median(noise))
        strongest = float(strength[valid].max(initial=0.0))
        full = self._strongest[number] = max(self._strongest.get(number, floor), strongest, floor)
        if self.quantity == "taxels":
            parcel.highest = max(parcel.highest, full)
        return np.where(valid, self._as_bytes(number, strength), DEAD).astype(np.uint8)

    def _repaired(self, number: int, estimate: Estimate) -> Array:
        """Readings of a patch as bytes, of taxels that are left out what they would be."""
        return self._as_bytes(number, np.abs(estimate.readings)).astype(np.uint8)

    def _as_bytes(self, number: int, strength: Floats) -> Floats:
        """Strengths as parts of what a full byte of a patch stands for, times `FULL`."""
        full = self._strongest[number]
        if full <= 0:
            return np.zeros(len(strength))
        return np.nan_to_num(np.clip(strength * (FULL / full), 0, FULL))

    def _rests(self, number: int, answer: Answer, its: EngineView) -> bool:
        """Whether a patch that has no reading now still shows the last one, which fades."""
        seen = self._seen.get(number)
        gone = answer == Answer.MISSING and its.lives and seen is not None
        return gone and time.monotonic() - seen.at + seen.age < LASTS  # type: ignore[union-attr]

    def _contacts_seen(
        self, number: int, each: PlacedPatch, its: EngineView
    ) -> list[dict[str, Any]]:
        """Contacts of a patch, or those of its last reading while none comes."""
        snapshot, now = its.snapshot, time.monotonic()
        assert snapshot is not None  # whoever calls has looked
        row = snapshot.patches[each.place]
        answer = Answer(int(row["answer"]))
        if not self._rests(number, answer, its):
            rows = self._contacts(number, each, its)
            age = snapshot.ages()[each.patch.name] + its.since
            self._seen[number] = SeenContacts(rows, int(row["stamp_ns"]), age, now)
            if answer == Answer.MISSING:
                del self._seen[number]
                return rows
        seen = self._seen[number]
        age = seen.age + (now - seen.at)
        told = {"seen_s": finite(age), "seen_ms": seen.stamp_ns / 1e6, "fades_s": its.fades}
        told["old"] = its.old or (its.lives and age > its.fades)
        return [contact | told for contact in seen.rows]

    def _contacts(self, number: int, each: PlacedPatch, its: EngineView) -> list[dict[str, Any]]:
        snapshot, rows = its.snapshot, []
        assert snapshot is not None  # whoever calls has looked
        patch = snapshot.patches[each.place]
        for row in snapshot.contacts[snapshot.contacts["patch"] == each.place]:
            border = outline_of(each.patch.surface, row)
            alike = ("force_std", "place_std", "area", "speed")
            rows.append({name: finite(row[name]) for name in alike} | {
                "track": int(row["track"]),
                "patch": number,
                "place_cov": [finite(each) for each in covariance_of(row)[[0, 0, 1], [0, 1, 1]]],
                "shape": shape_name(row),
                "shear": self._shear(each, row),
                "radius": finite(row["radius"]),
                "maybe": int(row["maybe"]),
                "answer": WORDS[Answer(int(patch["answer"]))],
                "readings": int(patch["readings"]),
                "x": float(row["x"]),
                "y": float(row["y"]),
                "force": float(row["normal_force"]),
                "peak": finite(row["peak_pressure"]),
                "age_s": finite(row["age"]),
                "key": f"{each.source.name} {int(row['track'])}",  # each engine counts for itself
                "position": each.in_scene(row["position"][None])[0].tolist(),
                "normal": each.turned(row["normal"][None])[0].tolist(),
                "outline": np.round(each.in_scene(border), 6).tolist(),
            })  # fmt: skip
        return rows

    def _shear(self, each: PlacedPatch, row: Any) -> dict[str, Any] | None:
        """Force along the skin of a row, where it is more than nine in ten of its noise."""
        shear, covariance = shear_of(each.patch.surface, row)
        size, known = float(np.hypot(*shear)), bool(np.isfinite(covariance).all())
        if not (size > 0.0 and known and np.linalg.det(covariance) > 0.0):
            return None
        if shear @ np.linalg.solve(covariance, shear) < SURE:
            return None
        std = math.sqrt(shear @ covariance @ shear) / size
        return shear_told(shear, each.turned(row["shear"][None])[0]) | {"std": std}

    def _truth(self, press: Mapping[str, Any]) -> dict[str, Any] | None:
        """A press as the picture shows it; None where its patch is none of the picture's."""
        for number, each in enumerate(self.layout.placed):
            if each.patch.name != press["patch"]:
                continue
            surface, plane = each.patch.surface, np.array([[press["x"], press["y"]]])
            frame = surface.frame_from_plane(plane)[0]
            shear = np.array(press.get("shear", (0.0, 0.0)))
            told = shear_told(shear, each.turned((frame[:, :2] @ shear)[None])[0])
            names = ("id", "x", "y", "force", "shape", "radius", "contact_radius")
            return {name: press[name] for name in names} | {
                "patch": number,
                "shear": told if shear.any() else None,
                "border": stamp.border.tolist() if (stamp := stamp_of(press)) else None,
                "position": each.in_scene(surface.position_from_plane(plane))[0].tolist(),
                "normal": each.turned(frame[None, :, 2])[0].tolist(),
            }
        return None
