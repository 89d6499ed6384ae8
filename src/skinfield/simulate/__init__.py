"""From contact to readings: measurement read backwards, with its own grid and contact solver."""

from skinfield.simulate.indenters import Cylinder as Cylinder
from skinfield.simulate.indenters import Indenter as Indenter
from skinfield.simulate.indenters import Sphere as Sphere
from skinfield.simulate.press import Press as Press
from skinfield.simulate.press import press as press
