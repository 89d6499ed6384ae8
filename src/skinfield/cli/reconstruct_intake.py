"""From a recording, however long, to readings on the disk that a reconstruction takes."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any

import numpy as np

from skinfield.cli.inputs import skin_from_text
from skinfield.cli.options import (
    MECHANICS,
    OF_UNIT,
    QUANTITIES,
    SOLVERS,
    conditioning_from_options,
    layer_from_options,
    patch_of,
)
from skinfield.cli.report import progress
from skinfield.conditioning import NoFilter
from skinfield.contacts import ContactFinder
from skinfield.errors import Floats, InputError
from skinfield.layout import Grid, Patch
from skinfield.pipeline.batch_format import Extent, narrowed, widened
from skinfield.pipeline.batch_recipe import Recipe
from skinfield.pipeline.conditioned import Conditioning, impossible_note
from skinfield.pipeline.survey import Survey, survey
from skinfield.reading import Recording
from skinfield.sinks.pending import explained

PIECE = 1 << 20  # numbers that are looked at together: 8 MB
FEWEST, MOST = 2048, 16384  # readings that are: enough to see motion, and what stands still


@dataclass(eq=False)
class Spool:
    """A recording's numbers in a file without name, block by block in the narrowest type."""

    file: IO[bytes]
    patch: Patch
    like: Recording | None = None
    notes: tuple[str, ...] = ()
    skipped: int = 0
    divisor: int = 1
    extent: Extent = field(default_factory=Extent)
    blocks_written: int = 0

    def add(self, block: Recording) -> None:
        """Append readings in the order of the patch's taxels."""
        from skinfield.sources import readings_for

        mine = readings_for(block, self.patch)
        extent = Extent()
        extent.add(mine.counts)
        self.extent.add(mine.counts)
        np.save(self.file, mine.stamp_ns)
        np.save(self.file, narrowed(mine.counts, extent.kind()))
        self.blocks_written += 1
        if self.like is None:
            self.like = replace(mine, stamp_ns=mine.stamp_ns[:0], counts=mine.counts[:0])
            self.notes = mine.notes[len(block.notes) :]

    def blocks(self) -> Iterator[Recording]:
        """All of it again, in blocks of one size, but for the last: a short rest joins it."""
        assert self.like is not None
        size = int(np.clip(PIECE // len(self.patch), FEWEST, MOST))
        stamps, counts = self.like.stamp_ns, self.like.counts
        for some, more in self._stored():
            stamps, counts = np.concatenate([stamps, some]), np.concatenate([counts, more])
            while len(stamps) >= 2 * size:
                yield replace(self.like, stamp_ns=stamps[:size], counts=counts[:size])
                stamps, counts = stamps[size:], counts[size:]
        yield replace(self.like, stamp_ns=stamps, counts=counts)

    def _stored(self) -> Iterator[tuple[Any, Floats]]:
        self.file.seek(0)
        for _ in range(self.blocks_written):
            stamps = np.load(self.file, allow_pickle=False) // self.divisor
            yield stamps, widened(np.load(self.file, allow_pickle=False))


def take_in(
    recording: str, layout: str, patch_name: str | None, path: Path, options: dict[str, Any]
) -> int:
    """Read and condition a recording, and write it as results to `path`; lines skipped."""
    skin = skin_from_text(layout)
    patch = patch_of(skin, patch_name)
    layer = layer_from_options(options["thickness_mm"], options["modulus_kpa"], options["poisson"])
    grid = Grid.square(patch, nodes=options["grid"])
    names = ("board", "no_load", "gain", "calibration", "smooth_ms", "noise")
    how = conditioning_from_options(patch, **{name: options[name] for name in names})
    with explained(path), TemporaryFile(dir=path.parent) as file:
        spool = _spooled(recording, Spool(file, patch))
        assert spool.like is not None
        unit = spool.like.unit
        name = OF_UNIT[unit] if options["quantity"] == "auto" else options["quantity"]
        quantity = QUANTITIES[name]()
        with progress() as bar:
            bar.add_task("looking for rest and faults", total=None)
            found = survey(spool.blocks, patch, layer, quantity, how)
        recipe = Recipe(
            patch,
            layer,
            grid,
            MECHANICS[options["mechanics"]](),
            quantity,
            SOLVERS[options["solver"]](),
            found.noise_std,
            ContactFinder(),
        )
        _write(spool, found, how, recipe, path)
    return spool.skipped


def _spooled(recording: str, spool: Spool) -> Spool:
    """Everything that a recording holds, parsed once."""
    from skinfield.sources import stream_recording

    with progress() as bar:
        task = bar.add_task("reading", total=None)
        opened = stream_recording(
            recording, progress=lambda done, total: bar.update(task, completed=done, total=total)
        )
        if isinstance(opened, Recording):
            for first in range(0, len(opened), MOST):
                part = slice(first, first + MOST)
                spool.add(
                    replace(opened, stamp_ns=opened.stamp_ns[part], counts=opened.counts[part])
                )
            spool.notes = opened.notes + spool.notes
        else:
            for block in opened.blocks():
                spool.add(block)
            spool.notes = opened.notes + spool.notes
            spool.divisor = opened.divisor
        spool.skipped = opened.skipped
    if spool.like is None:
        raise InputError(f"{recording} holds no reading, expected one or more")
    return spool


def _write(spool: Spool, found: Survey, how: Conditioning, recipe: Recipe, path: Path) -> None:
    """Condition what is spooled, block by block: counts stay counts where no filter mixes them."""
    from skinfield.sinks import open_results_file

    assert spool.like is not None
    plain = isinstance(how.filter, NoFilter)
    keeps_counts = plain and found.conditioner.calibration is not None
    extent = spool.extent if plain else Extent(whole=False, single=False)
    kind = extent.kind(float(np.min(found.noise_std))) if plain else np.dtype("<f4")
    state = None if plain else how.filter.prepare(len(spool.patch), found.rate)
    impossible, dropped, count = 0, 0, 0
    with open_results_file(
        path, recipe, kind, source=spool.like.source,
        conditioner=found.conditioner if keeps_counts else None,
    ) as writer:  # fmt: skip
        for block in spool.blocks():
            values, low = found.conditioner.counted(block.counts)
            if state is not None:
                values = values.copy()
                for row in values:
                    state.apply(row, row)
            there = np.asarray(~np.isnan(values).all(axis=1))
            kept = block.counts if keeps_counts else values
            writer.write(block.stamp_ns[there], kept[there])
            impossible, dropped = impossible + low, dropped + int((~there).sum())
            count += len(there)
        if dropped == count:
            raise InputError(
                f"{spool.like.source} has no reading with a valid taxel, expected some: "
                "check the layout, the board's convention and the calibration"
            )
        notes = (*spool.notes, *found.notes, *impossible_note(impossible, recipe.quantity))
        if dropped:
            notes += (f"{dropped} of {count} readings have no valid taxel: left out",)
        writer.close(notes)
