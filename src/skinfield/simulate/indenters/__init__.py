"""Rigid bodies that press on the skin: a file for each shape."""

from skinfield.simulate.indenters.cylinder import Cylinder as Cylinder
from skinfield.simulate.indenters.protocol import Indenter as Indenter
from skinfield.simulate.indenters.sphere import Sphere as Sphere
