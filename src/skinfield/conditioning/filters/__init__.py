"""Filters for light touch: settings that are prepared once and applied to every reading."""

from skinfield.conditioning.filters.chain import Chain as Chain
from skinfield.conditioning.filters.chain import NoFilter as NoFilter
from skinfield.conditioning.filters.constant_velocity import ConstantVelocity as ConstantVelocity
from skinfield.conditioning.filters.exponential import Exponential as Exponential
from skinfield.conditioning.filters.median import MovingMedian as MovingMedian
from skinfield.conditioning.filters.protocol import Filter as Filter
from skinfield.conditioning.filters.protocol import FilterState as FilterState
from skinfield.conditioning.filters.random_walk import RandomWalk as RandomWalk
from skinfield.conditioning.filters.response import filtered as filtered
from skinfield.conditioning.filters.response import rise_time as rise_time
from skinfield.conditioning.filters.response import step_response as step_response
