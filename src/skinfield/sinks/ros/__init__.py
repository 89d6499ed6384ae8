"""Messages of ROS 2, made without ROS."""

from skinfield.sinks.ros.bag import BagExport as BagExport
from skinfield.sinks.ros.kinds import Kinds as Kinds
from skinfield.sinks.ros.kinds import RosbagKinds as RosbagKinds
from skinfield.sinks.ros.kinds import interface_package as interface_package
from skinfield.sinks.ros.messages import Outgoing as Outgoing
from skinfield.sinks.ros.messages import SkinMessages as SkinMessages
from skinfield.sinks.ros.names import Topics as Topics
