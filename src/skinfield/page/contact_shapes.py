"""Contact shapes of the page: a process beside the engine that makes images of what touches.

`python -m skinfield.page.contact_shapes RING --parent PID` reads the ring as any client does, the
newest cycle first, for at most `SHARE` of a processor, and writes a line of JSON for each image.
"""

import argparse
import base64
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import IO, Any

import numpy as np

from skinfield.errors import InputError, SkinfieldError
from skinfield.estimate.contact_image import ContactImage
from skinfield.loop.client import Live
from skinfield.loop.process_supervisor import SupervisedProcess, end_with
from skinfield.loop.snapshot import Snapshot
from skinfield.page.source import DataSource, LiveSource
from skinfield.processes import Child, start_python
from skinfield.reconstruct import Reconstructor
from skinfield.reconstruct.contact_images import ContactImages
from skinfield.skin import Grid
from skinfield.solve import Tikhonov

SHARE = 0.3  # of a processor, at most
NICE = 5
EVERY = 0.03  # s from reading to reading: an image is made of the last second, then
SURE = 3  # readings, of which an image is made that is seen beside others
PATCHES = 4  # that are followed at a time
NODES = 8  # along the sides of a grid that is only there because a reconstructor has one
LASTS = 1.5  # s for which a line holds, while no other comes
NOT_HERE = "shapes are made where the skin runs: open the page of its own machine"


def image_told(name: str, image: ContactImage) -> dict[str, Any]:
    """An image in plain values: bytes of its highest pressure, lengths in the body's frame."""
    peak = float(image.pressure.max())
    scaled = np.round(255.0 * image.pressure / max(peak, 1e-9)).astype(np.uint8)
    rows, columns = scaled.shape
    convexity = image.convexity
    return {
        "patch": name,
        "track": image.track_id,
        "pose": np.round(image.pose, 6).tolist(),
        "rows": rows,
        "columns": columns,
        "cell": image.cell,
        "low": image.body_positions[0, 0].tolist(),
        "pressure": base64.b64encode(scaled.tobytes()).decode(),
        "peak": peak,
        "outline": [np.round(each, 5).tolist() for each in image.body_outline],
        "force": image.force,
        "area": image.area,
        "convexity": convexity if np.isfinite(convexity) else None,
        "readings": image.readings,
        "misfit": float(image.misfit),
    }


class ShapeFollower:
    """Images of what touches a live skin.

    Parameters
    ----------
    live : Live
    """

    def __init__(self, live: Live) -> None:
        self._live, self._tares = live, live.tares
        self._images: dict[str, ContactImages] = {}

    def _of(self, place: int) -> ContactImages:
        """Of a patch, for the baseline and noise in force."""
        live, name = self._live, self._live.skin.patches[place].name
        if live.tares != self._tares:
            self._images.clear()
            self._tares = live.tares
        if name not in self._images:
            known, patch = live.model_config, live.skin.patches[place]
            reconstructor = Reconstructor(
                patch,
                known.layer,
                Grid.square(patch, NODES),
                mechanics=known.mechanics,
                quantity=known.quantity,
                solver=Tikhonov(),
                noise_std=known.noise_of(live.models.noise_std)[name],
            )
            self._images[name] = ContactImages(reconstructor)
        return self._images[name]

    def update(self, snapshot: Snapshot) -> list[dict[str, Any]]:
        """Take in a cycle; what touches now, by falling force on each patch."""
        found, patches = [], snapshot.patches
        known = [name in self._images and bool(self._images[name].images) for name in self._names]
        touched = (patches["fresh"] > 0) & ((patches["contacts"] > 0) | np.array(known))
        for place in np.flatnonzero(touched)[:PATCHES].tolist():
            name = self._names[place]
            values, valid, _ = snapshot.taxels(name)
            images = self._of(place).update(values, valid=valid, stamp_ns=snapshot.stamp_ns)
            sure = [each for each in images if each.readings >= SURE]
            found += [image_told(name, each) for each in sure or images]
        return found

    @property
    def _names(self) -> list[str]:
        return [patch.name for patch in self._live.skin]

    def prepare(self) -> None:
        """Compile what is used, on readings that are made up, of the first patch."""
        images = self._of(0)
        patch = self._live.skin.patches[0]
        away = np.hypot(*(patch.plane - patch.plane.mean(axis=0)).T)
        readings = 100.0 * images.rec.model.noise_std.mean() * np.exp(-((away / 6e-3) ** 2))
        for each in (readings, 1.1 * readings, readings):
            for image in images.update(each):
                image_told(patch.name, image)
        self._images.clear()


def follow(live: Live, write: Callable[[Mapping[str, Any]], None]) -> None:
    """Write what touches a live skin, until it is gone; no more than `SHARE` of the time works."""
    follower = ShapeFollower(live)
    follower.prepare()
    shapes: list[dict[str, Any]] = []
    write({"shapes": shapes})
    for snapshot in live:
        start, before = time.monotonic(), shapes
        shapes = follower.update(snapshot)
        if shapes or before:
            write({"shapes": shapes})
        took = time.monotonic() - start
        time.sleep(max(EVERY - took, took * (1.0 / SHARE - 1.0)))


def main() -> int:
    """Run the process; its exit status."""
    parser = argparse.ArgumentParser()
    parser.add_argument("name")
    parser.add_argument("--parent", type=int, required=True)
    given = parser.parse_args()
    end_with(given.parent)
    os.nice(NICE)

    def write(plain: Mapping[str, Any]) -> None:
        sys.stdout.write(json.dumps(plain, allow_nan=False) + "\n")
        sys.stdout.flush()

    try:
        follow(Live(given.name), write)
    except SkinfieldError as error:
        sys.stderr.write(f"{error}\n")
    return 2


class ContactShapes(SupervisedProcess):
    """Process that makes images of what touches one live skin.

    Parameters
    ----------
    source : LiveSource
    """

    def __init__(self, source: LiveSource) -> None:
        super().__init__(f"what makes images of contacts of {source.name}")
        self._name = source.name
        self._newest: tuple[float, list[dict[str, Any]]] | None = None

    def spawn(self) -> Child:
        """See `SupervisedProcess`."""
        words = ("skinfield.page.contact_shapes", self._name, "--parent", str(os.getpid()))
        return start_python(*words, stdout=subprocess.PIPE, stderr=self.new_errors())

    def greet(self, child: Child) -> None:
        """See `SupervisedProcess`; it is not waited for."""
        self._newest = None
        assert child.stdout is not None
        threading.Thread(target=self._read, args=(child.stdout,), daemon=True).start()

    def _read(self, lines: IO[bytes]) -> None:
        for line in lines:
            self._newest = time.monotonic(), json.loads(line)["shapes"]

    @property
    def ready(self) -> bool:
        """Whether it has said anything: the first time it compiles."""
        return self._newest is not None

    def newest(self) -> list[dict[str, Any]]:
        """Images of what touches now."""
        if self._newest is None or time.monotonic() - self._newest[0] > LASTS:
            return []
        return self._newest[1]


class ShapeProcesses:
    """Processes for those skins whose shapes somebody looks at; one thread tends them.

    Attributes
    ----------
    viewers : set
        Those who look.
    """

    def __init__(self) -> None:
        self.viewers: set[Any] = set()
        self._running: dict[LiveSource, ContactShapes] = {}

    def tend(self, sources: Sequence[DataSource]) -> list[str]:
        """Start and end processes; what is to be said of them."""
        said: list[str] = []
        wanted = [each for each in sources if isinstance(each, LiveSource) and self.viewers]
        for gone in [each for each in self._running if each not in wanted]:
            self._running.pop(gone).stop()
        for source in wanted:
            if source in self._running:
                said += self._running[source].notices()
                continue
            made = ContactShapes(source)
            try:
                made.begin()
            except InputError as error:
                said.append(str(error))
            made.watch()
            self._running[source] = made
        return said

    def newest(self, sources: Sequence[DataSource]) -> "list[ContactShapes | None]":
        """Process of each source; None where there is none."""
        running = dict(self._running)
        return [running.get(each) if isinstance(each, LiveSource) else None for each in sources]

    def close(self) -> None:
        """End all."""
        self.viewers.clear()
        self.tend(())


if __name__ == "__main__":
    sys.exit(main())
