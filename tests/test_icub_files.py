"""Configuration of iCub's boards: robots' XML, garbage in its place, patches without files."""

import pytest
from icub_files import OLD_SKIN, SKIN, SPEC, WRAPPER

from skinfield.errors import FileError, InputError
from skinfield.skin import generators
from skinfield.skin.generators import TEN_PAD_TRIANGLE
from skinfield.wire.icub import (
    ICubBoardSettings,
    ICubConfiguration,
    ICubDecoder,
    PortRun,
    SetBoard,
    SetTriangles,
    SkinType,
    Transmit,
    command_from,
    configuration_for,
    kind_for,
    load_configuration,
)
from skinfield.wire.icub.robot_files import LARGEST, WHERE, read_tree, without_comments


@pytest.fixture
def write(tmp_path):
    def written(text, name="some-skin.xml"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return written


def test_a_leg_with_all_its_files(write):
    files = write(WRAPPER, "w.xml"), write(SPEC, "spec.xml"), write(SKIN)
    found = load_configuration(*files)
    assert found.name == "left_leg-eb10-skin"
    assert found.buses == (1, 2)
    assert found.addresses == ((1, 13), (1, 12), (0, 1), (0, 2), (0, 3))
    assert found.channels == 960
    assert found.ports == (PortRun("left_leg_upper", 384, 576, 0), PortRun("left_foot", 0, 384, 0))
    foot, upper = found.boards[0], found.boards[4]
    assert foot.board == SetBoard(kind=8, period_ms=20, no_load=235)
    assert upper.board == SetBoard(kind=0, period_ms=50, no_load=240)
    assert [t for t, each in enumerate(upper.triangles) if each.enabled] == [0, 1, 2, 3]
    assert [t for t, each in enumerate(foot.triangles) if each.enabled] == [5]
    assert (foot.triangles[5].shift, foot.triangles[5].cdc_offset) == (0, 0x2000)
    assert found.period == 0.02
    assert ICubDecoder(found.addresses, 1).channels == 960
    newer = load_configuration(*files, last_patch_first=False)
    assert newer.addresses == ((0, 1), (0, 2), (0, 3), (1, 13), (1, 12))


def test_what_is_sent_at_the_start(write):
    found = load_configuration(write(SKIN), write(SPEC, "spec.xml"))
    messages = found.messages(1)
    assert [identifier for identifier, _ in messages] == [0x20D] * 4 + [0x20C] * 2 + [0x20D, 0x20C]
    assert [data.hex(" ") for _, data in messages] == [
        "4d 08 14 eb",
        "50 00 04 02 00 00 22",
        "50 05 05 00 01 00 20",
        "50 06 0f 02 00 00 22",
        "4d 08 14 eb",
        "50 00 0f 02 00 00 22",
        "07 00",
        "07 00",
    ]
    assert [data.hex() for _, data in found.stop_messages(0)] == ["0701"] * 3
    with pytest.raises(InputError, match="bus is 2"):
        found.messages(2)


def test_a_board_on_can_itself(write):
    found = load_configuration(write(OLD_SKIN))
    assert (found.buses, found.addresses) == ((7,), ((0, 14), (0, 10)))
    kinds = [type(command_from(data)) for _, data in found.messages()]
    assert kinds == [SetBoard, SetTriangles] * 2 + [Transmit] * 2


WRONG = [  # in which file, what becomes what, the error
    (SPEC, ">         false  <", "> fasle <", "spec.xml:17: enabled is 'fasle', expected true or"),
    (SPEC, "0xf0", "0x1f0", "spec.xml:9: noLoad is '0x1f0', expected the byte of an unloaded"),
    (SPEC, "0xf0", "f0", "noLoad is 'f0'"),
    (SPEC, "50  <", "0.0  <", "spec.xml:6: period is '0.0', expected milliseconds, a whole number"),
    (SPEC, "50  <", "  <", "spec.xml:6: period is '', expected a value"),
    (SPEC, 'name="shift"', 'name="shfit"', "defaultCfgTriangle has no param 'shift', expected one"),
    (SPEC, "defaultCfgBoard", "defaultBoard", "has no group 'defaultCfgBoard', expected it and"),
    (SPEC, ">  2  <", ">  3  <", "specialCfgTriangles has no param 'triangleSetCfg3'"),
    (SPEC, "5   5", "5   4", "triangleSetCfg2 is '5', expected first triangle, not behind the"),
    (SPEC, "2   13  5", "13  5", "triangleSetCfg2 is .* expected 7 numbers"),
    (SPEC, "2   13  5", "2   1  5", "spec.xml:24: sets board 1 of patch 2, expected one of 1: 1 2"),
    (SPEC, "2           12", "3           12", "sets board 12 of patch 3, expected one of 1: 1 2"),
    (SKIN, "1 2 3", "1 2 1", "skinCanAddrsPatch1 is '1 2 1', expected addresses of boards, each"),
    (SKIN, "1 2 3", "1 2 16", "skinCanAddrsPatch1 is '16', expected addresses of boards, a whole"),
    (SKIN, "Patch2", "Patch1", "patches is '2 lists', expected skinCanAddrsPatch1, 2, each once"),
    (SKIN, "skinCanAddrs", "skinAddrs", "patches is '0 lists'"),
    (SKIN, "</group>", "</grup>", "some-skin.xml:9: mismatched tag, expected well-formed XML"),
    (WRAPPER, "575", "574", "left_leg_upper is '384 959   0 574', expected first and last channel"),
    (WRAPPER, "959   0 575", "1151 0 767", "port 'left_leg_upper' ends at channel 1151, expected"),
]


@pytest.mark.parametrize(("text", "old", "new", "error"), WRONG)
def test_what_is_wrong_is_named_with_its_line(write, text, old, new, error):
    texts = {"some-skin.xml": SKIN, "spec.xml": SPEC, "w.xml": WRAPPER}
    paths = [
        write(each.replace(old, new) if each is text else each, name)
        for name, each in texts.items()
    ]
    assert old in text
    with pytest.raises(FileError, match=error):
        load_configuration(*paths)


def test_files_that_do_not_go_together(write):
    with pytest.raises(FileError, match=r"no addresses of boards, expected a \*-skin.xml"):
        load_configuration(write(SPEC, "spec.xml"))
    with pytest.raises(FileError, match="no file: no addresses"):
        load_configuration()
    with pytest.raises(FileError, match=r"b.xml:\d+: is a second skin beside .*a.xml"):
        load_configuration(write(SKIN, "a.xml"), write(OLD_SKIN, "b.xml"))
    with pytest.raises(FileError, match="says nothing of a skin"):
        load_configuration(write("<robot name='x'/>"))
    with pytest.raises(FileError, match="cannot be read: No such file"):
        load_configuration("/nowhere/there.xml")


def test_files_of_a_real_robot(shared_data, write):
    folder = shared_data / "robots-configuration-skin" / "ergoCubSN001"
    spec = folder / "hardware" / "skin" / "torso-eb22-skinSpec.xml"
    wrapper = folder / "wrappers" / "skin" / "torso-skin_wrapper.xml"
    if not (spec.is_file() and wrapper.is_file()):
        pytest.skip(f"no {spec.name} and {wrapper.name} in {folder}")
    skin = SKIN.replace("left_leg-eb10", "torso-eb22").replace("1 2 3", "7 8 9 10")
    skin = skin.replace('<param name="skinCanAddrsPatch2"> 13 0xC </param>', "")
    found = load_configuration(write(skin), spec, wrapper)
    assert found.ports == (PortRun("torso", 0, 768, 0),)
    assert found.addresses == ((0, 7), (0, 8), (0, 9), (0, 10))
    for board in found.boards:
        assert board.board == SetBoard(kind=0, period_ms=50, no_load=240)
        assert {(t.enabled, t.shift, t.cdc_offset) for t in board.triangles} == {(True, 2, 0x2200)}


ENTITY = "declares the entity 'x'"
LAUGHS = """<?xml version="1.0"?>
<!DOCTYPE lolz [
 <!ENTITY lol "lol">
 <!ENTITY lol1 "&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;">
]>
<device>&lol1;</device>
"""


@pytest.mark.parametrize(
    ("data", "error"),
    [
        (LAUGHS, "some-skin.xml:3: declares the entity 'lol', expected none"),
        ('<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><device>&x;</device>', ENTITY),
        ('<!DOCTYPE a [<!ENTITY % x SYSTEM "file:///etc/passwd"> %x;]><device/>', ENTITY),
        (b"<a>" + b" " * LARGEST + b"</a>", "larger than 1048576 bytes"),
        ("", "no element found"),
        ("<!-- only -->", "no element found"),
        (b"\x00\xff\xfe", "some-skin.xml:1: .*expected well-formed XML"),
        ('<?xml version="1.0" encoding="no-such"?><a/>', "unknown encoding"),
        ("<!--" * 200000, "expected well-formed XML"),
    ],
)
def test_what_is_no_robot_s_file(tmp_path, data, error):
    path = tmp_path / "some-skin.xml"
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    with pytest.raises(FileError, match=error):
        load_configuration(path)


def test_comments_keep_their_lines(write):
    assert without_comments(b"a<!-- \n <!-- -- \n -->b<!---->c<!-- d") == b"a\n\nbc<!-- d"
    assert read_tree(write("<a><!-- \n\n --><b/></a>"))[0].get(WHERE).endswith("some-skin.xml:3")


def test_patches_laid_on_boards_keep_their_channels():
    hexagon = generators.hexagon72()
    found = configuration_for(hexagon, period_ms=20)
    assert found.addresses == ((0, 1),)
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
        ICubConfiguration((ICubBoardSettings(1, 0),))
