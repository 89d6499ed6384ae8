"""Hardware by its name, as a command line gives it: the one place where a name selects."""

from skinfield.errors import InputError
from skinfield.layout import Skin
from skinfield.virtual.hardware import Hardware
from skinfield.virtual.settings import VirtualSettings


def open_hardware(skin: Skin, settings: VirtualSettings) -> Hardware:
    """Boards of the settings' hardware, on their buses."""
    if settings.hardware == "icub":
        from skinfield.virtual.icub import ICubBoards

        return ICubBoards(skin, settings)
    raise InputError(f"hardware is {settings.hardware!r}, expected icub")
