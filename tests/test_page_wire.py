"""Binary messages to the page, and where patches stand in its picture."""

import json
import struct
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal
from page_sources import StillSource

import skinfield as sf
from skinfield.page.scene_layout import SceneLayout
from skinfield.page.wire import packed, scaled, unpacked
from skinfield.skin import Grid

PATCHES = {
    "flat": sf.layouts.hexagon72,
    "cylinder": lambda: sf.layouts.cylinder(radius=30e-3),
    "cap": lambda: sf.layouts.sphere_cap(radius=40e-3),
}


@given(
    st.lists(
        st.sampled_from(["<u1", "<u2", "<u4", "<f4"]).flatmap(
            lambda kind: arrays(kind, st.integers(0, 9))
        ),
        max_size=5,
    ),
    st.text(max_size=9),
)
def test_a_message_is_what_its_bytes_say(given_arrays, name) -> None:
    message = packed({"kind": name}, [(name, each) for each in given_arrays])
    head, found = unpacked(message)
    assert head["kind"] == name
    for before, after in zip(given_arrays, found, strict=True):
        assert_array_equal(before, after)
    magic, size = struct.unpack_from("<4sI", message)  # as another program reads it
    assert magic == b"SKF1"
    assert (8 + size) % 8 == 0
    for each, array in zip(json.loads(message[8 : 8 + size])["arrays"], given_arrays, strict=True):
        assert each["at"] % 4 == 0
        start = 8 + size + each["at"]
        assert message[start : start + array.nbytes] == array.tobytes()


HEADS = st.dictionaries(
    st.sampled_from(["arrays", "kind"]),
    st.recursive(
        st.none() | st.integers() | st.sampled_from(["u8", "f32"]),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(st.sampled_from(["name", "type", "at", "length"]), inner)
        ),
    ),
)


def message_of(head) -> bytes:
    text = json.dumps(head).encode()
    return struct.pack("<4sI", b"SKF1", len(text)) + text + bytes(16)


@given(st.binary(max_size=60) | HEADS.map(message_of))
def test_any_bytes_are_read_or_refused(data) -> None:
    with suppress(ValueError, RecursionError):
        head, found = unpacked(data)
        assert len(found) == len(head["arrays"])


def test_sixteen_bits_keep_a_field() -> None:
    values = np.array([0.0, 1.0, 2.0, np.nan, 9.0, -1.0])
    assert scaled(values, 0.0, 2.0).tolist() == [0, 32768, 65535, 0, 65535, 0]
    assert scaled(values, 1.0, 1.0).tolist() == [0] * 6


@pytest.mark.parametrize("kind", PATCHES)
def test_a_place_of_the_picture_is_one_of_the_plane(kind) -> None:
    patch = PATCHES[kind]()
    source = StillSource.__new__(StillSource)
    layout = SceneLayout(())
    layout.sources = (source,)
    from skinfield.page.scene_layout import PlacedPatch

    pose = np.eye(4)
    pose[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    pose[:3, 3] = 0.1, -0.2, 0.3
    placed = PlacedPatch(source, 0, patch, pose)
    grid = Grid.square(patch, 23)  # none of its nodes is one of the fine grid's, but the corners
    for node in np.flatnonzero(grid.covered)[::17]:
        shown = placed.in_scene(grid.positions[node][None])[0]
        x, y = placed.plane_of(shown)
        assert_allclose((x, y), grid.plane[node], atol=2e-5)
