"""Node of ROS 2 that publishes a running skin: `python -m skinfield.bridges.ros2.node [SKIN]`.

For those who run ROS with any middleware; skinfield is installed in its Python. `skinfield_msgs` is
built by colcon; while it is not, all but the contacts' array is published.
"""

import sys
from array import array
from contextlib import suppress
from importlib import import_module
from typing import Any

from skinfield.bridges.ros2.messages import Channel, Speaker, Talker
from skinfield.bridges.ros2.publisher import RosSettings
from skinfield.errors import InputError
from skinfield.files.ros.messages import Outgoing
from skinfield.files.ros.names import Topics, token_of
from skinfield.loop.client import Live, connect


class RclpyKinds:
    """Messages as rclpy has them; see `skinfield.files.ros.Kinds`."""

    def of(self, kind: str) -> Any:
        """Class of a kind such as `std_msgs/msg/Header`."""
        package, _, name = kind.split("/")
        return getattr(import_module(f"{package}.msg"), name)

    def make(self, kind: str, **fields: Any) -> Any:
        """A message with all of its fields."""
        return self.of(kind)(**fields)

    def octets(self, data: bytes) -> Any:
        """Value of a field `uint8[]`."""
        return array("B", data)

    def octet(self, value: int) -> Any:
        """Value of a field `byte`."""
        return bytes([value])


class SkinNode:
    """Publishes what a skin says by a timer of a node.

    Parameters
    ----------
    node : rclpy.node.Node
    live : Live
    settings : RosSettings
        Of it the robot and the rates count.
    """

    def __init__(self, node: Any, live: Live, settings: RosSettings) -> None:
        self._node, self._kinds = node, RclpyKinds()
        speaker = Speaker(live.skin, self._kinds, Topics.of(live.skin, settings.prefix))
        wanted = [each for each in speaker.channels() if settings.rates[each.what] > 0]
        self._outlets = {each.topic: self._outlet(each) for each in wanted}
        rates = {each.what: settings.rates[each.what] for each in wanted if self._has(each)}
        if not rates:
            raise InputError("messages of ROS cannot be imported, expected a sourced ROS 2")
        self.talker = Talker(live, speaker, rates, self._send)
        node.create_timer(1.0 / max(rates.values()), self.talker.step)

    def _outlet(self, channel: Channel) -> Any:
        try:
            message = self._kinds.of(channel.kind)
        except ImportError as error:
            self._node.get_logger().warning(f"{channel.topic} is not published: {error}")
            return None
        return self._node.create_publisher(message, channel.topic, channel.depth)

    def _has(self, channel: Channel) -> bool:
        return self._outlets[channel.topic] is not None

    def _send(self, out: Outgoing) -> None:
        self._outlets[out.topic].publish(out.message)


def main(arguments: list[str] | None = None) -> None:
    """Run a node until ROS shuts down."""
    import rclpy
    from rclpy.executors import ExternalShutdownException
    from rclpy.utilities import remove_ros_args

    rclpy.init(args=arguments)
    given = remove_ros_args(sys.argv if arguments is None else arguments)[1:]
    with connect(given[0] if given else None, timeout=10.0) as live:
        node = rclpy.create_node(token_of(f"skinfield_{live.name}"))
        robot = node.declare_parameter("robot", RosSettings().robot).value
        SkinNode(node, live, RosSettings(robot=robot))
        with suppress(KeyboardInterrupt, ExternalShutdownException):
            rclpy.spin(node)
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
