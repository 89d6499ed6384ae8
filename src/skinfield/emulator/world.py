"""World of a virtual skin: what presses it, and what its taxels read of that."""

import itertools
import math
from bisect import bisect_right
from dataclasses import replace
from typing import Any

import numpy as np

from skinfield.elastic import Layer
from skinfield.emulator.electronics import starts_of
from skinfield.emulator.press_tables import Key, PressTables, PushTable, ToolTable
from skinfield.emulator.scenes import BodyPath, CurrentPress, Scene, SceneTool, patch_index
from skinfield.emulator.transports import Request
from skinfield.errors import Floats, InputError
from skinfield.skin import Skin

MOST = 64  # presses at once, by hand
AHEAD = 64  # tables that are solved before they are pressed with
KEPT = 20  # notes
LONGEST_ID = 64  # characters


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
    plane : (L, 2) array, m, optional
        Where the taxels of all patches truly are; default as stated.
    """

    def __init__(self, skin: Skin, layer: Layer, scene: Scene, plane: Floats | None = None) -> None:
        self.skin, self.layer = skin, layer
        self._starts = starts_of(skin)
        stated = np.concatenate([patch.plane for patch in skin]) if plane is None else plane
        self._plane = np.ascontiguousarray(stated)
        self._solving = PressTables(layer)
        self._by_hand: dict[str, CurrentPress] = {}
        self._ahead: list[Key] = []  # to be solved before they press, the newest last
        self._numbers = itertools.count(1)
        self._published: list[CurrentPress] | None = None
        self.notes: list[str] = []
        self.play(scene)
        self._solving.now(self._key(0, SceneTool()))

    def play(self, scene: Scene) -> None:
        """Play another scene from now on.

        Raises
        ------
        InputError
            If it presses a body through the layer; the old one goes on then.
        """
        for (patch, tool), force in scene.tools.items():
            self._solving.now(self._key(patch, tool)).check_force(force, tool)
        tracks = sorted(scene.tracks, key=lambda track: track.points[0].time)
        self._tracks = [(f"{scene.name}-{i}", track) for i, track in enumerate(tracks)]
        self._begins = [track.points[0].time for track in tracks]
        self._longest = max((t.points[-1].time - t.points[0].time for t in tracks), default=0.0)
        self.scene = scene

    def _key(self, patch: int, tool: SceneTool) -> Key:
        return tool, self.skin.patches[patch].pad_diameter

    def _table(self, touch: CurrentPress) -> ToolTable | None:
        return self._solving.get(self._key(touch.patch, touch.tool))

    def _push_key(self, touch: CurrentPress) -> Key | None:
        """Of what a push adds to the press, if it is pushed."""
        return (
            self._key(touch.patch, replace(touch.tool, pushed=True)) if any(touch.shear) else None
        )

    def _push_table(self, touch: CurrentPress) -> PushTable | None:
        """Of a push, if there is one and it is solved: before, the press goes on without it."""
        key = self._push_key(touch)
        table = None if key is None else self._solving.get(key)
        return table if isinstance(table, PushTable) else None

    def touches(self, time: float) -> list[CurrentPress]:
        """Presses at a time, s, of the scene."""
        found: list[CurrentPress] = []
        if time >= 0.0:
            time = time % self.scene.period if math.isfinite(self.scene.period) else time
            for name, track in self._playing(time):
                at = track.at(time)
                if at is not None:
                    found.append(CurrentPress(name, track.patch, track.tool, *at))
        for touch in self._by_hand.values():
            if self._table(touch) is not None:
                found.append(touch)
        return found

    def _playing(self, time: float) -> list[tuple[str, BodyPath]]:
        last = bisect_right(self._begins, time)
        first = bisect_right(self._begins, time - self._longest - 1e-9)
        return self._tracks[first:last]

    def update(self, time: float, change: Floats) -> list[CurrentPress] | None:
        """Write what the taxels read at a time of the scene into `change`, (C,) from the first.

        The presses; None where nothing has changed since the last call.
        """
        touches = self.touches(time)
        if touches == self._published:
            return None
        self._published = touches
        change[:] = 0.0
        found = []
        for touch in touches:
            table = self._solving.now(self._key(touch.patch, touch.tool))
            rows = slice(self._starts[touch.patch], self._starts[touch.patch + 1])
            away = self._plane[rows] - (touch.x, touch.y)
            for along, part in touch.tool.parts:
                change[rows] += table.readings(away - (along, 0.0), part * touch.force)
            push = self._push_table(touch)
            if push is not None:
                change[rows] += push.added(away, touch.force, np.array(touch.shear))
            shear = (0.0, 0.0) if push is None else touch.shear
            radius = table.radius_at(touch.force)
            found.append(replace(touch, contact_radius=radius, shear=shear))
        return found

    def poll(self) -> None:
        """Take in tables that are solved by now; a press that is too hard for its own is let go."""
        if not self._solve():
            return
        self._published = None
        for touch in list(self._by_hand.values()):
            table = self._table(touch)
            try:
                if table is not None:
                    table.check_force(touch.force, touch.tool)
            except InputError as error:
                del self._by_hand[touch.id]
                self.notes.append(f"press {touch.id} was let go: {error}")
                del self.notes[:-KEPT]

    def _solve(self) -> bool:
        presses = self._by_hand.values()
        wanted = [self._key(each.patch, each.tool) for each in presses]
        wanted = [*(key for each in presses if (key := self._push_key(each))), *wanted]
        return self._solving.poll(wanted, self._ahead)

    def prepare(self, request: Request) -> dict[str, Any]:
        """Have a tool solved before it presses, wherever that may be; the newest comes first."""
        tool = SceneTool(request.radius, request.shape)
        keys = [key for key in self._keys(tool) if self._solving.get(key) is None]
        self._ahead = [*(each for each in self._ahead if each not in keys), *keys][-AHEAD:]
        return {"solving": bool(keys)}

    def _keys(self, tool: SceneTool) -> list[Key]:
        """Of a tool on each kind of taxel there is."""
        return [(tool, pad) for pad in dict.fromkeys(each.pad_diameter for each in self.skin)]

    def tools(self, request: Request) -> dict[str, Any]:
        """Tools that press at once anywhere, and those being solved, with the share done."""
        solved = dict.fromkeys(tool for tool, _ in self._solving.solved if not tool.pushed)
        ready = [tool for tool in solved if self._solving.solved.issuperset(self._keys(tool))]
        shares: dict[SceneTool, float] = {}
        for (tool, _), share in self._solving.shares.items():
            if not tool.pushed:
                shares[tool] = min(share, shares.get(tool, 1.0))
        return {
            "ready": [_plain(tool) for tool in ready],
            "preparing": [_plain(tool) | {"share": share} for tool, share in shares.items()],
        }

    @property
    def waits(self) -> list[str]:
        """Presses by hand whose body is still being solved, or their push."""
        return [
            touch.id
            for touch in self._by_hand.values()
            if self._table(touch) is None or (any(touch.shear) and self._push_table(touch) is None)
        ]

    def press(self, request: Request) -> dict[str, Any]:
        """Begin a press by hand, see `docs/how-to/virtual-skin.md`; what came of it."""
        patch = patch_index(self.skin, request.patch)
        x, y = request.on(self.skin.patches[patch])
        tool = SceneTool(request.radius, request.shape)
        force = 1.0 if request.force is None else request.force
        name = request.id or f"press-{next(self._numbers)}"
        if len(name) > LONGEST_ID:
            raise InputError(f"id is {name!r:.80}, expected up to {LONGEST_ID} characters")
        if name not in self._by_hand and len(self._by_hand) >= MOST:
            raise InputError(f"{MOST} presses are there, expected fewer: release some first")
        before = self._by_hand.get(name)
        if before is not None and before.tool == tool:  # the same objects: the truth keeps them
            name, tool = before.id, before.tool
        touch = CurrentPress(name, patch, tool, x, y, force, shear=request.shear or (0.0, 0.0))
        touch.check_shear()
        table = self._table(touch)
        if table is not None:
            table.check_force(force, tool)
        self._by_hand.pop(name, None)  # the newest is the last
        self._by_hand[name] = touch
        self._solve()
        return {"id": name, "x": x, "y": y, "radius": tool.radius, "solving": table is None}

    def move(self, request: Request) -> dict[str, Any]:
        """Move a press by hand, or change its force."""
        touch = self._named(request.id)
        x = touch.x if request.x is None else request.x
        y = touch.y if request.y is None else request.y
        x, y = replace(request, x=x, y=y).on(self.skin.patches[touch.patch])
        force = touch.force if request.force is None else request.force
        table = self._table(touch)
        if request.force is not None and table is not None:
            table.check_force(force, touch.tool)
        shear = touch.shear if request.shear is None else request.shear
        moved = replace(touch, x=x, y=y, force=force, shear=shear)
        moved.check_shear()
        self._by_hand[touch.id] = moved
        return {"id": touch.id, "x": x, "y": y, "force": force}

    def release(self, request: Request) -> dict[str, Any]:
        """Lift off one press by hand, or all."""
        names = list(self._by_hand) if request.id is None else [self._named(request.id).id]
        for name in names:
            del self._by_hand[name]
        return {"released": names}

    def _named(self, name: str | None) -> CurrentPress:
        if name not in self._by_hand:
            known = ", ".join(self._by_hand) or "none is there"
            raise InputError(f"id is {name!r:.80}, expected that of a press by hand: {known}")
        return self._by_hand[name]

    def close(self) -> None:
        """End what is being solved."""
        self._solving.close()


def _plain(tool: SceneTool) -> dict[str, Any]:
    return {"shape": tool.shape, "radius": tool.radius}
