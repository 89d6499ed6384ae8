"""Finite elements: an independent judge that shares nothing with the layer's Green's functions.

Needs scikit-fem: pip install 'skinfield[lab]'.
"""

from skinfield.lab.fem.electrostatics import pad_capacitance as pad_capacitance
from skinfield.lab.fem.large_strain import LargeStrainPath as LargeStrainPath
from skinfield.lab.fem.large_strain import indent_large as indent_large
from skinfield.lab.fem.profiles import ConeProfile as ConeProfile
from skinfield.lab.fem.profiles import FlatProfile as FlatProfile
from skinfield.lab.fem.profiles import Profile as Profile
from skinfield.lab.fem.profiles import SphereProfile as SphereProfile
from skinfield.lab.fem.small_strain import AxisymmetricSolution as AxisymmetricSolution
from skinfield.lab.fem.small_strain import apply_pressure as apply_pressure
from skinfield.lab.fem.small_strain import indent as indent
