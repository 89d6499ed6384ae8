"""One cycle: from blocks to a slot, and the same again from what a recording holds of it."""

import numpy as np
import pytest
from live_skins import LAYER, REST, cycle_of, pressed_counts, settings
from numpy.testing import assert_allclose, assert_array_equal

import skinfield as sf
from skinfield.errors import InputError
from skinfield.loop.baseline import unrounded
from skinfield.loop.model_config import ModelConfig, bind
from skinfield.loop.slots import Head, Slot
from skinfield.reconstruct.diagnostics import Conditioner
from skinfield.reconstruct.engine.state import Answer
from skinfield.signal import Blocks, Calibration, Channels, ICubByte, Kind, Port, Status

NOW = 10**18


@pytest.fixture(scope="module")
def made():
    return cycle_of(settings())


def fed(counts, stamp: int, status: Status = Status.OK, first: int = 0) -> Blocks:
    blocks = Blocks(1 << 12)
    blocks.put(stamp, first, counts, Kind.BYTES, status)
    return blocks


def test_values_are_those_of_the_conditioner(made) -> None:
    patch, rng = sf.layouts.hexagon72(), np.random.default_rng(3)
    counts = rng.integers(0, 256, 72).astype(float)  # clamps among them
    counts[:3] = 0, 255, 240
    known = Calibration(
        np.full(72, REST), np.full(72, -171.0), np.ones(72), np.ones(72, bool), patch.uid
    )
    expected = Conditioner(sf.Capacitance(), LAYER, known, ICubByte())(counts)
    channels, slot = Channels(72), Slot.empty(made.sizes)
    channels.apply(fed(counts, NOW))
    made.answer(channels, NOW, slot, reset=True)
    assert_array_equal(slot.valid.astype(bool), np.isfinite(expected))
    assert_allclose(slot.values, np.nan_to_num(expected), rtol=1e-6)
    assert_array_equal(slot.counts, counts)


def test_a_press_is_found_where_it_is(made) -> None:
    channels, slot = Channels(72), Slot.empty(made.sizes)
    channels.apply(fed(pressed_counts(1.0), NOW))
    assert made.answer(channels, NOW, slot, reset=True, budget=1.0)
    row = slot.used_contacts()[0]
    assert_allclose(row["position"][:2], (0.0, 7.5e-3), atol=2e-3)
    assert 0.5 < row["normal_force"] < 2.0
    assert slot.patches["answer"][0] == int(Answer.FEASIBLE)
    assert slot.head[Head.CONTACTS] == slot.patches["contacts"][0]
    nodes = int(slot.patches["rung"][0]) ** 2
    cell = sf.Grid.square(sf.layouts.hexagon72(), int(nodes**0.5)).pitch ** 2
    whole = slot.pressure[0, :nodes].sum() * cell  # a contact ends where its pressure is low
    assert 0.99 * slot.patches["force"][0] < whole < 1.6 * slot.patches["force"][0]


def test_half_a_reading_waits_for_the_other_half_but_not_for_ever(made) -> None:
    channels, slot = Channels(72), Slot.empty(made.sizes)
    channels.apply(fed(np.full(72, 240), NOW))
    assert made.answer(channels, NOW, slot, reset=True)
    channels.apply(fed(np.full(36, 230), NOW + 10**6))
    assert not made.answer(channels, NOW + 10**6, slot)
    assert slot.patches["fresh"][0] == 0
    channels.apply(fed(np.full(36, 230), NOW + 2 * 10**6, first=36))
    assert made.answer(channels, NOW + 2 * 10**6, slot)
    channels.apply(fed(np.full(36, 230), NOW + 3 * 10**6))
    assert not made.answer(channels, NOW + 4 * 10**6, slot)
    assert made.answer(channels, NOW + 14 * 10**6, slot)
    assert slot.patches["fresh"][0] == 36


def test_an_answer_is_not_repeated_as_new_and_goes_when_it_is_too_old(made) -> None:
    channels, slot = Channels(72), Slot.empty(made.sizes)
    channels.apply(fed(pressed_counts(1.0), NOW))
    made.answer(channels, NOW, slot, reset=True, budget=1.0)
    found = slot.used_contacts()
    assert not made.answer(channels, NOW + 10**6, slot)
    assert slot.head[Head.FRESH] == 0
    assert slot.patches["stamp_ns"][0] == NOW
    assert_array_equal(slot.used_contacts(), found)
    assert not made.answer(channels, NOW + 2 * 10**8, slot)
    assert slot.patches["answer"][0] == int(Answer.MISSING)
    assert len(slot.used_contacts()) == 0


def test_what_is_not_connected_is_left_out(made) -> None:
    channels, slot = Channels(72), Slot.empty(made.sizes)
    channels.apply(fed(np.full(72, 240), NOW))
    channels.apply(fed(np.zeros(12), NOW, Status.NOT_CONNECTED))
    made.answer(channels, NOW, slot, reset=True)
    assert_array_equal(slot.valid[:12], 0)
    assert slot.patches["invalid"][0] == 12


def test_a_model_config_survives_json() -> None:
    model_config = ModelConfig.of(settings(), (Port("port", 72),))
    other = ModelConfig.from_json(model_config.to_json())
    assert (other.solver, other.layer, other.rungs) == (
        model_config.solver,
        model_config.layer,
        model_config.rungs,
    )
    assert_array_equal(other.skin[0].positions, model_config.skin[0].positions)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"skin": 1}', '{"skin": {"patches": [3]}}'])
def test_a_damaged_model_config_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"configuration|patches"):
        ModelConfig.from_json(text)


def test_a_patch_beyond_its_port_is_refused() -> None:
    skin = sf.Skin((sf.layouts.hexagon72(),))
    with pytest.raises(InputError, match="reads channel 71, expected channels below 60"):
        bind(skin, [Port("port", 60)])


def test_patches_find_the_ports_of_their_names() -> None:
    patches = [sf.Patch(np.eye(3)[:, :2] * 1e-2, name=name) for name in ("left", "right")]
    found = bind(sf.Skin(tuple(patches)), [Port("right", 5), Port("left", 3)])
    assert_array_equal(found.channel, [5, 6, 7, 0, 1, 2])
    with pytest.raises(InputError, match="'left' has no port"):
        bind(sf.Skin(tuple(patches)), [Port("right", 5), Port("other", 3)])


def test_a_baseline_is_not_rounded() -> None:
    rng, patch = np.random.default_rng(5), sf.layouts.hexagon72()
    level = 240.0 + rng.uniform(-0.5, 0.5, 72)
    counts = np.rint(level + rng.normal(0.0, 0.5, (400, 72)))
    counts[:, 7] = np.nan  # never answered
    counts[11, 9] = 100.0  # once, nobody knows why
    known = Calibration(
        np.median(counts, axis=0), np.full(72, -171.0), np.full(72, 0.3), np.arange(72) != 7,
        patch.uid,
    )  # fmt: skip
    baseline, noise = unrounded(counts, known)
    others = np.arange(72) != 7
    assert_allclose(baseline[others], level[others], atol=0.12)  # four standard errors
    assert np.abs(np.median(counts, axis=0) - level)[others].max() > 0.4
    assert_allclose(noise[others], np.hypot(0.5, 12**-0.5), rtol=0.2)
