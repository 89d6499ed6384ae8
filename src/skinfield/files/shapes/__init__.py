"""Files that hold the shape of an indenter: triangle meshes, pictures and tables of heights."""

from skinfield.files.shapes.height_maps import load_height_map as load_height_map
from skinfield.files.shapes.meshes import load_mesh as load_mesh
