"""Waking on time on an ordinary Linux, and knowing how well that went.

`RealTime` asks the system for what a loop needs and reports what it got. `PeriodicClock` and
`EventWaiter` wait for the next cycle. `TimeHistogram` and `TimingTable` count times where others
can read them while the loop runs.
"""

from skinfield.realtime.clock import PeriodicClock as PeriodicClock
from skinfield.realtime.clock import Waiter as Waiter
from skinfield.realtime.events import EventWaiter as EventWaiter
from skinfield.realtime.granted import Granted as Granted
from skinfield.realtime.histogram import Quantiles as Quantiles
from skinfield.realtime.histogram import TimeHistogram as TimeHistogram
from skinfield.realtime.histogram import quantiles as quantiles
from skinfield.realtime.layout import WORDS as WORDS
from skinfield.realtime.settings import RealTime as RealTime
from skinfield.realtime.timing import Timing as Timing
from skinfield.realtime.timing import TimingTable as TimingTable
