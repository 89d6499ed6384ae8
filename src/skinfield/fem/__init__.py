"""Finite elements: an independent judge that shares nothing with the layer's Green's functions.

Needs scikit-fem: pip install 'skinfield[fem]'.
"""

from skinfield.fem.electrostatics import pad_capacitance as pad_capacitance
from skinfield.fem.gap_3d import pad_capacitance_3d as pad_capacitance_3d
from skinfield.fem.large_strain import LargeStrainPath as LargeStrainPath
from skinfield.fem.large_strain import indent_large as indent_large
from skinfield.fem.press_3d import press_3d as press_3d
from skinfield.fem.profiles import ConeProfile as ConeProfile
from skinfield.fem.profiles import FlatProfile as FlatProfile
from skinfield.fem.profiles import Profile as Profile
from skinfield.fem.profiles import SphereProfile as SphereProfile
from skinfield.fem.small_strain import apply_pressure as apply_pressure
from skinfield.fem.small_strain import indent as indent
from skinfield.fem.solution import AxisymmetricSolution as AxisymmetricSolution
from skinfield.fem.solution_3d import BoxSolution as BoxSolution
