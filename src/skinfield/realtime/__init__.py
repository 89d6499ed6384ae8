"""Waking on time on an ordinary Linux, and knowing how well that went.

`RealTime` asks the system for what a loop needs and reports what it got. `PeriodicClock` and
`EventWaiter` wait for the next cycle. `TimeHistogram` and `TimingTable` count times where others
can read them while the loop runs.
"""

from skinfield.realtime.clock import EventWaiter as EventWaiter
from skinfield.realtime.clock import PeriodicClock as PeriodicClock
from skinfield.realtime.clock import Waiter as Waiter
from skinfield.realtime.layout import WORDS as WORDS
from skinfield.realtime.setup import RealTime as RealTime
from skinfield.realtime.setup import RealTimeStatus as RealTimeStatus
from skinfield.realtime.timing import Quantiles as Quantiles
from skinfield.realtime.timing import TimeHistogram as TimeHistogram
from skinfield.realtime.timing import Timing as Timing
from skinfield.realtime.timing import TimingTable as TimingTable
from skinfield.realtime.timing import quantiles as quantiles
