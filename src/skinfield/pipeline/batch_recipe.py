"""What a reconstructor is made of, so that another process, or another day, makes it again."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from skinfield.contacts import ContactFinder
from skinfield.errors import FileError
from skinfield.inverse import Solver
from skinfield.layout import Grid, Patch
from skinfield.mechanics import Layer, Mechanics
from skinfield.observation import Quantity
from skinfield.pipeline.batch_text import plain_from_value, value_from_plain
from skinfield.pipeline.intervals import Intervals
from skinfield.pipeline.reconstructor import Reconstructor

PARTS = (
    *("patch", "layer", "mechanics", "quantity", "solver", "noise_std", "finder"),
    "intervals",
)  # all but the grid, which lies on the patch


@dataclass(frozen=True, eq=False)
class Recipe:
    """Arguments of a `Reconstructor`. They can be pickled, and mostly be written as text."""

    patch: Patch
    layer: Layer
    grid: Grid
    mechanics: Mechanics
    quantity: Quantity
    solver: Solver
    noise_std: ArrayLike
    finder: ContactFinder
    intervals: Intervals | None = None

    @classmethod
    def of(cls, reconstructor: Reconstructor) -> "Recipe":
        """Of a reconstructor that is there."""
        return cls(
            reconstructor.patch,
            reconstructor.layer,
            reconstructor.grid,
            reconstructor.mechanics,
            reconstructor.quantity,
            reconstructor.solver,
            reconstructor.model.noise_std,
            reconstructor.finder,
            reconstructor.intervals,
        )

    def reconstructor(self) -> Reconstructor:
        """Make it: everything that needs no reading is computed now."""
        return Reconstructor(
            self.patch,
            self.layer,
            self.grid,
            mechanics=self.mechanics,
            quantity=self.quantity,
            solver=self.solver,
            noise_std=self.noise_std,
            finder=self.finder,
            intervals=self.intervals,
        )

    def to_plain(self) -> dict[str, Any]:
        """In what JSON knows; raises InputError where a part is not skinfield's own."""
        plain = {name: plain_from_value(name, getattr(self, name)) for name in PARTS}
        grid = (self.grid.shape, self.grid.pitch, self.grid.origin)
        return plain | {"grid": plain_from_value("grid", grid)}

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Recipe":
        """Undo `to_plain`; raises FileError for what it never writes."""
        missing = {*PARTS, "grid"} - set(plain)
        if missing:
            raise FileError(f"settings lack {', '.join(sorted(missing))}: is the file whole?")
        parts = {name: value_from_plain(name, plain[name]) for name in PARTS}
        if not isinstance(parts["patch"], Patch):
            raise FileError(f"patch is a {type(parts['patch']).__name__}, expected a Patch")
        grid = value_from_plain("grid", plain["grid"])
        try:
            shape, pitch, origin = grid
            made = Grid(parts["patch"], shape, pitch, np.asarray(origin))
        except Exception as error:
            raise FileError(f"grid is {str(grid)[:80]}, expected shape, pitch, origin") from error
        return cls(grid=made, **parts)
