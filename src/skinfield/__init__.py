"""What touches the robot: force, deformation and contacts from capacitive skin, in SI units."""

from skinfield import simulate as simulate
from skinfield.contacts import ContactFinder as ContactFinder
from skinfield.fields import Contact as Contact
from skinfield.fields import Estimate as Estimate
from skinfield.inverse import GaussianField as GaussianField
from skinfield.inverse import Inverse as Inverse
from skinfield.inverse import PseudoInverse as PseudoInverse
from skinfield.inverse import Tikhonov as Tikhonov
from skinfield.layout import Grid as Grid
from skinfield.layout import Patch as Patch
from skinfield.layout import Skin as Skin
from skinfield.layout import generators
from skinfield.layout import load_layout as load_layout
from skinfield.layout import save_layout as save_layout
from skinfield.mechanics import BondedLayer as BondedLayer
from skinfield.mechanics import HalfSpace as HalfSpace
from skinfield.mechanics import Layer as Layer
from skinfield.observation import BaseStress as BaseStress
from skinfield.observation import Capacitance as Capacitance
from skinfield.observation import Gap as Gap
from skinfield.pipeline import Reconstructor as Reconstructor

layouts = generators  # patches from numbers: layouts.hexagon72()
