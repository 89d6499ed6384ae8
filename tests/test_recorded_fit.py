"""Bytes of a fit's record: the same comes back, and what cannot be is refused."""

import struct
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from skinfield.errors import InputError
from skinfield.files.mcap.schema import FIT_HEAD, FitLayout, FitRecord, FitSizes

CONTACT = np.dtype([("track", "<i8"), ("position", "<f8", (3,))])
PATCH = np.dtype([("contacts", "<i4"), ("stamp_ns", "<i8")])
FORM = np.dtype([("radius", "<f8")])
ROWS = FitLayout(PATCH, CONTACT, FORM)


def words(*numbers: int) -> Any:
    return np.array(numbers, np.uint32)


def record(**changes: Any) -> FitRecord:
    """Two of five patches, with two contacts and one."""
    contacts, forms = np.zeros(3, CONTACT), np.zeros(3, FORM)
    contacts["track"], contacts["position"] = [4, 9, 5], np.arange(9).reshape(3, 3)
    forms["radius"] = [1e-3, 2e-3, np.inf]
    made = FitRecord(
        time_ns=1_700_000_000_000_000_001,
        number=12,
        sizes=FitSizes(5, 100, 8),
        places=words(1, 4),
        pressed=words(3, 1),
        patches=np.array([(2, 7), (1, 8)], PATCH),
        contacts=contacts,
        forms=forms,
        nodes=words(5, 6, 99, 0),
        pressure=np.array([1.5, 1e-40, np.nan, -0.0], np.float32),
    )
    return replace(made, **changes)


def test_the_same_comes_back() -> None:
    made = record()
    data = ROWS.encode(made)
    found = ROWS.decode(data)
    for name, value in vars(made).items():
        other = getattr(found, name)
        same = other == value if not isinstance(value, np.ndarray) else (
            other.dtype == value.dtype and other.tobytes() == value.tobytes()
        )  # fmt: skip
        assert same, name
    assert len(data) == 56 + 2 * (8 + 12) + 3 * (32 + 8) + 4 * 8
    assert FitLayout.from_metadata(ROWS.metadata()) == ROWS


def test_one_that_knows_of_nothing_is_a_head() -> None:
    rows = np.zeros(0, PATCH), np.zeros(0, CONTACT), np.zeros(0, FORM)
    none = FitRecord(1, 0, FitSizes(1, 1, 1), words(), words(), *rows, words(), np.zeros(0, "<f4"))
    data = ROWS.encode(none)
    assert len(data) == FIT_HEAD.size == 56
    assert ROWS.decode(data).number == 0


@pytest.mark.parametrize(
    "changes",
    [
        {"places": words(4, 1)},
        {"places": words(1, 5)},
        {"places": words(1, 1)},
        {"patches": np.array([(2, 7), (2, 8)], PATCH)},
        {"patches": np.array([(4, 7), (-1, 8)], PATCH)},
        {"sizes": FitSizes(5, 100, 1)},
        {"sizes": FitSizes(5, 99, 8)},
        {"sizes": FitSizes(1 << 20, 100, 8)},
        {"sizes": FitSizes(5, 0, 8)},
        {"pressed": words(3, 2)},
    ],
)
def test_parts_that_do_not_go_together_are_refused(changes: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="expected one number of each kind"):
        ROWS.encode(record(**changes))


def test_bytes_that_do_not_go_together_are_refused() -> None:
    data = ROWS.encode(record())
    for end in (0, 55, 56, len(data) - 1):
        with pytest.raises(InputError, match=f"has {end} bytes, expected"):
            ROWS.decode(data[:end])
    with pytest.raises(InputError, match="expected 248 as its head"):
        ROWS.decode(data + b"1")
    for at, kind, value, why in [
        (0, "<H", 2, "version 2 .* expected 1"),
        (2, "<H", 8, "head of 8 bytes"),
        (4, "<I", 2, "rising places"),
        (24, "<I", 7, "rising places"),
        (28, "<I", 1 << 30, "rising places"),
        (32, "<I", 1 << 31, "expected 42949"),
        (36, "<I", 11, "have \\(11, 32, 8\\) bytes"),
        (40, "<I", 2, "as its head says"),
        (52, "<I", 0xFFFFFFFF, "as its head says"),
        (56, "<I", 9, "rising places"),
        (72, "<i", 1, "rising places"),
    ]:
        wrong = bytearray(data)
        struct.pack_into(kind, wrong, at, value)
        with pytest.raises(InputError, match=why):
            ROWS.decode(bytes(wrong))


def test_layouts_that_cannot_be_are_refused() -> None:
    with pytest.raises(InputError, match="plain numbers"):
        FitLayout(PATCH, np.dtype("<f8"), FORM)
    with pytest.raises(InputError, match="`contacts`"):
        FitLayout(FORM, CONTACT, FORM)
    for wrong in ({}, {"patch": "[["}, ROWS.metadata() | {"form": '[["a", "O"]]'}):
        with pytest.raises(InputError, match="expected the fields of patch"):
            FitLayout.from_metadata(wrong)
    with pytest.raises(InputError, match="those that the recording began with"):
        ROWS.encode(record(forms=np.zeros(3, CONTACT)))
