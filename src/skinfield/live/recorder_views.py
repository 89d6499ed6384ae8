"""What a recorder shows of a ring's newest cycle to programs that do not know skinfield."""

from collections.abc import Iterator, Sequence

import numpy as np

from skinfield.layout import Skin
from skinfield.live.recipe import Recipe
from skinfield.live.recorder_settings import RecorderSettings
from skinfield.live.slots import Slot
from skinfield.ring import RingReader
from skinfield.sinks.mcap.views import (
    PatchView,
    ViewMessage,
    Views,
    in_link,
    turned_to_link,
)


def shower_of(reader: RingReader, settings: RecorderSettings) -> "Shower":
    """The channels that the settings ask for, of the ring's skin.

    Raises
    ------
    FileError
        If the ring does not say which skin it is of.
    """
    if not settings.views:
        return Shower(None, (), settings.view_rate)
    skin = Recipe.from_json(str(reader.description.get("recipe"))).skin
    return Shower(skin, [make(skin) for make in settings.views], settings.view_rate)


class Shower:
    """Makes messages of the newest cycle, so many times a second.

    Parameters
    ----------
    skin : Skin or None
        None where there are no views.
    views : sequence of Views
    rate : float, 1/s
    """

    def __init__(self, skin: Skin | None, views: Sequence[Views], rate: float) -> None:
        self._skin, self.views = skin, views
        self._every = int(1e9 / rate)
        self._last = 0
        self._starts = np.cumsum([0, *map(len, skin or ())])

    def due(self, time_ns: int) -> bool:
        """Whether it is time for the next messages."""
        return bool(self.views) and not 0 <= time_ns - self._last < self._every

    def messages(self, time_ns: int, slot: Slot) -> Iterator[ViewMessage]:
        """All messages of one cycle."""
        self._last = time_ns
        patches = list(self._patches(slot))
        for views in self.views:
            yield from views.messages(time_ns, patches)

    def _patches(self, slot: Slot) -> Iterator[PatchView]:
        contacts = slot.used_contacts()
        for place, patch in enumerate(self._skin or ()):
            its = contacts[contacts["patch"] == place]
            part = slice(self._starts[place], self._starts[place + 1])
            # contacts press inwards, against the outward normal
            forces = -its["normal_force"][:, None] * its["normal"]
            yield PatchView(
                patch,
                slot.values[part].copy(),
                slot.valid[part] > 0,
                in_link(patch, its["position"]),
                turned_to_link(patch, forces),
                its["area"].copy(),
                its["track"].copy(),
            )
