"""Skin: taxels, patches, grids, and the readings of taxels."""

from skinfield.skin.grid import Grid as Grid
from skinfield.skin.patch import Patch as Patch
from skinfield.skin.patch import Skin as Skin
