"""URDF: any bytes are a robot with poses, or a FileError."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from skinfield.errors import FileError
from skinfield.robot import load_robot

FOLDER = TemporaryDirectory()
PATH = Path(FOLDER.name) / "robot.urdf"
TEXT = b"""<?xml version="1.0"?><robot name="arm"><link name="base"/>
<link name="a"><visual><origin xyz="0 0 1" rpy="0 1 0"/><geometry>
<mesh filename="package://arm/a.stl" scale="1 1 1"/></geometry></visual></link><link name="b"/>
<link name="c"/><joint name="j" type="revolute"><parent link="base"/><child link="a"/>
<origin xyz="0.3 0 0" rpy="1 2 3"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/></joint>
<joint name="k" type="prismatic"><parent link="a"/><child link="b"/><limit lower="0" upper="1"/>
<mimic joint="j" multiplier="2" offset="1"/></joint>
<joint name="l" type="fixed"><parent link="a"/><child link="c"/></joint></robot>
"""
SEEDS = [TEXT, b"\x90\x01\x04<joint ", b'\x80\x01\x02"1e9']


def one_input(data: bytes) -> None:
    """The bytes as a file; then put into a good one, where the first two of them say."""
    as_file(data)
    if len(data) > 2:
        at = int.from_bytes(data[:2], "little") % len(TEXT)
        as_file(TEXT[:at] + data[3:] + TEXT[at + data[2] % 16 :])


def as_file(data: bytes) -> None:
    """Read a file of these bytes."""
    PATH.write_bytes(data)
    try:
        robot = load_robot(PATH)
    except FileError:
        return
    poses = robot.poses(np.ones(len(robot.joint_names)))
    assert set(poses) == {link.name for link in robot.links}
    for link in robot.links:
        assert robot.jacobian(link.name).shape == (6, len(robot.joint_names))
