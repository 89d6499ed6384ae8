"""What a live skin's ring holds beside its slots: counters, times, calibration and notes."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skinfield.acquisition import Blocks, Count, Kind
from skinfield.acquisition.block import CALIBRATED, LONGEST, block_bytes
from skinfield.contacts.live import CONTACT
from skinfield.engine.state import Answer
from skinfield.errors import FileError, InputError
from skinfield.live.configuration import FIELD as CONFIGURATION
from skinfield.live.notes import FIELD as NOTES
from skinfield.live.recipe import Recipe
from skinfield.live.settings import LiveSettings
from skinfield.live.slots import PATCH, Head, Sizes
from skinfield.live.tare import Tared
from skinfield.live.tuning import FIELD as TUNING
from skinfield.realtime.timing import FIELDS as TIMING
from skinfield.realtime.timing import TIMES, TOTALS
from skinfield.ring import Field, Ring, RingReader

VERSION = 1
ROOM = 1 << 26  # bytes for slots
FEWEST, MOST = 64, 1024  # slots
SECONDS = 4.0  # of readings in the log
BYTES_PER_TAXEL = 6.0  # of a reading, heads of blocks among them
POLLED = 1 << 22  # bytes for what the sources bring at once
CALIBRATION_ROWS = LONGEST // CALIBRATED  # taxels in one block


def status_fields(sources: int, taxels: int) -> list[Field]:
    """Fields of the ring's status."""
    return [
        *(Field(*each) for each in TIMING),
        Field("sources", "<i8", (sources, len(Count))),
        Field("calibration", "<f8", (taxels, 4)),
        Field("noise_std", "<f8", (taxels,)),
        Field("stale_ns", "<i8", (1,)),
        Field("tares", "<i8", (1,)),  # calibrations since the ring was made; 0: none yet
        Field("tracks", "<i8", (1,)),  # contacts numbered so far
        NOTES,
        TUNING,
        CONFIGURATION,
    ]


def description_of(settings: LiveSettings, recipe: Recipe) -> dict[str, object]:
    """What readers must know, in plain values."""
    names = [type(source).__name__ for source in settings.sources]
    return describe(settings.name, recipe, names, settings.period) | {
        "source_settings": [repr(source)[:500] for source in settings.sources],
        "rate": settings.rate,
        "deadline": settings.due_after,
    }


def describe(name: str, recipe: Recipe, sources: Sequence[str], period: float) -> dict[str, object]:
    """What readers must know of any ring with estimates."""
    return {
        "skinfield_live": VERSION,
        "name": name,
        "skin": recipe.skin.name,
        "patches": [patch.name for patch in recipe.skin],
        "taxels": [len(patch) for patch in recipe.skin],
        "links": [patch.link for patch in recipe.skin],
        "sources": list(sources),
        "source_counters": [each.name.lower() for each in Count],
        "period": period,
        "budget": recipe.budget,
        "rungs": list(recipe.rungs),
        "head": [each.name.lower() for each in Head],
        "answers": [each.name.lower() for each in Answer],
        "times": list(TIMES),
        "totals": list(TOTALS),
        "patch_row": PATCH.descr,
        "contact_row": CONTACT.descr,
        "recipe": recipe.to_json(),
    }


def slots_for(fields: list[Field]) -> int:
    """So many cycles that a reader may be held up for a while, within reason."""
    size = sum(np.dtype(each.dtype).itemsize * math.prod(each.shape) for each in fields)
    return int(min(max(ROOM // size, FEWEST), MOST))


def log_for(taxels: int, rate: float | None) -> int:
    """Bytes of the log: a power of two that holds some seconds of readings."""
    wanted = SECONDS * BYTES_PER_TAXEL * taxels * (rate or 1000.0)
    return 1 << int(min(max(math.ceil(math.log2(wanted)), 24), 28))


def room_for(taxels: int) -> int:
    """Bytes for the blocks of one poll, or of a whole calibration."""
    whole, rest = divmod(taxels, CALIBRATION_ROWS)
    kind = int(Kind.CALIBRATION)
    return max(POLLED, whole * block_bytes(kind, CALIBRATION_ROWS) + block_bytes(kind, rest))


def open_ring(settings: LiveSettings, recipe: Recipe) -> tuple[Ring, bool]:
    """The ring of this skin: that of an engine that died, if it fits, else a new one.

    Returns
    -------
    Ring
    bool
        Whether it is new.

    Raises
    ------
    InputError
        If its log cannot hold what one poll may bring, or another engine writes it.
    """
    sizes = Sizes.of(settings.skin, settings.rungs, settings.rows)
    slot, status = sizes.fields(), status_fields(len(settings.sources), sizes.taxels)
    wanted, slots = description_of(settings, recipe), settings.slots or slots_for(slot)
    log, least = settings.log_bytes or log_for(sizes.taxels, settings.rate), room_for(sizes.taxels)
    if log < least:
        raise InputError(
            f"log_bytes is {log}, expected at least {least}: what the sources bring at once, or "
            "a calibration, must fit into the ring's log"
        )
    try:
        ring = Ring.reopen(settings.name, slot, status, slots, log)
        if goes_on(ring, recipe):
            return ring, False
        ring.close()
    except InputError:  # there is none, or one of another skin: if it is in use, the next says so
        pass
    made = Ring.create(settings.name, slot, status, wanted, slots, log)
    return made, True


def goes_on(ring: Ring, recipe: Recipe) -> bool:
    """Whether a ring is of a skin with this recipe; its solver may have been another."""
    try:
        before = Recipe.from_json(str(ring.description.get("recipe")))
        return replace(before, solver=recipe.solver).to_json() == recipe.to_json()
    except FileError:
        return False


def write_tare(ring: Ring, tared: Tared, blocks: Blocks, now_ns: int) -> None:
    """Publish a calibration: in the status for who comes later, and in the log for recordings."""
    status = ring.status
    status["calibration"][:] = tared.calibration
    status["noise_std"][:] = tared.noise_std
    status["stale_ns"][0] = tared.stale_ns
    status["tares"][0] += 1
    rows = tared.rows()
    for first in range(0, len(rows), CALIBRATION_ROWS):
        part = rows[first : first + CALIBRATION_ROWS]
        blocks.put_rows(now_ns, first, Kind.CALIBRATION, part)


def known_tare(ring: Ring | RingReader) -> Tared | None:
    """The calibration in a ring's status; None where none was taken yet."""
    status = ring.status
    if status["tares"][0] < 1:
        return None
    return Tared(
        status["calibration"].copy(),
        status["noise_std"].copy(),
        int(status["stale_ns"][0]),
        ("the calibration of the engine that ran before",),
    )
