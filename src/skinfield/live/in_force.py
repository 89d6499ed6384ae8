"""What a replay goes by beside readings and calibration, as the blocks of a recording tell it."""

import numpy as np

from skinfield.acquisition import Blocks, Kind, blocks_of
from skinfield.acquisition.block import PAYLOAD, WORD, Octets, block_bytes
from skinfield.errors import FileError, InputError
from skinfield.live.configuration import Configuration, configuration_in
from skinfield.live.cycle import Cycle
from skinfield.live.recipe import Recipe
from skinfield.live.tuning import Tuning


class InForce:
    """Tuning, low-pass and configuration, from block to block.

    Parameters
    ----------
    recipe : Recipe
        Of the engine that began.
    taxels : int

    Attributes
    ----------
    tuning : Tuning
    configuration : Configuration
    """

    def __init__(self, recipe: Recipe, taxels: int) -> None:
        self._names = [patch.name for patch in recipe.skin]
        self._rungs = recipe.rungs
        self.tuning = Tuning(deadline=recipe.budget)
        self.configuration = Configuration(1, recipe.solver)
        self._smoothed = np.zeros(taxels, PAYLOAD[Kind.SMOOTHED])

    def take(self, data: bytes | Octets, cycle: Cycle | None) -> None:
        """Take over what blocks say, and have a cycle do so.

        Raises
        ------
        FileError
            If they are damaged.
        """
        for block in blocks_of(data):
            if block.kind == Kind.TUNING:
                self.tuning = self._tuning(block.payload)
                if cycle is not None:
                    cycle.tuned.tune(self.tuning)
            elif block.kind == Kind.SMOOTHED:
                end = block.channel + block.count
                if end > len(self._smoothed):
                    raise FileError(
                        f"a low-pass is of {end} taxels or more, expected {len(self._smoothed)}"
                    )
                self._smoothed[block.channel : end] = block.payload
                if cycle is not None and end == len(self._smoothed):
                    cycle.tuned.go_on_smoothing(self._smoothed)
            elif block.kind == Kind.CONFIGURATION:
                self.configuration = configuration_in(block)

    def _tuning(self, payload: object) -> Tuning:
        try:
            tuning = Tuning.from_numbers(np.asarray(payload), self._names)
        except InputError as error:
            raise FileError(f"a tuning in the recording cannot be used: {error}") from error
        if tuning.resolution != "auto" and tuning.resolution not in self._rungs:
            raise FileError(
                f"a tuning in the recording is of {tuning.resolution} nodes a side, expected one "
                f"of {self._rungs}: it is damaged"
            )
        return tuning

    def apply(self, cycle: Cycle) -> None:
        """Have a cycle that begins go by all of it."""
        cycle.tuned.tune(self.tuning)
        if self.tuning.smoothing:
            cycle.tuned.go_on_smoothing(self._smoothed)


def beginning(blocks: Blocks, at: int) -> int:
    """Word at which the last engine's process begins that begins from word `at` on; -1: none."""
    from skinfield.acquisition.kernel import find_kind

    found, kind = -1, int(Kind.CONFIGURATION)
    while (at := find_kind(blocks.words, at, int(blocks.end[0]), kind)) >= 0:
        block = next(blocks_of(blocks.octets[at * WORD : int(blocks.end[0]) * WORD]))
        if configuration_in(block).began:
            found = at
        at += block_bytes(kind, block.count) // WORD
    return found
