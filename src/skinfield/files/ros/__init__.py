"""Messages of ROS 2, made without ROS."""

from skinfield.files.ros.bag import BagExport as BagExport
from skinfield.files.ros.kinds import RosbagKinds as RosbagKinds
from skinfield.files.ros.kinds import interface_package as interface_package
from skinfield.files.ros.names import Topics as Topics
