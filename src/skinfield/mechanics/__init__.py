"""Green's functions of the elastomer. Arrays in, arrays out; no state, no sensors."""

from skinfield.mechanics.bonded_layer import BondedLayer as BondedLayer
from skinfield.mechanics.elastomer import Layer as Layer
from skinfield.mechanics.half_space import HalfSpace as HalfSpace
from skinfield.mechanics.protocol import Mechanics as Mechanics
