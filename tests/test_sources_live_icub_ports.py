"""Which channels of an iCub's boards go to which port."""

import time
from pathlib import Path

import numpy as np
import pytest
from bus_peers import wait_for

from skinfield.acquisition import Blocks, Channels, Count
from skinfield.errors import InputError
from skinfield.layout import Skin
from skinfield.layout.generators import by_name
from skinfield.protocols.icub import (
    BoardSettings,
    ICubConfiguration,
    PortRun,
    load_configuration,
)
from skinfield.sources.live import ICubCan
from skinfield.sources.live.icub import ports_of
from skinfield.sources.live.spec import source_from_options
from skinfield.virtual import VirtualSettings
from skinfield.virtual.process import start


def test_ports_follow_the_robots_wrapper() -> None:
    boards = tuple(BoardSettings(0, address) for address in range(1, 8))
    runs = (
        PortRun("hand", 192, 192, 0),
        PortRun("arm", 384, 384, 0),
        PortRun("forearm", 0, 192, 192),  # channels 0 to 191 are another device's
        PortRun("arm", 960, 192, 384),
    )
    found, ports = ports_of(ICubConfiguration(boards, (0,), "left_arm", runs))
    assert [(port.name, port.channels) for port in ports] == [
        ("hand", 192),
        ("arm", 576),
        ("forearm", 384),
        ("left_arm without a port", 384),
    ]
    assert found[:4] == ((0, 2), (0, 3), (0, 4), (0, 6))
    assert found[4:] == ((255, 0), (0, 1), (0, 5), (0, 7))


FOREARM = """
<device name="left_forearm-wrapper" type="skinWrapper">
    <param name="total_taxels"> 576 </param>
    <paramlist name="ports">
        <elem name="left_hand"> 0 {hand_last} 0 {hand_last} </elem>
        <elem name="left_forearm"> 192 575 0 383 </elem>
    </paramlist>
</device>
"""
BOARDS_OF_ARM = """
<device name="left_arm-skin" type="embObjSkin">
    <group name="patches"> <param name="skinCanAddrsPatch1"> 14 2 3 </param> </group>
</device>
"""


@pytest.mark.parametrize("hand_last", [191, 155, 119, 60])  # of boards that are not full, too
def test_runs_of_a_wrapper_take_whole_boards(tmp_path: Path, hand_last: int) -> None:
    skin, wrapper = tmp_path / "arm-skin.xml", tmp_path / "arm-skin_wrapper.xml"
    skin.write_text(BOARDS_OF_ARM)
    wrapper.write_text(FOREARM.format(hand_last=hand_last))
    found, ports = ports_of(load_configuration(skin, wrapper))
    assert [(port.name, port.channels) for port in ports] == [
        ("left_hand", 192),
        ("left_forearm", 384),
    ]
    assert found == ((0, 14), (0, 2), (0, 3))


@pytest.mark.parametrize(
    ("first", "count", "port_first"), [(0, 192, 192), (192, 384, 0), (384, 576, 192), (0, 960, 384)]
)
def test_runs_of_any_whole_boards_are_taken(first: int, count: int, port_first: int) -> None:
    boards = tuple(BoardSettings(0, address) for address in range(8))
    run = PortRun("left_leg", first, count, port_first)
    found, ports = ports_of(ICubConfiguration(boards, (0,), "x", (run,)))
    assert (ports[0].name, ports[0].channels) == ("left_leg", port_first + count)
    begin = port_first // 192
    whole = range(first // 192, (first + count) // 192)
    assert found[begin : begin + count // 192] == tuple((0, address) for address in whole)


@pytest.mark.parametrize("run", [PortRun("p", 96, 192, 0), PortRun("p", 0, 192, 156)])
def test_a_run_that_begins_within_a_board_is_refused(run: PortRun) -> None:
    boards = (BoardSettings(0, 1), BoardSettings(0, 2))
    with pytest.raises(InputError, match="where boards begin"):
        ICubCan(ICubConfiguration(boards, (0,), "x", (run,))).open()


WRAPPER = """
<device name="left_arm-wrapper" type="skinWrapper">
    <param name="total_taxels"> 384 </param>
    <paramlist name="ports"> <elem name="rectangular"> 0 {last} 0 {last} </elem> </paramlist>
</device>
"""
SPEC = """
<params robot="mine" build="1">
    <group name="defaultCfgBoard">
        <param name="period"> 20 </param> <param name="skinType"> 2 </param>
        <param name="noLoad"> 0xeb </param> <param name="diagnostic"> true </param>
    </group>
    <group name="defaultCfgTriangle">
        <param name="enabled"> true </param> <param name="shift"> 2 </param>
        <param name="cdcOffset"> 0x2200 </param>
    </group>
    <group name="specialCfgTriangles">
        <param name="numOfSets"> 1 </param>
        <param name="triangleSetCfg1"> 1 2 3 3 0 2 0x2200 </param>
    </group>
</params>
"""


def test_a_virtual_skin_obeys_the_robots_files(tmp_path: Path) -> None:
    """Two boards, of which the second has four triangles; the last of them is switched off."""
    files = {
        "arm-skin.xml": BOARDS_OF_ARM.replace("14 2 3", "1 2"),
        "arm-skinSpec.xml": SPEC,
        "arm-skin_wrapper.xml": WRAPPER.replace("{last}", "239"),
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    text = "rectangular:rows=12,columns=20"
    config = ",".join(str(tmp_path / name) for name in files)
    with start(VirtualSettings(skin=text, bus="udp", scene="idle", noise=0.0)) as boards:
        skin = Skin((by_name(text),))
        stream = source_from_options(
            "icub", "udp", boards.channels, skin, {"config": config}
        ).open()
        assert [(port.name, port.channels) for port in stream.ports] == [("rectangular", 384)]
        channels, blocks = Channels(384), Blocks()

        def came() -> bool:
            blocks.clear()
            stream.poll(blocks, 0, time.time_ns())
            channels.apply(blocks)
            return stream.counters[Count.RECEIVED] > 600

        wait_for(came)
        stream.close()
    assert (channels.counts[:228] == 0xEB).all()
    assert np.isnan(channels.counts[240:]).all()
    assert (channels.stamp_ns[228:240] < channels.stamp_ns[:228].min()).all()
    lost = [stream.counters[each] for each in (Count.LOST, Count.DUPLICATED, Count.SWAPPED)]
    assert lost == [0, 0, 0]
