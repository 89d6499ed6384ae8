"""Names, keys and attachments, against what ROS 2's own documents and programs have."""

import re
from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skinfield.bridges.ros2.publisher import RosSettings
from skinfield.bridges.ros2.rmw_zenoh import (
    NO_HASH,
    Node,
    Publication,
    attachment,
    gid_of,
    type_name,
)
from skinfield.errors import InputError
from skinfield.files.ros import RosbagKinds, Topics, interface_package
from skinfield.files.ros.kinds import (
    CLOUD,
    CONTACT,
    CONTACTS,
    FRAMES,
    OWN,
    WRENCH_STAMPED,
    definition_of,
)
from skinfield.files.ros.names import check_prefix, frame_of, is_topic, token_of, tokens_of
from skinfield.settings import from_plain
from skinfield.skin import Patch, Skin

STRING = "std_msgs/msg/String"
STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"


# Of docs/design.md of ros2/rmw_zenoh (branch jazzy), word for word.
CHATTER = f"0/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}"
LISTENER = "@ros2_lv/0/aac3178e146ba6f1fc6e6a4085e77f21/0/0/NN/%/%/listener"
TALKER = (
    "@ros2_lv/0/8b20917502ee955ac4476e0266340d5c/0/10/MP/%/%/talker/%chatter/"
    f"std_msgs::msg::dds_::String_/{STRING_HASH}/::,7:,:,:,,"
)


def talker(**more) -> Publication:
    node = Node("talker", "8b20917502ee955ac4476e0266340d5c")
    return Publication(node, 10, "/chatter", STRING, **({"hash": STRING_HASH} | more))


def test_keys_are_those_of_the_design_document():
    assert talker().key == CHATTER
    assert Node("listener", "aac3178e146ba6f1fc6e6a4085e77f21").token == LISTENER
    assert talker(depth=7).token == TALKER


def test_keys_elsewhere():
    """Another domain, a namespace, the depth that is left out, Humble."""
    node = Node("skin", "1", 42, "/robot1/arm")
    assert node.token == "@ros2_lv/42/1/0/0/NN/%/%robot1%arm/skin"
    each = Publication(node, 1, "/skin/left/taxels", CLOUD, NO_HASH, 42)
    end = "sensor_msgs::msg::dds_::PointCloud2_/TypeHashNotSupported"
    assert each.key == f"42/skin/left/taxels/{end}"
    assert each.token.endswith(f"/1/MP/%/%robot1%arm/skin/%skin%left%taxels/{end}/::,:,:,:,,")


def test_gid():
    """Low and high word of XXH3 (128 bits), little-endian."""
    known = {
        LISTENER: "5bd72f4daf53c0bb00c7394e7fc19547",
        TALKER: "eb85fa883b7846dc448a4501890ad062",
    }
    assert {key: gid_of(key).hex() for key in known} == known
    assert talker(depth=7).gid == gid_of(TALKER)


def test_attachment():
    """As ros2/rmw_zenoh's attachment_helpers.cpp writes it since 0.2.4, and as zenoh does."""
    gid = bytes.fromhex("00112233445566778899aabbccddeeff")
    wanted = bytes.fromhex("0807060504030201" + "1817161514131211" + "10") + gid
    assert attachment(0x0102030405060708, 0x1112131415161718, gid) == wanted
    ext = pytest.importorskip("zenoh.ext")
    theirs = ext.z_serialize((ext.Int64(-3), ext.Int64(1_700_000_000_000_000_001), gid))
    assert attachment(-3, 1_700_000_000_000_000_001, gid) == theirs.to_bytes()


HASHES = {  # of the types whose messages are sent
    STRING: STRING_HASH.removeprefix("RIHS01_"),
    # as `ros2 topic info --verbose` printed them elsewhere, of rviz2, amcl and others
    CLOUD: "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5",
    FRAMES: "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    # worked out once by REP 2011 and 2016 from the .msg files
    CONTACT: "140d6846d31c70f8435f0ddc5fffdf96ea01f41eb79fc133abbdb753f9d34bbc",
    CONTACTS: "cab83dbc387d28284e2fbfb47df67800b9626d3ec724124d293b07604904fdc7",
    WRENCH_STAMPED: "8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77",
}


@pytest.mark.parametrize("kind", HASHES)
def test_hashes(kind):
    assert RosbagKinds().hash_of(kind) == f"RIHS01_{HASHES[kind]}"


def fields_of(kind: str) -> list[tuple[str, str]]:
    """Names and types of a .msg file, by hand."""
    lines = (line.partition("#")[0].split() for line in definition_of(kind).splitlines())
    return [(words[1], words[0]) for words in lines if words]


def test_the_interface_package():
    """It names every message, and names of fields keep the rules of ROS."""
    folder = interface_package()
    listed = (folder / "CMakeLists.txt").read_text()
    assert "<name>skinfield_msgs</name>" in (folder / "package.xml").read_text()
    for kind in OWN:
        assert f'"msg/{kind.rpartition("/")[2]}.msg"' in listed
        for name, _ in fields_of(kind):
            assert re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name)
    depends = (folder / "package.xml").read_text()
    packages = {text.partition("/")[0] for k in OWN for _, text in fields_of(k) if "/" in text}
    assert all(f"<depend>{name}</depend>" in depends for name in packages - {"skinfield_msgs"})


@given(st.text())
def test_any_name_becomes_a_token(name):
    token = token_of(name)
    assert is_topic(f"/{token}")
    assert not token.startswith("_")  # it would be hidden


@given(st.lists(st.text(alphabet="aA_-2 é", max_size=4), min_size=1, max_size=8, unique=True))
def test_patches_have_different_topics(names):
    tokens = tokens_of(names)
    assert len(set(tokens)) == len(names)
    assert all(is_topic(f"/skin/{token}/contact_wrench") for token in tokens)
    assert tokens[0] == token_of(names[0])


@given(st.text(alphabet="ab/_0~{} ", max_size=10).map(lambda text: "/" + text))
def test_rules_of_topics(name):
    """As the design article lists them, one by one."""
    parts = name[1:].split("/")
    good = all(part and part.isascii() and part[0] not in "0" for part in parts)
    good &= not set(name) & set("~{} ") and "__" not in name
    assert is_topic(name) == good


def test_topics_of_a_skin():
    plane = [[0, 0], [5e-3, 0], [0, 5e-3]]
    skin = Skin(
        (Patch(plane, name="2nd palm", link="/hand"), Patch(plane, name="左手", link="arm"))
    )
    topics = Topics.of(skin, "/left/skin")
    assert topics.of_patch(0, "wrench") == "/left/skin/patch_2nd_palm/wrench"
    assert topics.of_patch(1, "taxels") == "/left/skin/patch/taxels"
    assert topics.contact_frame(0, 12) == "left_patch_2nd_palm_contact_12"
    assert Topics.of(skin).contact_frame(0, 12) == "patch_2nd_palm_contact_12"
    assert [frame_of(patch) for patch in skin] == ["hand", "arm"]
    for prefix in ("skin", "/a//b", "/skin/", "/2", "/" + 99 * "a"):
        with pytest.raises(InputError, match="prefix is"):
            check_prefix(prefix)


def test_type_names():
    assert type_name(CONTACTS) == "skinfield_msgs::msg::dds_::ContactArray_"
    for kind in ("String", "std_msgs/String", "std_msgs/srv/Trigger", "std_msgs/msg/string"):
        with pytest.raises(InputError, match="kind is"):
            type_name(kind)


def test_settings(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    monkeypatch.setenv("ROS_DISTRO", "humble")
    assert not RosSettings().hashed
    monkeypatch.setenv("ROS_DISTRO", "one of the future")
    assert RosSettings().hashed
    made = from_plain(RosSettings, {"robot": "left.arm", "rates": {"taxels": 0}})
    assert (made.domain, made.namespace, made.prefix) == (7, "/left_arm", "/left_arm/skin")
    assert made.rates["taxels"] == 0
    assert made.rates["contacts"] == 100
    assert made.meeting.connect == ("tcp/localhost:7447",)
    assert from_plain(RosSettings, {"domain": 3}).prefix == "/skin"
    monkeypatch.setenv("ROS_DOMAIN_ID", "seven")
    with pytest.raises(InputError, match="ROS_DOMAIN_ID is 'seven'"):
        RosSettings()


@settings(max_examples=50, deadline=None)
@given(st.dictionaries(st.sampled_from(["robot", "domain", "rates", "session", "no"]),
                       st.recursive(st.none() | st.booleans() | st.floats() | st.text(max_size=9),
                                    lambda inner: st.lists(inner) | st.dictionaries(
                                        st.sampled_from(["wrench", "x"]), inner),
                                    max_leaves=4)))  # fmt: skip
def test_any_settings(plain):
    with suppress(InputError):
        assert is_topic(from_plain(RosSettings, plain).prefix)
