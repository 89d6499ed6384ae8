"""Patches from numbers: the paper's hexagon, triangular modules, arrays, cylinders, spheres."""

from skinfield.layout.generators.names import by_name as by_name
from skinfield.layout.generators.names import known as known
from skinfield.layout.generators.sheets import cylinder as cylinder
from skinfield.layout.generators.sheets import rectangular as rectangular
from skinfield.layout.generators.sheets import sphere_cap as sphere_cap
from skinfield.layout.generators.templates import ICUB_TRIANGLE as ICUB_TRIANGLE
from skinfield.layout.generators.templates import PAPER_TRIANGLE as PAPER_TRIANGLE
from skinfield.layout.generators.templates import TEN_PAD_TRIANGLE as TEN_PAD_TRIANGLE
from skinfield.layout.generators.templates import ModuleTemplate as ModuleTemplate
from skinfield.layout.generators.triangles import hexagon72 as hexagon72
from skinfield.layout.generators.triangles import icub_hexagon as icub_hexagon
from skinfield.layout.generators.triangles import icub_triangle as icub_triangle
from skinfield.layout.generators.triangles import ten_pad_triangle as ten_pad_triangle
from skinfield.layout.generators.triangles import triangle_lattice as triangle_lattice
from skinfield.layout.generators.triangles import triangle_modules as triangle_modules
