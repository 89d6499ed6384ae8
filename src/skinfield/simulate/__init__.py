"""From contact to readings: measurement read backwards, with its own grid and contact solver."""

from skinfield.simulate import electronics as electronics
from skinfield.simulate.indenters import Bar as Bar
from skinfield.simulate.indenters import Cone as Cone
from skinfield.simulate.indenters import Cylinder as Cylinder
from skinfield.simulate.indenters import HeightMap as HeightMap
from skinfield.simulate.indenters import Indenter as Indenter
from skinfield.simulate.indenters import Mesh as Mesh
from skinfield.simulate.indenters import Ring as Ring
from skinfield.simulate.indenters import Rod as Rod
from skinfield.simulate.indenters import Sphere as Sphere
from skinfield.simulate.indenters import Wedge as Wedge
from skinfield.simulate.pressing.press import Press as Press
from skinfield.simulate.pressing.press import press as press
from skinfield.simulate.pressing.press import press_ladder as press_ladder
