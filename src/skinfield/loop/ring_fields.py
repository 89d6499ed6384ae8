"""Fields of a live skin's ring beside its slots: counters, times, calibration and notes."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skinfield.errors import FileError, InputError
from skinfield.estimate.live_contacts import CONTACT
from skinfield.loop.baseline import TareBaseline
from skinfield.loop.model_config import FIELD as CONFIGURATION
from skinfield.loop.model_config import ModelConfig
from skinfield.loop.realtime.timing import FIELDS as TIMING
from skinfield.loop.realtime.timing import TIMES, TOTALS
from skinfield.loop.settings import LiveSettings
from skinfield.loop.slots import PATCH, CycleHead, Sizes
from skinfield.loop.status_text import FIELD as NOTES
from skinfield.reconstruct.engine.state import Answer
from skinfield.ring import Field, Ring, RingReader
from skinfield.signal import Count

VERSION = 4
ROOM = 1 << 26  # bytes for slots
FEWEST, MOST = 64, 1024  # slots
SECONDS = 4.0  # of readings in the log
BYTES_PER_TAXEL = 6.0  # of a reading, heads of blocks among them
POLLED = 1 << 22  # bytes for what the sources bring at once


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
        CONFIGURATION,
    ]


def description_of(settings: LiveSettings, model_config: ModelConfig) -> dict[str, object]:
    """What readers must know, in plain values."""
    names = [type(source).__name__ for source in settings.sources]
    return describe(settings.name, model_config, names, settings.period) | {
        "source_settings": [repr(source)[:500] for source in settings.sources],
        "rate": settings.rate,
        "deadline": settings.due_after,
        "settings": dict(settings.tree),
    }


def describe(
    name: str, model_config: ModelConfig, sources: Sequence[str], period: float
) -> dict[str, object]:
    """What readers must know of any ring with estimates."""
    return {
        "skinfield_live": VERSION,
        "name": name,
        "skin": model_config.skin.name,
        "patches": [patch.name for patch in model_config.skin],
        "taxels": [len(patch) for patch in model_config.skin],
        "links": [patch.link for patch in model_config.skin],
        "sources": list(sources),
        "source_counters": [each.name.lower() for each in Count],
        "period": period,
        "budget": model_config.budget,
        "rungs": list(model_config.rungs),
        "relative": model_config.relative,
        "head": [each.name.lower() for each in CycleHead],
        "answers": [each.name.lower() for each in Answer],
        "times": list(TIMES),
        "totals": list(TOTALS),
        "patch_row": PATCH.descr,
        "contact_row": CONTACT.descr,
        "model_config": model_config.to_json(),
    }


def slots_for(fields: list[Field]) -> int:
    """So many cycles that a reader may be held up for a while, within reason."""
    size = sum(np.dtype(each.dtype).itemsize * math.prod(each.shape) for each in fields)
    return int(min(max(ROOM // size, FEWEST), MOST))


def log_for(taxels: int, rate: float | None) -> int:
    """Bytes of the log: a power of two that holds some seconds of readings."""
    wanted = SECONDS * BYTES_PER_TAXEL * taxels * (rate or 1000.0)
    return 1 << int(min(max(math.ceil(math.log2(wanted)), 24), 28))


def open_ring(settings: LiveSettings, model_config: ModelConfig) -> tuple[Ring, bool]:
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
    wanted, slots = description_of(settings, model_config), slots_for(slot)
    log = settings.log_bytes or log_for(sizes.taxels, settings.rate)
    if log < POLLED:
        raise InputError(
            f"log_bytes is {log}, expected at least {POLLED}: what the sources bring at once must "
            "fit into the ring's log"
        )
    try:
        ring = Ring.reopen(settings.name, slot, status, slots, log)
        if goes_on(ring, model_config):
            return ring, False
        ring.close()
    except InputError:  # there is none, or one of another skin: if it is in use, the next says so
        pass
    made = Ring.create(settings.name, slot, status, wanted, slots, log)
    return made, True


def goes_on(ring: Ring, model_config: ModelConfig) -> bool:
    """Whether a ring is of a skin with this configuration; its solver may have been another."""
    try:
        before = ModelConfig.from_json(str(ring.description.get("model_config")))
        return replace(before, solver=model_config.solver).to_json() == model_config.to_json()
    except FileError:
        return False


def write_baseline(ring: Ring, baseline: TareBaseline) -> None:
    """Publish a calibration."""
    status = ring.status
    status["calibration"][:] = baseline.calibration
    status["noise_std"][:] = baseline.noise_std
    status["stale_ns"][0] = baseline.stale_ns
    status["tares"][0] += 1


def known_baseline(ring: Ring | RingReader) -> TareBaseline | None:
    """The calibration in a ring's status; None where none was taken yet."""
    status = ring.status
    if status["tares"][0] < 1:
        return None
    return TareBaseline(
        status["calibration"].copy(),
        status["noise_std"].copy(),
        int(status["stale_ns"][0]),
        ("the calibration of the engine that ran before",),
    )
