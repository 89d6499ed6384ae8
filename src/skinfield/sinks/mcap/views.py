"""Channels that other programs show without knowing skinfield."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.layout import Patch, Skin


class ViewChannel(NamedTuple):
    """A channel to be made: topic, message encoding, and schema (name, encoding, text)."""

    topic: str
    encoding: str
    schema: tuple[str, str, bytes]


class ViewMessage(NamedTuple):
    """A message of the channel `topic`."""

    topic: str
    time_ns: int
    data: bytes


@dataclass(frozen=True, eq=False)
class PatchView:
    """One patch at one instant, in the frame of its link.

    Attributes
    ----------
    patch : Patch
    values : (L,) array
        What the taxels read, in the quantity's unit.
    valid : (L,) bool array
    positions, forces : (N, 3) arrays, m and N
        Of the contacts.
    areas : (N,) array, m²
    tracks : (N,) array
    """

    patch: Patch
    values: NDArray[np.float32]
    valid: NDArray[np.bool_]
    positions: Floats
    forces: Floats
    areas: Floats
    tracks: NDArray[np.int64]


class Views(Protocol):
    """A kind of readable channels: `RosViews`, `FoxgloveViews`."""

    @property
    def profile(self) -> str:
        """Profile that the file must state for its readers; empty if any will do."""
        ...

    def channels(self) -> Iterable[ViewChannel]:
        """All that will have messages."""
        ...

    def messages(self, time_ns: int, patches: Iterable[PatchView]) -> Iterable[ViewMessage]:
        """What the channels say of one instant."""
        ...


class Places(NamedTuple):
    """Of a patch's taxels in the frame of its link, and that frame's name.

    Attributes
    ----------
    frame : str
    positions : (L, 3) array, m
    """

    frame: str
    positions: Floats


def places_of(skin: Skin) -> dict[str, Places]:
    """Places of all patches, by name."""
    return {
        patch.name: Places(patch.link or patch.name, in_link(patch, patch.positions))
        for patch in skin
    }


def in_link(patch: Patch, positions: Floats) -> Floats:
    """Points (N, 3) of the patch's frame in that of its link."""
    pose = patch.link_from_patch
    return np.asarray(positions @ pose[:3, :3].T + pose[:3, 3])


def turned_to_link(patch: Patch, vectors: Floats) -> Floats:
    """Directions (N, 3) of the patch's frame in that of its link."""
    return np.asarray(vectors @ patch.link_from_patch[:3, :3].T)


def topic_of(patch: str, what: str) -> str:
    """Topic of a patch; letters that ROS does not allow in names become underscores."""
    plain = "".join(letter if letter.isalnum() and letter.isascii() else "_" for letter in patch)
    return f"/skin/{plain}/{what}"
