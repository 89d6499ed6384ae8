"""Where the taxels are: patches, skins, grids, generators, and the files they come in."""

from skinfield.layout.files import load_layout as load_layout
from skinfield.layout.files import save_layout as save_layout
from skinfield.layout.grid import Grid as Grid
from skinfield.layout.patch import Patch as Patch
from skinfield.layout.patch import Skin as Skin
