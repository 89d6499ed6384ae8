"""One patch from readings to contacts, prepared once; `pipeline.conditioned` feeds recordings."""

from skinfield.pipeline.intervals import Intervals as Intervals
from skinfield.pipeline.intervals import load_intervals as load_intervals
from skinfield.pipeline.intervals import save_intervals as save_intervals
from skinfield.pipeline.multigrid import Ladder as Ladder
from skinfield.pipeline.reconstructor import Reconstructor as Reconstructor
