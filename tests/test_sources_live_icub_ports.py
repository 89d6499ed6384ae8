"""Which channels of an iCub's boards go to which port."""

from pathlib import Path

import pytest

from skinfield.errors import InputError
from skinfield.protocols.icub import (
    BoardSettings,
    ICubConfiguration,
    PortRun,
    load_configuration,
)
from skinfield.sources.live import ICubCan
from skinfield.sources.live.icub import ports_of


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
