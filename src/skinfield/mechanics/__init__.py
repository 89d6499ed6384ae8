"""Green's functions of the elastomer. Arrays in, arrays out; no state, no sensors."""

from skinfield.mechanics.bonded_layer import BondedLayer as BondedLayer
from skinfield.mechanics.elastomer import Layer as Layer
from skinfield.mechanics.elastomer import Mechanics as Mechanics
from skinfield.mechanics.half_space import HalfSpace as HalfSpace
from skinfield.mechanics.lattice import LatticeConvolution as LatticeConvolution
from skinfield.mechanics.lattice import displacement_kernel as displacement_kernel
from skinfield.mechanics.lattice import indentation_kernel as indentation_kernel
from skinfield.mechanics.viscoelastic import PronySeries as PronySeries
from skinfield.mechanics.viscoelastic import StandardLinearSolid as StandardLinearSolid
from skinfield.mechanics.viscoelastic import Viscoelastic as Viscoelastic
