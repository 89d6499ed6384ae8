"""One patch from readings to contacts, prepared once; `pipeline.conditioned` feeds recordings."""

from skinfield.pipeline.interval_files import load_intervals as load_intervals
from skinfield.pipeline.interval_files import save_intervals as save_intervals
from skinfield.pipeline.intervals import Intervals as Intervals
from skinfield.pipeline.ladder import Ladder as Ladder
from skinfield.pipeline.reconstructor import Reconstructor as Reconstructor
