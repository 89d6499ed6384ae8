"""Reconstruction: one reading or many, of a patch or of a whole skin, with a deadline."""

from skinfield.reconstruct.reconstructor import Reconstructor as Reconstructor
from skinfield.solve import Solver as Solver
