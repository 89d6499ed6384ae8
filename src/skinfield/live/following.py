"""What the estimates of a ring follow from, which a new baseline or solver changes."""

import time
from dataclasses import replace

import numpy as np

from skinfield.live.configuration import configuration_of, same
from skinfield.live.estimates import Models
from skinfield.live.recipe import Recipe
from skinfield.live.slots import Head, Slot
from skinfield.ring import RingReader, State

LEAVE = 5.0  # s that the next process of an engine may take to go on with its ring


class Following:
    """Recipe and models of the cycles of a ring.

    Parameters
    ----------
    reader : RingReader
        Of a live skin.

    Raises
    ------
    FileError
        If it does not say what it is of.

    Attributes
    ----------
    recipe : Recipe
        Of the newest cycle that was asked for.
    """

    def __init__(self, reader: RingReader) -> None:
        self._reader = reader
        self.recipe = recipe_of(reader)
        self._generation = reader.generation
        self._models: tuple[int, Models] | None = None

    def look(self, generation: int) -> None:
        """Look what the solver is now, if another process of the engine made a cycle."""
        if generation == self._generation:
            return
        told = configuration_of(self._reader)
        if told is None or told.generation != generation:
            return  # a cycle from before: what is known already was in force
        self._generation = generation
        if not same(told.solver, self.recipe.solver):
            self.recipe, self._models = replace(self.recipe, solver=told.solver), None

    def models_of(self, slot: Slot) -> Models:
        """What turns the pressures of a cycle into deformation and uncertainty."""
        self.look(int(slot.head[Head.GENERATION]))
        return self.models

    @property
    def models(self) -> Models:
        """The same, for the calibration in force."""
        status = self._reader.status_view
        tares = int(status["tares"][0])
        if self._models is None or self._models[0] != tares:
            noise = status["noise_std"].copy()
            typical = self.recipe.quantity.typical_noise
            self._models = tares, Models(self.recipe, np.where(noise > 0, noise, typical))
        return self._models[1]


def recipe_of(reader: RingReader) -> Recipe:
    """What the answers of a live skin's ring follow from now.

    Raises
    ------
    FileError
        If it does not say.
    """
    recipe = Recipe.from_json(str(reader.description.get("recipe")))
    told = configuration_of(reader)
    return recipe if told is None else replace(recipe, solver=told.solver)


def state_of(reader: RingReader) -> State:
    """What the engine is doing; FAILED if its process is gone, unless another is to go on."""
    state = reader.state
    if reader.alive or state == State.STOPPED:
        return state
    silence = (time.monotonic_ns() - reader.heartbeat_ns) * 1e-9
    return State.STARTING if state == State.STARTING and silence < LEAVE else State.FAILED
