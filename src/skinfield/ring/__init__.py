"""Ring in shared memory: one process writes, any number read, and none waits for another.

Slots hold the results of cycles, the log holds bytes that must not get lost, and the status holds
counters. `layout` says where everything lies; ``skinfield_ring.h`` beside it reads a ring from C.
"""

from pathlib import Path

from skinfield.ring.layout import Field as Field
from skinfield.ring.layout import State as State
from skinfield.ring.reader import RingReader as RingReader
from skinfield.ring.ring import Ring as Ring


def include_folder() -> Path:
    """Folder of ``skinfield_ring.h``, for a C compiler's ``-I``."""
    return Path(__file__).parent
