"""Which port each patch of a skin is read from."""

from collections.abc import Sequence

from skinfield.acquisition import Port
from skinfield.errors import InputError
from skinfield.layout import Patch, Skin


def matched(skin: Skin | Patch, ports: Sequence[Port]) -> tuple[int, ...]:
    """Port of each patch: that of its name, or the only one.

    Parameters
    ----------
    skin : Skin or Patch
    ports : sequence of Port
        Of all sources.

    Returns
    -------
    tuple of int
        Index into `ports`, for each patch.

    Raises
    ------
    InputError
        If a patch has no port, or its channels are more than the port has.
    """
    patches = (skin,) if isinstance(skin, Patch) else tuple(skin)
    names = [port.name for port in ports]
    found = []
    for patch in patches:
        if patch.name in names:
            place = names.index(patch.name)
        elif len(ports) == 1:
            place = 0
        else:
            raise InputError(
                f"patch {patch.name!r} has no port, expected one of its name among "
                f"{', '.join(names) or 'none'}: name the port after the patch"
            )
        highest = int(patch.channel.max())
        if highest >= ports[place].channels:
            raise InputError(
                f"patch {patch.name!r} reads channel {highest}, expected channels below "
                f"{ports[place].channels}: port {names[place]!r} has no more; is this the layout "
                "of that skin, and are all its boards listed?"
            )
        found.append(place)
    return tuple(found)
