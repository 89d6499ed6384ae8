"""Elasticity: Green's functions, contact mechanics, and what a taxel reads of a traction."""

from skinfield.elastic.bonded_layer import BondedLayer as BondedLayer
from skinfield.elastic.curved_layer import CurvedLayer as CurvedLayer
from skinfield.elastic.curved_layer import CylindricalBase as CylindricalBase
from skinfield.elastic.curved_layer import SphericalBase as SphericalBase
from skinfield.elastic.elastomer import Layer as Layer
from skinfield.elastic.elastomer import Mechanics as Mechanics
from skinfield.elastic.half_space import HalfSpace as HalfSpace
from skinfield.elastic.lattice import LatticeConvolution as LatticeConvolution
from skinfield.elastic.lattice import displacement_kernel as displacement_kernel
from skinfield.elastic.observation import BaseStress as BaseStress
from skinfield.elastic.observation import Capacitance as Capacitance
from skinfield.elastic.observation import Deformation as Deformation
from skinfield.elastic.observation import Gap as Gap
from skinfield.elastic.observation import ObservationModel as ObservationModel
from skinfield.elastic.observation import Physics as Physics
from skinfield.elastic.observation import Quantity as Quantity
from skinfield.elastic.observation import check_skin as check_skin
from skinfield.elastic.observation import on_surface as on_surface
from skinfield.elastic.viscoelastic import StandardLinearSolid as StandardLinearSolid
