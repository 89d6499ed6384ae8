"""A ring in shared memory: one process writes, any number read, and none waits for another.

Slots hold the results of cycles, the log holds bytes that must not get lost, and the status holds
counters. `header` says where everything lies; ``skinfield_ring.h`` beside it reads a ring from C.
"""

from skinfield.ring.fields import Field as Field
from skinfield.ring.header import State as State
from skinfield.ring.include import include_folder as include_folder
from skinfield.ring.log import LogReader as LogReader
from skinfield.ring.present import Present as Present
from skinfield.ring.reader import RingReader as RingReader
from skinfield.ring.ring import Ring as Ring
from skinfield.ring.slot import Slot as Slot
