"""Filters for light touch: settings that are prepared once and applied to every reading."""

from skinfield.signal.filters.kalman import RandomWalk as RandomWalk
from skinfield.signal.filters.smoothing import Chain as Chain
from skinfield.signal.filters.smoothing import Exponential as Exponential
from skinfield.signal.filters.smoothing import Filter as Filter
from skinfield.signal.filters.smoothing import FilterState as FilterState
from skinfield.signal.filters.smoothing import MovingMedian as MovingMedian
from skinfield.signal.filters.smoothing import NoFilter as NoFilter
from skinfield.signal.filters.smoothing import filtered as filtered
from skinfield.signal.filters.smoothing import rise_time as rise_time
from skinfield.signal.filters.smoothing import step_response as step_response
