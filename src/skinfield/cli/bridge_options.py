"""Options that take a live skin out to the robot: zenoh, ROS 2, YARP."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

F = TypeVar("F", bound=Callable[..., Any])


def zenoh_options(function: F) -> F:
    """How to meet others over zenoh."""
    for option in (
        click.option(
            "--zenoh-config", type=click.Path(path_type=Path), metavar="FILE",
            help="Settings of zenoh (JSON5): certificates, access control, see docs/zenoh.md.",
        ),
        click.option(
            "--zenoh-connect", multiple=True, metavar="ADDRESS",
            help="Others to connect to, such as tcp/robot:7447; again for more.",
        ),
        click.option(
            "--zenoh-listen", multiple=True, metavar="ADDRESS",
            help="Where others may connect, such as tcp/0.0.0.0:7447; again for more. Without "
            "any address, only programs on this machine take part.",
        ),
    ):  # fmt: skip
        function = option(function)
    return function


def bridge_options(function: F) -> F:
    """Where estimates go besides: to zenoh, ROS 2, YARP."""
    for option in (
        click.option(
            "--yarp", "yarp", is_flag=False, flag_value="", metavar="[NAME SERVER]",
            help="Publish skin_events as YARP does; address of its name server if not "
            "localhost:10000.",
        ),
        click.option(
            "--ros-domain", type=click.IntRange(0, 232), metavar="N",
            help="With --ros2. [default: $ROS_DOMAIN_ID, or 0]",
        ),
        click.option(
            "--ros-rate", multiple=True, metavar="WHAT=HZ",
            help="With --ros2: most messages a second of contacts, frames, wrench, "
            "contact_wrench, taxels or diagnostics; 0: none. Again for more.",
        ),
        click.option("--ros2", is_flag=True, help="Publish as rmw_zenoh does, see docs/ros2.md."),
        click.option(
            "--robot", default="robot", show_default=True, metavar="NAME",
            help="Of the whole robot, in keys and topics.",
        ),
    ):  # fmt: skip
        function = option(function)
    function = zenoh_options(function)
    return click.option(
        "--zenoh", is_flag=True, help="Publish estimates and contacts, see docs/zenoh.md."
    )(function)
