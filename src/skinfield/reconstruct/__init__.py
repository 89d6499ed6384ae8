"""Reconstruction: one reading or many, of a patch or of a whole skin, with a deadline."""

from skinfield.reconstruct.intervals import Intervals as Intervals
from skinfield.reconstruct.multigrid import Ladder as Ladder
from skinfield.reconstruct.reconstructor import Reconstructor as Reconstructor
from skinfield.reconstruct.serialisation import load_intervals as load_intervals
from skinfield.reconstruct.serialisation import save_intervals as save_intervals
from skinfield.solve import Solver as Solver
