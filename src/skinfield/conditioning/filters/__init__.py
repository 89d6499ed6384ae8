"""Filters for light touch: settings that are prepared once and applied to every reading."""

from skinfield.conditioning.filters.kalman import ConstantVelocity as ConstantVelocity
from skinfield.conditioning.filters.kalman import RandomWalk as RandomWalk
from skinfield.conditioning.filters.smoothing import Chain as Chain
from skinfield.conditioning.filters.smoothing import Exponential as Exponential
from skinfield.conditioning.filters.smoothing import Filter as Filter
from skinfield.conditioning.filters.smoothing import FilterState as FilterState
from skinfield.conditioning.filters.smoothing import MovingMedian as MovingMedian
from skinfield.conditioning.filters.smoothing import NoFilter as NoFilter
from skinfield.conditioning.filters.smoothing import filtered as filtered
from skinfield.conditioning.filters.smoothing import rise_time as rise_time
from skinfield.conditioning.filters.smoothing import step_response as step_response
