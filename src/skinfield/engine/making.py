"""What an engine prepares before its first cycle."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from skinfield.engine.clockwork import Clockwork
from skinfield.engine.group import Group
from skinfield.engine.intake import Intake
from skinfield.engine.interning import kinds_of
from skinfield.layout import Skin
from skinfield.mechanics import Layer, Mechanics
from skinfield.observation import Quantity, check_skin
from skinfield.pipeline.ladder_rungs import prepare_rungs

if TYPE_CHECKING:
    from skinfield.inverse import Solver


def groups_of(
    skin: Skin,
    layer: Layer | Mapping[str, Layer] | None,
    noise_std: ArrayLike | Mapping[str, ArrayLike] | None,
    rungs: Sequence[int],
    mechanics: Mechanics,
    quantity: Quantity,
    solver: "Solver",
) -> list[Group]:
    """Prepare each kind of patch once; see `Engine`."""
    typical = quantity.typical_noise
    noise = typical if noise_std is None else noise_std
    groups, first = [], 0
    for index, kind in enumerate(kinds_of(skin, layer, noise, typical)):
        patch = kind.patches[0]
        check_skin(patch, kind.layer, mechanics, quantity)
        prepared = prepare_rungs(
            patch, kind.layer, tuple(rungs), mechanics, quantity, solver, kind.noise_std
        )
        groups.append(Group(index, first, kind, prepared))
        first += len(kind.patches)
    return groups


def clockwork_of(
    groups: Sequence[Group], skin: Skin, quantity: Quantity, clock: Callable[[], int]
) -> Clockwork:
    """Arrays of all patches, those of one kind side by side."""
    patches = [patch for group in groups for patch in group.kind.patches]
    names = [patch.name for patch in skin]
    noise = [np.tile(group.kind.noise_std, group.count) for group in groups]
    order = [names.index(patch.name) for patch in patches]
    return Clockwork(groups, Intake(patches, order, quantity, np.concatenate(noise)), clock)
