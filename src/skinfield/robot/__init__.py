"""Robots: bodies of links and joints from URDF, forward kinematics, and the skin on them."""

from skinfield.robot.body import Joint as Joint
from skinfield.robot.body import Link as Link
from skinfield.robot.body import Mesh as Mesh
from skinfield.robot.body import Mimic as Mimic
from skinfield.robot.body import Robot as Robot
from skinfield.robot.urdf import load_robot as load_robot
