"""Simulator of presses: from contact to readings, with its own grid and contact solver."""

from skinfield.simulate import electronics as electronics
from skinfield.simulate.indenters.body import Indenter as Indenter
from skinfield.simulate.indenters.finger import Finger as Finger
from skinfield.simulate.indenters.shapes import Bar as Bar
from skinfield.simulate.indenters.shapes import Cone as Cone
from skinfield.simulate.indenters.shapes import Cylinder as Cylinder
from skinfield.simulate.indenters.shapes import Ring as Ring
from skinfield.simulate.indenters.shapes import Rod as Rod
from skinfield.simulate.indenters.shapes import Sphere as Sphere
from skinfield.simulate.indenters.shapes import Wedge as Wedge
from skinfield.simulate.indenters.surfaces import HeightMap as HeightMap
from skinfield.simulate.indenters.surfaces import Mesh as Mesh
from skinfield.simulate.pressing.press import Press as Press
from skinfield.simulate.pressing.press import ladder_steps as ladder_steps
from skinfield.simulate.pressing.press import press as press
from skinfield.simulate.pressing.press import press_ladder as press_ladder
from skinfield.simulate.pressing.press import press_path as press_path
