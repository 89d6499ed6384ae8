"""`python -m skinfield.bridges.yarp RING`: see `skinfield.bridges.child`."""

import sys

from skinfield.bridges.child import run_child
from skinfield.bridges.yarp.publisher import YarpSettings, serve

if __name__ == "__main__":
    sys.exit(run_child(YarpSettings, serve))
