"""Hardware by its name, as a command line gives it: the one place where a name selects."""

from skinfield.layout import Skin
from skinfield.virtual.hardware import Hardware
from skinfield.virtual.settings import VirtualSettings


def open_hardware(skin: Skin, settings: VirtualSettings) -> Hardware:
    """Boards of the settings' hardware, on their buses."""
    if settings.hardware == "icub":
        from skinfield.virtual.icub import ICubBoards

        return ICubBoards(skin, settings)
    if settings.hardware == "cyskin":
        from skinfield.virtual.cyskin import CySkinBoards

        return CySkinBoards(skin, settings)
    if settings.hardware == "yarp":
        from skinfield.virtual.yarp import YarpPorts

        return YarpPorts(skin, settings)
    from skinfield.virtual.packet import PacketDevices

    return PacketDevices(skin, settings)
