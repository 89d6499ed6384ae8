"""`python -m skinfield.bridges.ros2 RING`: see `skinfield.bridges.child`."""

import sys

from skinfield.bridges.child import run_child
from skinfield.bridges.ros2.publisher import RosSettings, serve

if __name__ == "__main__":
    sys.exit(run_child(RosSettings, serve))
