"""The presses on the skin as they are now, and what all taxels read of them."""

import itertools
import math
from bisect import bisect_right
from collections.abc import Mapping
from typing import Any

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.layout import Skin
from skinfield.mechanics import Layer
from skinfield.virtual.electronics import starts_of
from skinfield.virtual.place import PLACE_KEYS, number, patch_index, place_of
from skinfield.virtual.solving import Solving
from skinfield.virtual.tables import FORCES, SPACING, PressTable
from skinfield.virtual.tool import FINGER, Tool
from skinfield.virtual.touch import Scene, Touch, Track

MOST = 64  # presses at once, by hand
KEPT = 20  # notes
LONGEST_ID = 64  # characters
Shown = tuple[str, int, Tool, float, float, float]


class World:
    """A scene, presses by hand, and the tables that tell what taxels read of them.

    Readings of several presses are added up: right where they are apart, by a few thicknesses of
    the layer, and not where they share skin.

    Parameters
    ----------
    skin : Skin
    layer : Layer
    scene : Scene
        Its tables are solved here and now.
    """

    def __init__(self, skin: Skin, layer: Layer, scene: Scene) -> None:
        self.skin, self.layer = skin, layer
        self._starts = starts_of(skin)
        self._plane = np.ascontiguousarray(np.concatenate([patch.plane for patch in skin]))
        self._solving = Solving(layer)
        self._by_hand: dict[str, Touch] = {}
        self._numbers = itertools.count(1)
        self._shown: tuple[Shown, ...] | None = None
        self.notes: list[str] = []
        self._warm()
        self.play(scene)
        self._table(skin.patches[0].pad_diameter, Tool())

    def _warm(self) -> None:
        """Compile before the first press."""
        from skinfield.virtual.world_kernel import add_press

        nothing = np.zeros((2, 2))
        add_press(np.zeros(0), self._plane, 0, 0, nothing, SPACING, 0.0, 0.0, 0.0)

    def play(self, scene: Scene) -> None:
        """Play another scene from now on.

        Raises
        ------
        InputError
            If it presses a body through the layer; the old one goes on then.
        """
        for (patch, tool), force in scene.tools.items():
            if not 0 <= patch < len(self.skin):
                raise InputError(f"patch is {patch}, expected one below {len(self.skin)}")
            self._table(self.skin.patches[patch].pad_diameter, tool).check_force(force, tool)
        tracks = sorted(scene.tracks, key=lambda track: track.points[0].time)
        self._tracks = [(f"{scene.name}-{i}", track) for i, track in enumerate(tracks)]
        self._begins = [track.points[0].time for track in tracks]
        self._longest = max((t.points[-1].time - t.points[0].time for t in tracks), default=0.0)
        self.scene = scene

    def _table(self, pad_diameter: float, tool: Tool) -> PressTable:
        return self._solving.now(tool, pad_diameter)

    def touches(self, time: float) -> list[Touch]:
        """Presses at a time, s, of the scene."""
        found: list[Touch] = []
        if time >= 0.0:
            time = time % self.scene.period if math.isfinite(self.scene.period) else time
            for name, track in self._playing(time):
                at = track.at(time)
                if at is not None:
                    found.append(Touch(name, track.patch, track.tool, *at))
        for touch in self._by_hand.values():
            if self._solving.get(touch.tool, self._pad(touch.patch)) is not None:
                found.append(touch)
        return found

    def _playing(self, time: float) -> list[tuple[str, Track]]:
        last = bisect_right(self._begins, time)
        first = bisect_right(self._begins, time - self._longest - 1e-9)
        return self._tracks[first:last]

    def update(self, time: float, change: Floats) -> list[tuple[Touch, float]] | None:
        """Write what the taxels read at a time of the scene into `change`, (C,) from the first.

        Returns
        -------
        list of (Touch, contact radius in m), or None
            The presses; None where nothing has changed since the last call.
        """
        touches = self.touches(time)
        shown = tuple((t.id, t.patch, t.tool, t.x, t.y, t.force) for t in touches)
        if shown == self._shown:
            return None
        self._shown = shown
        return self._render(touches, change)

    def _render(self, touches: list[Touch], change: Floats) -> list[tuple[Touch, float]]:
        from skinfield.virtual.world_kernel import add_press

        change[:] = 0.0
        told = []
        for touch in touches:
            table = self._table(self._pad(touch.patch), touch.tool)
            row = min((touch.force / table.highest_force) ** 0.5, 1.0) * (FORCES - 1)
            first, last = self._starts[touch.patch], self._starts[touch.patch + 1]
            add_press(
                change, self._plane, int(first), int(last), table.change, SPACING, row, touch.x,
                touch.y,
            )  # fmt: skip
            told.append((touch, table.radius_at(touch.force)))
        return told

    def _pad(self, patch: int) -> float:
        return self.skin.patches[patch].pad_diameter

    def poll(self) -> None:
        """Take in tables that are solved by now; a press that is too hard for its own is let go."""
        if not self._solving.poll():
            return
        for touch in list(self._by_hand.values()):
            table = self._solving.get(touch.tool, self._pad(touch.patch))
            try:
                if table is not None:
                    table.check_force(touch.force, touch.tool)
            except InputError as error:
                del self._by_hand[touch.id]
                self.notes.append(f"press {touch.id} was let go: {error}")
                del self.notes[:-KEPT]

    @property
    def waits(self) -> list[str]:
        """Presses by hand whose body is still being solved."""
        return [
            touch.id
            for touch in self._by_hand.values()
            if self._solving.get(touch.tool, self._pad(touch.patch)) is None
        ]

    def press(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Begin a press by hand, see `docs/virtual-skin.md`; what came of it."""
        patch = patch_index(self.skin, given.get("patch"))
        x, y = place_of(self.skin.patches[patch], given)
        shape = given.get("shape", "ball")
        if not isinstance(shape, str):
            raise InputError(f"shape is {shape!r:.40}, expected 'ball' or 'flat'")
        radius = number(given, "radius", FINGER, 0.5e-3, 30e-3, "of the body, in metres")
        tool = Tool(radius, shape)
        force = number(given, "force", 1.0, 1e-6, 1e4, "newtons")
        name = given.get("id") or f"press-{next(self._numbers)}"
        if not isinstance(name, str) or len(name) > LONGEST_ID:
            raise InputError(f"id is {name!r:.80}, expected up to {LONGEST_ID} characters")
        if name not in self._by_hand and len(self._by_hand) >= MOST:
            raise InputError(f"{MOST} presses are there, expected fewer: release some first")
        pad = self._pad(patch)
        if self._solving.get(tool, pad) is None:
            self._solving.start(tool, pad)
        table = self._solving.get(tool, pad)  # one that was stored is there at once
        if table is not None:
            table.check_force(force, tool)
        self._by_hand[name] = Touch(name, patch, tool, x, y, force)
        return {"id": name, "x": x, "y": y, "radius": tool.radius, "solving": table is None}

    def move(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Move a press by hand, or change its force."""
        touch = self._named(given.get("id"))
        x, y, force = touch.x, touch.y, touch.force
        if any(key in given for key in PLACE_KEYS):
            x, y = place_of(self.skin.patches[touch.patch], {"x": x, "y": y, **given})
        if "force" in given:
            force = number(given, "force", None, 1e-6, 1e4, "newtons")
            table = self._solving.get(touch.tool, self._pad(touch.patch))
            if table is not None:
                table.check_force(force, touch.tool)
        self._by_hand[touch.id] = Touch(touch.id, touch.patch, touch.tool, x, y, force)
        return {"id": touch.id, "x": x, "y": y, "force": force}

    def release(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Lift off one press by hand, or all."""
        if given.get("id") is None:
            names = list(self._by_hand)
        else:
            names = [self._named(given.get("id")).id]
        for name in names:
            del self._by_hand[name]
        return {"released": names}

    def _named(self, name: Any) -> Touch:
        if not isinstance(name, str) or name not in self._by_hand:
            known = ", ".join(self._by_hand) or "none is there"
            raise InputError(f"id is {name!r:.80}, expected that of a press by hand: {known}")
        return self._by_hand[name]

    def close(self) -> None:
        """End what is being solved."""
        self._solving.close()
