"""A recording in memory and what reconstructs it, for commands that need it as a whole."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from skinfield.cli.inputs import skin_from_text
from skinfield.cli.options import (
    OF_UNIT,
    QUANTITIES,
    conditioning_from_options,
    layer_from_options,
    patch_of,
    reconstructor_from_options,
)
from skinfield.cli.report import progress
from skinfield.fields import Estimate
from skinfield.pipeline import Reconstructor
from skinfield.pipeline.conditioned import Conditioned, condition, without_empty

CHUNK = 64  # readings per step of the progress bar; bounds the memory of the fields


@dataclass(frozen=True, eq=False)
class Job:
    """A recording and what reconstructs it."""

    reconstructor: Reconstructor
    conditioned: Conditioned
    quantity: str

    def __len__(self) -> int:
        return len(self.conditioned.values)

    def estimates(self) -> Iterator[tuple[int, Estimate]]:
        """Batches of estimates, each with the index of its first reading."""
        stamps = self.conditioned.recording.stamp_ns
        for first in range(0, len(self), CHUNK):
            part = slice(first, first + CHUNK)
            yield first, self.reconstructor(self.conditioned.values[part], stamp_ns=stamps[part])


def prepare(recording: str, layout: str, patch_name: str | None, **options: Any) -> Job:
    """Open, condition and prepare."""
    from skinfield.sources import open_recording, readings_for

    skin = skin_from_text(layout)
    patch = patch_of(skin, patch_name)
    layer = layer_from_options(options["thickness_mm"], options["modulus_kpa"], options["poisson"])
    how = conditioning_from_options(
        patch,
        **{key: options[key] for key in ("board", "no_load", "gain", "calibration", "smooth_ms",
                                         "noise")},
    )  # fmt: skip
    with progress() as bar:
        task = bar.add_task("reading", total=None)
        opened = open_recording(
            recording, progress=lambda done, total: bar.update(task, completed=done, total=total)
        )
    readings = readings_for(opened, patch)
    name = OF_UNIT[readings.unit] if options["quantity"] == "auto" else options["quantity"]
    quantity = QUANTITIES[name]()
    conditioned = without_empty(condition(readings, patch, layer, quantity, how))
    reconstructor = reconstructor_from_options(
        patch, layer, quantity, conditioned.noise_std, options
    )
    return Job(reconstructor, conditioned, name)
