"""Patches laid out on iCub's boards, for skins without files of a robot."""

import pytest

from skinfield.errors import InputError
from skinfield.layout import generators
from skinfield.layout.generators.templates import TEN_PAD_TRIANGLE
from skinfield.protocols.icub import (
    BoardSettings,
    ICubConfiguration,
    PortRun,
    SetBoard,
    SkinType,
    boards_for,
    configuration_for,
    kind_for,
)


def test_patches_laid_on_boards_keep_their_channels():
    hexagon = generators.hexagon72()
    found = configuration_for(hexagon, period_ms=20)
    assert found.addresses == ((0, 1),) == boards_for(hexagon)
    assert found.ports == (PortRun("hexagon72", 0, 192, 0),)
    places = 12 * hexagon.module + (hexagon.uid & 15).astype(int) - 1  # triangle and taxel
    assert (places == hexagon.channel).all()
    assert [t.enabled for t in found.boards[0].triangles] == [True] * 6 + [False] * 10
    assert found.boards[0].board == SetBoard(kind=2, period_ms=20, no_load=240)


def test_pads_for_warmth_switch_the_correction_on():
    assert kind_for(generators.icub_hexagon()) == SkinType.UNCOMPENSATED  # has taxels at 6 and 10
    assert kind_for(generators.ten_pad_triangle()) == SkinType.COMPENSATED
    assert kind_for(generators.rectangular(4, 5)) == SkinType.UNCOMPENSATED


def test_many_patches_go_on_to_the_next_bus():
    patches = [
        generators.triangle_lattice(n, template=TEN_PAD_TRIANGLE, name=f"p{n}", max_modules=400)
        for n in (20, 334)
    ]
    found = configuration_for(*patches)
    assert len(found.boards) == 2 + 21
    assert found.addresses[13:15] == ((0, 14), (1, 1))
    assert found.ports == (PortRun("p20", 0, 384, 0), PortRun("p334", 384, 21 * 192, 0))
    assert sum(t.enabled for board in found.boards for t in board.triangles) == 354
    with pytest.raises(InputError, match="patches are named"):
        configuration_for(patches[0], patches[0])


def test_wrong_configurations_are_said():
    with pytest.raises(InputError, match="boards are \\[\\], expected one or more"):
        ICubConfiguration(())
    with pytest.raises(InputError, match="bus is 1, expected a whole number from 0 to 0"):
        ICubConfiguration((BoardSettings(1, 0),))
