"""Patches that are the same to a solver share what is prepared for one of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_shape
from skinfield.layout import Patch, Skin
from skinfield.mechanics import Layer

SAME = 1e-6  # of the pads' pitch: places that are one


@dataclass(frozen=True, eq=False)
class Kind:
    """Patches of equal geometry, layer and noise.

    Attributes
    ----------
    patches : tuple of Patch
        The first stands for all.
    layer : Layer
    noise_std : (L,) array, unit of the reading
    """

    patches: tuple[Patch, ...]
    layer: Layer
    noise_std: Floats


def kinds_of(
    skin: Skin,
    layer: Layer | Mapping[str, Layer] | None,
    noise_std: ArrayLike | Mapping[str, ArrayLike],
    typical: float,
) -> tuple[Kind, ...]:
    """Sort the patches of a skin by kind.

    Two are of one kind if their taxels stand at equal places of their planes, up to a shift, in
    the same order, below the same layer, with pads and noise alike.

    Parameters
    ----------
    skin : Skin
    layer : Layer, or mapping from every patch's name to one
    noise_std : float or (L,) array, or mapping from names of patches to such
        Patches that a mapping leaves out have `typical`.
    typical : float
    """
    found: list[Kind] = []
    for patch in skin:
        its = _layer_of(patch, layer)
        noise = _noise_of(patch, noise_std, typical)
        for place, kind in enumerate(found):
            if _alike(kind, patch, its, noise):
                found[place] = Kind((*kind.patches, patch), its, noise)
                break
        else:
            found.append(Kind((patch,), its, noise))
    return tuple(found)


def check_names(name: str, given: Mapping[str, object], skin: Skin) -> None:
    """Raise InputError for names that no patch has."""
    known = [patch.name for patch in skin]
    unknown = [each for each in given if each not in known]
    if unknown:
        raise InputError(
            f"{name} names {unknown[0]!r}, expected names of patches: {', '.join(known[:8])}"
            f"{', ...' if len(known) > 8 else ''}"
        )


def _layer_of(patch: Patch, layer: Layer | Mapping[str, Layer] | None) -> Layer:
    if isinstance(layer, Mapping):
        if patch.name not in layer:
            raise InputError(
                f"layer has no entry for patch {patch.name!r}, expected one for every patch: "
                "what lies over it is not known otherwise"
            )
        return layer[patch.name]
    return Layer() if layer is None else layer


def _noise_of(
    patch: Patch, noise_std: ArrayLike | Mapping[str, ArrayLike], typical: float
) -> Floats:
    given = noise_std.get(patch.name, typical) if isinstance(noise_std, Mapping) else noise_std
    noise = as_floats("noise_std", given)
    if noise.ndim:
        check_shape("noise_std", noise, (len(patch),), f"one per taxel of {patch.name!r}")
        return noise
    return np.full(len(patch), float(noise))


def _alike(kind: Kind, patch: Patch, layer: Layer, noise: Floats) -> bool:
    first = kind.patches[0]
    if len(first) != len(patch) or kind.layer != layer or first.pad_diameter != patch.pad_diameter:
        return False
    if not np.array_equal(kind.noise_std, noise):
        return False
    apart = (patch.plane - patch.plane[0]) - (first.plane - first.plane[0])
    return bool(np.abs(apart).max() <= SAME * first.pitch)


def one_skin(skin: Skin | Patch | Sequence[Patch]) -> Skin:
    """A skin, also of one patch alone."""
    if isinstance(skin, Skin):
        return skin
    if isinstance(skin, Patch):
        return Skin((skin,))
    raise InputError(
        f"skin is a {type(skin).__name__}, expected a Skin or a Patch: Skin((patch, ...)) of "
        "patches that have distinct names"
    )
