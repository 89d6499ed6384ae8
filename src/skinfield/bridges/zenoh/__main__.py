"""`python -m skinfield.bridges.zenoh RING`: see `skinfield.bridges.child`."""

import sys

from skinfield.bridges.child import run_child
from skinfield.bridges.settings import BridgeSettings
from skinfield.bridges.zenoh.publisher import serve

if __name__ == "__main__":
    sys.exit(run_child(BridgeSettings, serve))
