"""What an engine goes by, in its ring: in the status for readers, in the log for replays."""

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from skinfield.acquisition import Blocks, Kind
from skinfield.acquisition.block import LONGEST
from skinfield.errors import InputError, check_type
from skinfield.live.configuration import FIELD as CONFIGURATION
from skinfield.live.configuration import Configuration, write_configuration
from skinfield.live.cycle import Cycle
from skinfield.live.settings import LiveSettings
from skinfield.live.tuning import FIELD as TUNING
from skinfield.live.tuning import Limits, Tuning
from skinfield.ring import Ring


class Journal:
    """Logs readings, and with each key cycle all that a replay which begins there must know.

    Parameters
    ----------
    ring : Ring
    blocks : Blocks
        Of the last poll of the sources.
    settings : LiveSettings
    fresh : bool
        Whether the ring is new; else the tuning in it stays in force.

    Attributes
    ----------
    tuning : Tuning
    budget_ns : int, ns
        For the reconstruction.
    """

    def __init__(self, ring: Ring, blocks: Blocks, settings: LiveSettings, fresh: bool) -> None:
        self._ring, self._blocks = ring, blocks
        self._patches = [patch.name for patch in settings.skin]
        self._limits = Limits.of(ring.description)
        self.tuning = settings.tuning
        if not fresh and ring.status[TUNING.name].any():
            self.tuning = Tuning.from_numbers(ring.status[TUNING.name], self._patches)
        configuration = Configuration(ring.generation, settings.solver, began=True)
        write_configuration(ring.status[CONFIGURATION.name], configuration)
        blocks.put_rows(time.time_ns(), 0, Kind.CONFIGURATION, configuration.octets())
        self._configuration = replace(configuration, began=False).octets()
        self._take_over(None)

    def log(self) -> None:
        """Log what was taken in; what is logged is not logged again."""
        blocks = self._blocks
        if blocks.end[0]:
            self._ring.log(blocks.octets, int(blocks.end[0]) * 8)
            blocks.clear()

    def tune(self, changes: object, cycle: Cycle | None) -> None:
        """Change the tuning.

        Raises
        ------
        InputError
            For what this engine cannot be tuned to; nothing changed then.
        """
        check_type("changes", changes, Mapping, "values by the names of settings")
        assert isinstance(changes, Mapping)
        self.tuning = self._limits.check(self.tuning.changed(changes))
        self._take_over(cycle)

    def _take_over(self, cycle: Cycle | None) -> None:
        """From the next cycle on the tuning is in force."""
        self.budget_ns = round(self.tuning.deadline * 1e9)
        self._numbers = self.tuning.numbers(self._patches)
        self._ring.status[TUNING.name][:] = self._numbers
        self._blocks.put_rows(time.time_ns(), 0, Kind.TUNING, self._numbers)
        self.log()
        if cycle is not None:
            cycle.tuned.tune(self.tuning)

    def key(self, cycle: Cycle, now_ns: int) -> None:
        """Before a key cycle: all that does not follow from readings and calibration."""
        self.log()  # so that there is room
        self._blocks.put_rows(now_ns, 0, Kind.CONFIGURATION, self._configuration)
        self._blocks.put_rows(now_ns, 0, Kind.TUNING, self._numbers)
        if cycle.tuned.smoothing:
            rows = cycle.tuned.smoothed
            for first in range(0, len(rows), LONGEST):
                part = rows[first : first + LONGEST]
                self._blocks.put_rows(now_ns, first, Kind.SMOOTHED, part)


def tune_or_say(journal: Journal, order: Mapping[str, Any], cycle: Cycle | None) -> str:
    """Obey an order to change the tuning; why it was refused, or nothing."""
    try:
        journal.tune(order.get("set"), cycle)
    except InputError as error:
        return str(error)
    return ""
