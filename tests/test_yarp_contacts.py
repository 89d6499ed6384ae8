"""Contacts in skinDynLib's numbers, frames and bytes; where a skin sits."""

import os
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from yarp_peers import values_of

import skinfield as sf
from skinfield.bridges.yarp.contacts import mean_pressure, wrench_of
from skinfield.errors import InputError
from skinfield.estimate.live_contacts import CONTACT
from skinfield.skin import Grid, Patch
from skinfield.wire.yarp import (
    SkinContact,
    SkinPart,
    bytes_from_bottle,
    part_of,
    parts_of,
    port_of,
    text_from_bottle,
)


def bent(radius: float) -> Patch:
    """A cylinder's skin."""
    angle = np.linspace(-0.6, 0.6, 13)
    along = np.linspace(-0.02, 0.02, 9)
    a, y = (each.ravel() for each in np.meshgrid(angle, along))
    normals = np.column_stack([np.sin(a), np.zeros_like(a), np.cos(a)])
    positions = radius * normals
    positions[:, 1] = y
    return Patch(positions, 3e-3, normals=normals)


def test_force_and_moment_on_a_curved_skin_by_hand() -> None:
    """All normals meet in the axis, so the force goes through it wherever it acts from."""
    radius = 0.05
    grid = Grid.square(bent(radius), 40)
    angle = np.arctan2(grid.positions[:, 0], grid.positions[:, 2])
    lopsided = np.where((angle > -0.1) & (angle < 0.3) & (np.abs(grid.positions[:, 1]) < 0.01),
                        1e4 * (angle + 0.2), 0.0)  # fmt: skip
    rows = np.zeros(1, CONTACT)
    share = lopsided / lopsided.sum()
    centre = share @ grid.positions
    rows["position"], rows["normal_force"], rows["area"] = centre, 2.0, 1e-3
    rows["normal"] = share @ grid.normals / np.linalg.norm(share @ grid.normals)
    force, moment = wrench_of(grid, lopsided, rows, rows[0])
    np.testing.assert_allclose(force, -2.0 * (share @ grid.normals), atol=1e-12)
    # there is no moment about the axis, so about the centre it is that of the force, turned round
    expected = -np.cross(centre - [0.0, centre[1], 0.0], force)
    np.testing.assert_allclose(moment, expected, atol=2e-4)
    assert np.linalg.norm(force) < 2.0


def test_where_a_skin_sits() -> None:
    assert part_of("left_forearm_V2") == part_of("l_forearm") == SkinPart(3, 4, 2)
    assert part_of("torso") == part_of("chest") == SkinPart(1, 2, 7)
    assert part_of("right_foot") == SkinPart(6, -1, 13)
    assert part_of("palm") == SkinPart(0, -1, 0)
    assert port_of("l_upper_arm") == "/icub/skin/left_arm"
    assert port_of("r_foot") == "/icub/skin/right_foot"
    assert port_of("chest", "icubGenova02") == "/icubGenova02/skin/torso"
    assert port_of("palm") == "/icub/skin/palm"
    assert parts_of(["palm", "l_hand"], {"palm": [4, 6, 4]}) == [
        SkinPart(4, 6, 4), SkinPart(3, 6, 1),
    ]  # fmt: skip
    for wrong in ({"arm": [1, 2, 3]}, {"palm": [1, 2]}, {"palm": "abc"}, {"palm": [1.5, 2, 3]}):
        with pytest.raises(InputError, match="expected"):
            parts_of(["palm"], wrong)


def skin_contacts(data: bytes) -> list[list]:
    """Bytes as `skinContactList::read` and `skinContact::read` of icub-main 2.11.1 take them."""
    at = 0

    def take(form: str) -> tuple:
        nonlocal at
        at += struct.calcsize(form)
        return struct.unpack_from(form, data, at - struct.calcsize(form))

    tag, count = take("<2i")
    assert tag == 256
    found = []
    for _ in range(count):
        assert take("<4i") == (256, 8, 257, 4)
        parts: list = [take("<4i")]
        for _ in range(5):
            assert take("<2i") == (276, 3)
            parts.append(take("<3d"))
        tag, taxels = take("<2i")
        assert tag == 257
        parts.append(take(f"<{taxels}i"))
        assert take("<i") == (20,)
        found.append([*parts, take("<d")[0]])
    assert at == len(data)
    return found


def test_skin_dyn_lib_can_read_the_bytes() -> None:
    zeros = np.zeros(3)
    one = SkinContact(
        number=(1 << 31) + 5, part=SkinPart(3, 4, 2), place=np.array([0.1, 0.0, -2e-9]),
        force=np.array([0.0, 0.0, -1.0]), moment=zeros, centre=zeros, normal=zeros,
        taxels=[7, 8, 9], pressure=3,
    )  # fmt: skip
    other = replace(one, number=6, part=SkinPart(), taxels=[0])
    data = bytes_from_bottle([one.values, other.values])
    place, none = (0.1, 0.0, -2e-9), (0, 0, 0)
    assert skin_contacts(data) == [
        [(5, 3, 4, 2), place, (0, 0, -1), none, none, none, (7, 8, 9), 3],
        [(6, 0, -1, 0), place, (0, 0, -1), none, none, none, (0,), 3],
    ]
    assert skin_contacts(bytes_from_bottle([])) == []
    assert values_of(text_from_bottle([one.values]))[0][7] == 3.0  # floating, by its point
    assert text_from_bottle([one.values]).endswith("(7 8 9) 3.0)")
    with pytest.raises(InputError, match="skinDynLib"):
        replace(one, taxels=[])


def test_pressure_is_force_by_area_in_kilopascals() -> None:
    row = np.zeros(1, CONTACT)[0]
    row["normal_force"], row["area"], row["peak_pressure"] = 1.0, 1e-4, 3e4
    assert mean_pressure(row) == pytest.approx(10.0)
    row["area"] = np.nan
    assert mean_pressure(row) == pytest.approx(30.0)


def test_positions_of_the_robot_name_their_parts() -> None:
    folder = Path(os.environ.get("SKINFIELD_SHARED_DATA", "nowhere"))
    files = sorted(folder.glob("icub-main-skin/app/skinGui/conf/positions/*.txt"))
    if not files:
        pytest.skip("no files of a robot here")
    for file in files:
        patch = sf.load_layout(file).patches[0]
        assert part_of(patch.name).skin > 0, file
