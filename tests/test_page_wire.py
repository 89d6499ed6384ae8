"""Binary messages to the page, and where patches stand in its picture."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal
from page_sources import unpacked

import skinfield as sf
from skinfield.page.scene_layout import PlacedPatch
from skinfield.page.wire import packed, scaled
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


def test_sixteen_bits_keep_a_field() -> None:
    values = np.array([0.0, 1.0, 2.0, np.nan, 9.0, -1.0])
    assert scaled(values, 0.0, 2.0).tolist() == [0, 32768, 65535, 0, 65535, 0]
    assert scaled(values, 1.0, 1.0).tolist() == [0] * 6


@pytest.mark.parametrize("kind", PATCHES)
def test_a_place_of_the_picture_is_one_of_the_plane(kind) -> None:
    patch = PATCHES[kind]()
    pose = np.eye(4)
    pose[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    pose[:3, 3] = 0.1, -0.2, 0.3
    placed = PlacedPatch(None, 0, patch, pose)  # type: ignore[arg-type]
    grid = Grid.square(patch, 23)  # none of its nodes is one of the fine grid's, but the corners
    for node in np.flatnonzero(grid.covered)[::17]:
        shown = placed.in_scene(grid.positions[node][None])[0]
        x, y = placed.plane_of(shown)
        assert_allclose((x, y), grid.plane[node], atol=2e-5)
