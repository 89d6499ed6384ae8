"""Messages over zenoh: there and back, and any bytes refused."""

import json

import fuzz_zenoh
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skinfield as sf
from skinfield.bridges.zenoh.messages import (
    EstimateForm,
    EstimateHead,
    RemoteCalibration,
    status_from,
    strict_json,
)
from skinfield.bridges.zenoh.session import Keys, chunk
from skinfield.errors import InputError
from skinfield.loop.model_config import Configuration
from skinfield.loop.runtime_parameters import Tuning
from skinfield.solve import NonNegative

words = st.integers(0, (1 << 62) - 1)


@settings(max_examples=50, deadline=None)
@given(st.tuples(st.integers(0, 2**32 - 1), words, words, words, words, words), st.binary())
def test_heads_go_there_and_back(numbers, rest) -> None:
    head = EstimateHead(*numbers, (rest + bytes(16))[:16])
    assert EstimateHead.of(head.packed()) == head
    assert len(head.packed()) == 64


@settings(max_examples=50, deadline=None)
@given(st.text(min_size=1, max_size=20), st.text(min_size=1, max_size=20))
def test_any_name_is_one_chunk_of_a_key_and_comes_back(robot, name) -> None:
    part = Keys(robot, name)
    assert Keys.of(part.key("alive")) == part
    key = part.patch_key(robot, "raw")
    assert key.count("/") == 5
    assert not set(key) & set("*$?#@ ")
    assert chunk("left_arm-2.a~") == "left_arm-2.a~"


@settings(max_examples=60, deadline=None)
@given(data=st.binary(max_size=300))
def test_any_bytes_are_refused_or_can_be_shown(data) -> None:
    fuzz_zenoh.one_input(data)


@settings(max_examples=60, deadline=None)
@given(
    kind=st.integers(0, 4),
    changes=st.lists(st.tuples(st.integers(0, 1 << 16), st.binary(min_size=8, max_size=8))),
)
def test_good_messages_with_changes_too(kind, changes) -> None:
    data = b"".join(place.to_bytes(3, "little") + octets for place, octets in changes)
    fuzz_zenoh.one_input(bytes([kind]) + data)


def test_the_sample_is_good() -> None:
    for read, good in zip(fuzz_zenoh.READS[:4], fuzz_zenoh.GOOD[:4], strict=True):
        read(good)
    slot = fuzz_zenoh.PLAN.slot(fuzz_zenoh.CYCLE)
    assert slot.patches["answer"].tolist() == [2]


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"skinfield_zenoh": 2}, "of version 2, expected 1"),
        ({"ring": {}}, "model_config"),
        ({"slot_bytes": 7}, "slots have 7 bytes"),
        ({"slot": []}, "another skinfield"),
    ],
)
def test_descriptions_that_do_not_fit_say_why(change, match) -> None:
    plain = json.loads(fuzz_zenoh.DESCRIPTION) | change
    with pytest.raises(InputError, match=match):
        EstimateForm.of(strict_json(plain))


@pytest.mark.parametrize("rungs", [[100_000], [], [True], ["a"], list(range(2, 900))])
def test_a_description_cannot_ask_for_all_memory(rungs) -> None:
    plain = json.loads(fuzz_zenoh.DESCRIPTION)
    model_config = json.loads(plain["ring"]["model_config"]) | {"rungs": rungs}
    plain["ring"]["model_config"] = json.dumps(model_config)
    with pytest.raises(InputError):
        EstimateForm.of(strict_json(plain))


def test_calibrations_go_there_and_back() -> None:
    noise = np.linspace(1e-4, 1e-3, 5)
    made = RemoteCalibration(3, Configuration(2, NonNegative(tolerance=0.1), Tuning()), noise)
    found = RemoteCalibration.of(made.packed(), 5)
    assert found[:2] == made[:2]
    np.testing.assert_array_equal(found.noise_std, noise)
    with pytest.raises(InputError, match="no noise of 6 taxels"):
        RemoteCalibration.of(made.packed(), 6)


def test_what_is_not_finite_becomes_null() -> None:
    text = strict_json({"a": [float("nan"), 1.0], "b": {"c": float("inf")}})
    assert json.loads(text) == {"a": [None, 1.0], "b": {"c": None}}


def test_a_status_is_of_this_skin() -> None:
    plain, skin = json.loads(fuzz_zenoh.STATUS), fuzz_zenoh.MODEL_CONFIG.skin
    assert status_from(fuzz_zenoh.STATUS, skin)["state"] == "running"
    with pytest.raises(InputError, match="expected those of the skin"):
        status_from(fuzz_zenoh.STATUS, sf.Skin((sf.layouts.hexagon72(),)))
    for wrong, match in (
        ({"state": "fine"}, "'fine'"),
        ({"lost": -1}, r">= 0.*\$\.lost"),
        ({"rate": 1e400}, "malformed"),
    ):
        with pytest.raises(InputError, match=match):
            status_from(json.dumps(plain | wrong).encode(), skin)
