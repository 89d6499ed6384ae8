"""Recordings of a live skin as bags of ROS 2 (rosbag2), written without ROS."""

import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import numpy as np

from skinfield.errors import FileError, Floats, Ints
from skinfield.files.mcap.export import LiveExport
from skinfield.files.mcap.schema import Rows
from skinfield.files.pending import explained, pending
from skinfield.files.ros.kinds import TIME, RosbagKinds
from skinfield.files.ros.messages import Outgoing, SkinMessages
from skinfield.files.ros.names import Topics
from skinfield.skin import Patch, Skin

VERSION: Final = 8  # of metadata.yaml: Iron's, which later ones read too
LOG = "rcl_interfaces/msg/Log"
INFO = 20  # of it
MISSING = 0  # a patch's answer


class BagExport(LiveExport):
    """A folder with metadata.yaml and one file, as `ros2 bag` reads it.

    For each patch `<prefix>/<patch>/counts` (a PointCloud2 of each scan, NaN where a taxel did not
    answer), `<prefix>/<patch>/wrench` and `contact_wrench`; `<prefix>/contacts`, `/tf` with a frame
    for each contact, and `/rosout` with what happened. A cycle without a new reading of a patch
    says nothing of it.

    Parameters
    ----------
    path : str or Path
        Folder to make.
    patches : sequence of Patch
        Those to write.
    numbers : sequence of int, optional
        Their places in the recorded skin; default from 0 on.
    sqlite : bool
        An SQLite file, as Humble writes; default an MCAP file, as later ones do.
    prefix : str
        Before the skin's own topics.
    forces : str, optional
        What forces are, see `scale_of`: `custom_data` of the metadata says so.

    Raises
    ------
    FileError
        If there is something at `path`, or it cannot be written there.
    SkinfieldError
        If rosbags is not installed.
    """

    def __init__(
        self,
        path: str | Path,
        patches: Sequence[Patch],
        numbers: Sequence[int] | None = None,
        *,
        sqlite: bool = False,
        prefix: str = "/skin",
        forces: str | None = None,
    ) -> None:
        self._kinds = RosbagKinds()
        from rosbags.rosbag2 import StoragePlugin, Writer

        self._place = pending(path)
        target = self._place.target
        if target.exists():
            raise FileError(f"{target} exists already, expected a new name: a bag is a folder")
        skin = Skin(tuple(patches))
        self._make = SkinMessages(skin, self._kinds, Topics.of(skin, prefix))
        self._patches = tuple(range(len(skin)) if numbers is None else numbers)
        self._connections: dict[str, Any] = {}
        plugin = StoragePlugin.SQLITE3 if sqlite else StoragePlugin.MCAP
        with explained(target):
            self._place.part.mkdir()
            # within a folder: the file in the bag is named as the bag
            self._writer = Writer(
                self._place.part / target.name, version=VERSION, storage_plugin=plugin
            )
            self._writer.open()
        if forces is not None:
            self._writer.set_custom_data("skinfield_forces", forces)

    def add_counts(self, patch: int, stamp_ns: Ints, counts: Floats) -> None:
        """See `LiveExport`."""
        for stamp, row in zip(stamp_ns.tolist(), counts, strict=True):
            self._put(self._make.taxels(patch, stamp, row, "counts"))

    def add_rows(self, tables: Mapping[str, Rows]) -> None:
        """See `LiveExport`."""
        if len(tables.get("patch_cycles", ())):
            for patches, its in _cycles(tables["patch_cycles"], tables["contacts"]):
                self._put_cycle(patches, its)

    def add_happened(
        self, timing: Sequence[dict[str, Any]], events: Sequence[dict[str, Any]]
    ) -> None:
        """See `LiveExport`."""
        for event in events:
            wall_ns = int(event.get("wall_ns", 0))
            seconds, rest = divmod(wall_ns, 10**9)
            more = {key: value for key, value in event.items() if key not in ("wall_ns", "text")}
            text = str(event.get("text", ""))
            message = self._kinds.make(
                LOG,
                stamp=self._kinds.make(TIME, sec=seconds, nanosec=rest),
                level=INFO,
                name=str(event.get("kind", "skinfield")),
                msg=f"{text} {json.dumps(more)}".strip(),
                file="",
                function="",
                line=0,
            )
            self._put(Outgoing("/rosout", LOG, wall_ns, message))

    def add_taxels(self, place: int, stamp_ns: int, values: Floats) -> None:
        """Add what the taxels (L,) of a patch read, in the quantity's unit; NaN where invalid."""
        self._put(self._make.taxels(place, stamp_ns, values))

    def close(self) -> None:
        """Finish, and give the bag its name."""
        target = self._place.target
        with explained(target):
            self._writer.close()
            (self._place.part / target.name).rename(target)
            self._place.part.rmdir()

    def discard(self) -> None:
        """Remove what was written."""
        with suppress(Exception):  # half a bag is of no use, whatever closing it says
            self._writer.close()
        shutil.rmtree(self._place.part, ignore_errors=True)

    def _put(self, out: Outgoing) -> None:
        data, topic, kind = self._kinds.bytes_of(out.kind, out.message), out.topic, out.kind
        with explained(self._place.target):
            if topic not in self._connections:
                self._connections[topic] = self._writer.add_connection(
                    topic, kind, msgdef=self._kinds.text_of(kind), rihs01=self._kinds.hash_of(kind)
                )
            self._writer.write(self._connections[topic], out.stamp_ns, data)

    def _put_cycle(self, patches: Rows, contacts: Rows) -> None:
        patches = patches[list(self._patches)]
        contacts = contacts[np.isin(contacts["patch"], self._patches)].copy()
        contacts["patch"] = np.searchsorted(self._patches, contacts["patch"])
        fresh = (patches["fresh"] > 0) & (patches["answer"] != MISSING) & (patches["stamp_ns"] > 0)
        stamps = patches["stamp_ns"].tolist()
        for out in self._make.of_contacts(stamps, contacts, fresh.tolist()):
            self._put(out)


def _cycles(patches: Rows, contacts: Rows) -> Iterator[tuple[Rows, Rows]]:
    """Rows of patches and of contacts, cycle by cycle."""
    starts = np.flatnonzero(np.diff(patches["cycle"], prepend=patches["cycle"][0] - 1))
    for rows in np.split(patches, starts[1:]):
        first, end = np.searchsorted(contacts["cycle"], [rows["cycle"][0], rows["cycle"][0] + 1])
        yield rows, contacts[first:end]
