"""Rigid bodies that press on the skin: a file for each shape."""

from skinfield.simulate.indenters.bar import Bar as Bar
from skinfield.simulate.indenters.cone import Cone as Cone
from skinfield.simulate.indenters.cylinder import Cylinder as Cylinder
from skinfield.simulate.indenters.height_map import HeightMap as HeightMap
from skinfield.simulate.indenters.mesh import Mesh as Mesh
from skinfield.simulate.indenters.protocol import Indenter as Indenter
from skinfield.simulate.indenters.ring import Ring as Ring
from skinfield.simulate.indenters.rod import Rod as Rod
from skinfield.simulate.indenters.sphere import Sphere as Sphere
from skinfield.simulate.indenters.wedge import Wedge as Wedge
