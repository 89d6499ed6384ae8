"""Fits of the shapes that the patches of a skin have, prepared in the background."""

import threading
from collections import deque
from typing import TYPE_CHECKING

from skinfield.errors import SkinfieldError
from skinfield.live.patch_fit import Shape, prepared, shape_of
from skinfield.live.recipe import Recipe

if TYPE_CHECKING:
    from skinfield.inverse.atoms.fitter import ContactFitter

EAGER = 6  # shapes that are prepared before anything touches them; others when something does


class FitShapes:
    """One prepared fit for each shape that patches of a skin have.

    Preparing takes seconds for the first one and less for the others, which share its tables, and
    the first time on a machine ten more, as all is compiled then. It happens in a thread of its
    own, of what is touched first.

    Parameters
    ----------
    recipe : Recipe

    Attributes
    ----------
    failed : str
        Why the last shape that could not be prepared could not; empty if all could.
    """

    def __init__(self, recipe: Recipe) -> None:
        self._recipe = recipe
        self._shape_of = [shape_of(patch) for patch in recipe.skin]
        self._place_of = {shape: n for n, shape in reversed(list(enumerate(self._shape_of)))}
        self._there: dict[Shape, ContactFitter | None] = {}
        first = list(dict.fromkeys(self._shape_of))[:EAGER]
        self._waiting: deque[Shape] = deque(first)
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self.failed = ""
        self._go_on()

    @property
    def busy(self) -> bool:
        """Whether something is being prepared."""
        return self._thread is not None and self._thread.is_alive()

    def get(self, place: int, touched: bool) -> "ContactFitter | None":
        """The fit for a patch by its number; None while there is none, or if there can be none.

        Parameters
        ----------
        place : int
        touched : bool
            Whether it is wanted now.
        """
        shape = self._shape_of[place]
        if shape in self._there or not touched:
            return self._there.get(shape)
        with self._lock:
            if not self._waiting or self._waiting[0] != shape:
                self._waiting.appendleft(shape)  # perhaps a second time: then it is there by then
        self._go_on()
        return None

    def _go_on(self) -> None:
        if self._waiting and not self.busy:
            self._thread = threading.Thread(target=self._work, name="preparing", daemon=True)
            self._thread.start()

    def _work(self) -> None:
        while True:
            with self._lock:
                if not self._waiting:
                    return
                shape = self._waiting.popleft()
            if shape in self._there:
                continue
            patch = self._recipe.skin[self._place_of[shape]]
            try:
                self._there[shape] = prepared(patch, self._recipe)
            except SkinfieldError as error:
                self._there[shape] = None
                self.failed = f"{patch.name}: {error}"
