"""What comes over zenoh: any bytes are refused, or are a cycle that can be shown."""

import contextlib
import json
from collections.abc import Callable

import numpy as np

import skinfield as sf
from skinfield.bridges.zenoh.messages import (
    EstimateForm,
    EstimateHead,
    RemoteCalibration,
    described,
    status_from,
    strict_json,
)
from skinfield.bridges.zenoh.session import Keys
from skinfield.elastic import BondedLayer, Capacitance
from skinfield.errors import InputError
from skinfield.loop import Answer
from skinfield.loop.model_config import Configuration, ModelConfig, Models
from skinfield.loop.ring_fields import describe
from skinfield.loop.runtime_parameters import Tuning
from skinfield.loop.slots import Sizes, SlotLayout
from skinfield.loop.snapshot import Snapshot
from skinfield.loop.status import plain_contacts
from skinfield.signal import ICubByte, Port
from skinfield.solve import Tikhonov

MODEL_CONFIG = ModelConfig(
    skin=sf.Skin((sf.layouts.icub_triangle(),), name="one"),
    ports=(Port("port", 16),),
    layer=sf.Layer(2e-3, 150e3, 0.5),
    mechanics=BondedLayer(),
    quantity=Capacitance(),
    solver=Tikhonov(),
    rungs=(4, 8),
    board=ICubByte(),
    budget=1e-3,
    rows=3,
)
SIZES = Sizes.of(MODEL_CONFIG.skin, MODEL_CONFIG.rungs, MODEL_CONFIG.rows)
TOLD = describe("one", MODEL_CONFIG, ["Source"], 1e-3)
DESCRIPTION = described("robot", "one", TOLD, SlotLayout.of(SIZES.fields()))
PLAN = EstimateForm.of(DESCRIPTION)
KNOWN = Configuration(1, Tikhonov(), Tuning())
NOISE = RemoteCalibration(1, KNOWN, np.full(len(MODEL_CONFIG.skin[0]), 1e-3))
STATUS = strict_json(status_from(b'{"name": "one", "state": "running"}', MODEL_CONFIG.skin))
HEAD = EstimateHead(1, 2, 3, 4, 5, 6, PLAN.fingerprint).packed()


def cycle() -> bytes:
    """A good one, with a contact."""
    slot = PLAN.layout.slot()
    slot.patches["answer"], slot.patches["rung"], slot.patches["contacts"] = 2, 8, 1
    slot.patches["stamp_ns"] = 10**18
    data = bytearray(PLAN.layout.size)
    for placed in PLAN.layout.fields:
        octets = getattr(slot, placed.field.name).tobytes()
        data[placed.offset : placed.offset + placed.size] = octets
    return bytes(data)


CYCLE = cycle()
GOOD = [CYCLE, DESCRIPTION, NOISE.packed(), STATUS, HEAD]
SEEDS = [b"", HEAD, STATUS, NOISE.packed(), bytes([0, 8, 0, 1]) + bytes(8), b"\x01" * 22]


def one_input(data: bytes) -> None:
    """Take the bytes as each kind of message, and as changes of good ones."""
    for read in READS:
        tried(read, data)
    if data:
        kind = data[0] % len(GOOD)
        tried(READS[kind], changed(GOOD[kind], data[1:]))


def changed(good: bytes, data: bytes) -> bytes:
    """Each 11 bytes: place (3), how many of the 8 bytes that follow come there."""
    made = bytearray(good)
    for at in range(0, len(data) - 10, 11):
        place = int.from_bytes(data[at : at + 3], "little") % len(good)
        size = data[at + 2] % 8 + 1
        made[place : place + size] = data[at + 3 : at + 3 + size]
    return bytes(made)


def tried(read: Callable[[bytes], None], data: bytes) -> None:
    """Read, or refuse."""
    with contextlib.suppress(InputError):
        read(data)


def read_cycle(data: bytes) -> None:
    """What the page and programs do with a cycle must go well."""
    slot = PLAN.slot(data)
    models = Models(MODEL_CONFIG, NOISE.noise_std)
    snapshot = Snapshot(slot, 1, models, 2 * 10**18)
    json.dumps(plain_contacts([patch.name for patch in MODEL_CONFIG.skin], slot.used_contacts()))
    assert len(snapshot.ages()) == 1
    for name in snapshot:
        assert np.isfinite(snapshot[name].pressure).all()
        if snapshot.patches["answer"][0] == Answer.CONTACTS:
            assert all(np.isfinite(each.position).all() for each in snapshot[name].contacts)
    assert np.isfinite(snapshot.force)


def read_description(data: bytes) -> None:
    """A description, and the slots that follow from it."""
    plan = EstimateForm.of(data)
    assert plan.layout.size < 1 << 29
    plan.layout.slot()


def read_calibration(data: bytes) -> None:
    """Noise and solver."""
    found = RemoteCalibration.of(data, len(MODEL_CONFIG.skin[0]))
    assert np.isfinite(found.noise_std).all()


def read_status(data: bytes) -> None:
    """Status: afterwards it has every member, and can be shown."""
    status = status_from(data, MODEL_CONFIG.skin)
    assert status.keys() == json.loads(STATUS).keys()
    json.dumps(status, allow_nan=False)


def read_head(data: bytes) -> None:
    """Head of an estimate; and a key."""
    assert EstimateHead.of(data).packed() == data
    Keys.of(data.decode(errors="replace"))


READS = [read_cycle, read_description, read_calibration, read_status, read_head]
