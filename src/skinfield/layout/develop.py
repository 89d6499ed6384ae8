"""Curved patches laid flat."""

from skinfield.errors import Floats
from skinfield.layout.surface import Surface


def develop(positions: Floats, normals: Floats) -> Surface:
    """Develop the surface through taxels (L, 3) m with outward normals (L, 3)."""
    raise NotImplementedError
