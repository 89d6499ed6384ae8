"""What taxels anywhere read of a press at the origin; of a round one, by distance alone."""

from skinfield.simulate.pressing.anywhere import is_round as is_round
from skinfield.simulate.pressing.anywhere import readings_anywhere as readings_anywhere
