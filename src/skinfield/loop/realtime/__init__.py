"""Real time: priorities, pinned processors, locked memory, clocks of a loop, and its times."""

from skinfield.loop.realtime.clock import EventWaiter as EventWaiter
from skinfield.loop.realtime.clock import PeriodicClock as PeriodicClock
from skinfield.loop.realtime.setup import RealTime as RealTime
from skinfield.loop.realtime.setup import RealTimeStatus as RealTimeStatus
from skinfield.loop.realtime.timing import Quantiles as Quantiles
from skinfield.loop.realtime.timing import Timing as Timing
from skinfield.loop.realtime.timing import TimingTable as TimingTable
from skinfield.loop.realtime.timing import quantiles as quantiles
from skinfield.loop.realtime.timing_kernel import WORDS as WORDS
