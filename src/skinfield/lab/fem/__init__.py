"""Finite elements: an independent judge that shares nothing with the layer's Green's functions.

Needs scikit-fem: pip install 'skinfield[lab]'.
"""

from skinfield.lab.fem.electrostatics import pad_capacitance as pad_capacitance
from skinfield.lab.fem.small_strain import Profile as Profile
from skinfield.lab.fem.small_strain import indent as indent
