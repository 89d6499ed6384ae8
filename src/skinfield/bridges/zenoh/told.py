"""What a live skin has to say to others, as bytes: what it is, how it is, what touches it."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.bridges.zenoh.calibration import Calibration
from skinfield.bridges.zenoh.keys import Part
from skinfield.bridges.zenoh.messages import described, fingerprint_of, strict_json
from skinfield.layout import Patch, Skin, save_layout
from skinfield.live.client import Live
from skinfield.live.configuration import configuration_of
from skinfield.live.snapshot import Snapshot
from skinfield.live.status import Observer

RECENT = 1.0  # s that the status calls the last
PLAIN = (  # fields of a contact that go out as they are, in SI units
    "track", "position", "normal", "x", "y", "normal_force", "force_std", "place_std", "area",
    "peak_pressure", "moments", "age", "speed",
)  # fmt: skip


class Told:
    """Makes what is sent about one ring.

    Parameters
    ----------
    live : Live
    part : Part

    Attributes
    ----------
    description : bytes
        See `messages.described`.
    fingerprint : bytes
    layout : bytes
        The skin as skinfield's own layout in TOML.
    """

    def __init__(self, live: Live, part: Part) -> None:
        reader = live.reader
        self._live, self._reader = live, reader
        self._observer = Observer(reader, window=RECENT)
        self._patches = list(live.skin)
        self.description = described(part.robot, part.name, reader.description, reader.slot_fields)
        self.fingerprint = fingerprint_of(self.description)
        self.layout = layout_text(live.skin)
        self._look()

    def _look(self) -> None:
        """Look at the state once for both, status and health."""
        plain = self._observer.look().as_dict()
        recorder = (plain.get("beside") or {}).get("recorder")
        if isinstance(recorder, dict):  # where it writes to is nobody's business elsewhere
            recorder.pop("path", None)
        tares = int(self._reader.status_view["tares"][0])
        self._status = strict_json(plain | {"tares": tares})
        patches = plain["patches"]
        self._health = strict_json(
            {
                "state": plain["state"],
                "rate": plain["rate"],
                "cycles": plain["since_start"]["cycles"],
                "late": plain["since_start"]["late"],
                "skipped": plain["since_start"]["skipped"],
                "lost": plain["lost"],
                "sources": plain["sources"],
                "invalid": {each["name"]: each["invalid"] for each in patches if each["invalid"]},
                "stale": [each["name"] for each in patches if each["stale"]],
                "missing": [each["name"] for each in patches if each["answer"] == "missing"],
                "tares": tares,
                "restarts": plain["generation"] - 1,
            }
        )

    def status(self) -> bytes:
        """What `skinfield status --json` tells, now."""
        self._look()
        return self._status

    def health(self) -> bytes:
        """Counters of what goes wrong, of the moment of `status`."""
        return self._health

    def newest_status(self) -> bytes:
        """The status that was made last."""
        return self._status

    def calibration(self) -> bytes:
        """Noise of all taxels and solver, by which a reader makes uncertainties."""
        reader, told = self._reader, configuration_of(self._reader)
        return Calibration(
            tares=int(reader.status_view["tares"][0]),
            generation=reader.generation if told is None else told.generation,
            solver=None if told is None else told.solver,
            noise_std=np.asarray(self._live.models.noise_std),
        ).packed()

    def contacts(
        self, snapshot: Snapshot, rows: NDArray[Any], by: list[str], patch: int | None = None
    ) -> bytes:
        """Contacts of a cycle, on all patches or on one.

        Parameters
        ----------
        snapshot : Snapshot
        rows : (N,) array of CONTACT
        by : list of str
            Who found each: "engine" or "fit".
        patch : int, optional
            Those of this one alone.
        """
        return strict_json(
            {
                "number": snapshot.number,
                "stamp_ns": snapshot.stamp_ns,
                "contacts": [
                    contact_plain(row, self._patches, who)
                    for row, who in zip(rows, by, strict=True)
                    if patch is None or int(row["patch"]) == patch
                ],
            }
        )


def contact_plain(row: Any, patches: list[Patch], by: str) -> dict[str, Any]:
    """A contact in plain values, SI units; force is a vector in the patch's frame."""
    plain = {name: row[name].tolist() for name in PLAIN}
    patch = patches[int(row["patch"])]
    force = (-row["normal_force"] * row["normal"]).tolist()  # onto the skin, against its normal
    return plain | {"patch": patch.name, "link": patch.link, "force": force, "by": by}


def layout_text(skin: Skin | Patch) -> bytes:
    """A layout as skinfield writes it to a TOML file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.toml"
        save_layout(skin, path)
        return path.read_bytes()
