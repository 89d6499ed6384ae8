"""What touches the robot: force, deformation and contacts from capacitive skin, in SI units."""

from skinfield.layout import Grid as Grid
from skinfield.layout import Patch as Patch
from skinfield.layout import Skin as Skin
from skinfield.mechanics import Layer as Layer
