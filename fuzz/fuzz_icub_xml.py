"""Robots' XML: any bytes are a configuration, or a FileError."""

from pathlib import Path
from tempfile import TemporaryDirectory

from skinfield.errors import FileError
from skinfield.wire.icub import command_from, load_configuration

FOLDER = TemporaryDirectory()
PATH = Path(FOLDER.name) / "some-skin.xml"
TEXT = b"""<?xml version="1.0" encoding="UTF-8" ?>
<!DOCTYPE devices PUBLIC "-//YARP//DTD yarprobotinterface 3.0//EN" "http://www.yarp.it/x.dtd">
<device name="torso-skin" type="embObjSkin">
<xi:include href="../general.xml" />
<group name="patches"><param name="skinCanAddrsPatch1"> 7 8 0xa </param>
<param name="skinCanAddrsPatch2"> 13 </param></group>
<group name="defaultCfgBoard"><param name="period"> 50 </param><param name="skinType"> 0 </param>
<param name="noLoad"> 0xf0 </param><param name="diagnostic"> false </param></group>
<group name="defaultCfgTriangle"><param name="enabled"> true </param><param name="shift"> 2 </param>
<param name="cdcOffset"> 0x2200 </param></group><!-- <!-- -->
<group name="specialCfgBoards"><param name="numOfSets"> 1 </param>
<param name="boardSetCfg1"> 1 7 8 20 8 0xf5 </param></group>
<group name="specialCfgTriangles"><param name="numOfSets"> 1 </param>
<param name="triangleSetCfg1"> 2 13 0 3 1 2 0x2200 </param></group>
<paramlist name="ports"><elem name="torso"> 0 767 0 767 </elem></paramlist>
</device>
"""
SEEDS = [TEXT, b"\x90\x01\x04<!-- ", b"\x00\x02\x02 0x10 "]


def one_input(data: bytes) -> None:
    """The bytes as a file; then put into a good one, where the first two of them say."""
    as_file(data)
    if len(data) > 2:
        at = int.from_bytes(data[:2], "little") % len(TEXT)
        as_file(TEXT[:at] + data[3:] + TEXT[at + data[2] % 16 :])


def as_file(data: bytes) -> None:
    """Read a file of these bytes."""
    PATH.write_bytes(data)
    try:
        found = load_configuration(PATH)
    except FileError:
        return
    for bus in range(len(found.buses)):
        for _, message in found.messages(bus) + found.stop_messages(bus):
            assert command_from(message) is not None
