"""The bridge as a process of its own, heard by a plain zenoh subscriber."""

import json
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live_skins import wait_for
from ros2_ring import TwoPatches, contact
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from skinfield.bridges.launch import Bridge
from skinfield.bridges.ros2.publisher import RosSettings
from skinfield.bridges.ros2.rmw_zenoh import (
    ATTACHMENT,
    NO_HASH,
    Node,
    Publication,
    attachment,
    gid_of,
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

zenoh = pytest.importorskip("zenoh")
PATIENCE = 120.0  # s
DOMAIN = 43
TOUCH = [contact(0, 7, 2.0, (0.01, 0.0, 0.0)), contact(1, 9, 1.0, (0.005, 0.005, 0.0))]
KINDS = {  # of what is published, as DDS names them, and how often for each hand
    "sensor_msgs::msg::dds_::PointCloud2_": 2,
    "geometry_msgs::msg::dds_::WrenchStamped_": 4,
    "skinfield_msgs::msg::dds_::ContactArray_": 1,
    "tf2_msgs::msg::dds_::TFMessage_": 1,
    "diagnostic_msgs::msg::dds_::DiagnosticArray_": 1,
}


def config_of(mode: str, **endpoints: list[str]):
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps(mode))
    config.insert_json5("scouting/multicast/enabled", "false")
    for name, values in endpoints.items():
        config.insert_json5(f"{name}/endpoints", json.dumps(values))
    return config


@pytest.fixture
def router(tmp_path):
    """Stands in for rmw_zenohd; without a port, so that tests may run side by side."""
    address = f"unixsock-stream/{tmp_path}/z"
    with zenoh.open(config_of("router", listen=[address])):
        yield address


@pytest.fixture
def engine():
    with TwoPatches() as made:
        yield made


@contextmanager
def bridge(engine: TwoPatches, address: str, **more) -> Iterator[dict]:
    """The bridge, with settings on top of the usual ones; what it said when it was there."""
    plain = {"domain": DOMAIN, "session": {"connect": [address]}} | more
    with Bridge("ros2", engine.ring.name, from_plain(RosSettings, plain)) as made:
        made.begin()
        child = made.child
        yield made.facts
    assert child.returncode == 0


def tokens(session) -> list[str]:
    return [str(each.ok.key_expr) for each in session.liveliness().get(f"@ros2_lv/{DOMAIN}/**")]


def settled_tokens(session) -> list[str]:
    """As soon as there are as many twice: links between peers come and go at first."""
    found = [tokens(session)]
    until(
        lambda: len(found[-1]) > 1 and len(found) > 1 and sorted(found[-1]) == sorted(found[-2]),
        lambda: found.append(tokens(session)),
    )
    return found[-1]


def until(true, step=lambda: None):
    wait_for(lambda: (step(), true())[1], PATIENCE)


def listener_store():
    """Types of a listener: Humble's, and the .msg files that are shipped."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    for file in ("Contact", "ContactArray"):
        text = (interface_package() / "msg" / f"{file}.msg").read_text()
        store.register(get_types_from_msg(text, f"skinfield_msgs/msg/{file}"))
    return store


def test_a_plain_subscriber_hears_it(engine, router):
    heard = []
    with zenoh.open(config_of("client", connect=[router])) as session:
        topics = session.declare_subscriber(f"{DOMAIN}/**", heard.append)
        with bridge(engine, router, rates={"diagnostics": 50, "wrench": 5}) as facts:
            until(
                lambda: len({str(each.key_expr) for each in heard}) == 9 and len(heard) > 60,
                lambda: engine.cycle(TOUCH),
            )
            there = settled_tokens(session)
            check_tokens(there, facts["node"])
        check_messages(list(heard), there, engine)
        until(lambda: not tokens(session))  # it is gone when it is gone
        topics.undeclare()


def check_tokens(there, node):
    parts = [token.split("/") for token in there]
    assert {(part[0], part[1]) for part in parts} == {("@ros2_lv", str(DOMAIN))}
    assert len({part[2] for part in parts}) == 1  # one session
    assert {part[8] for part in parts} == {node}
    assert sorted(part[5] for part in parts) == 9 * ["MP"] + ["NN"]
    assert len({part[4] for part in parts}) == 10
    assert Counter(part[10] for part in parts if part[5] == "MP") == KINDS
    assert {part[12] for part in parts if part[5] == "MP"} == {"::,10:,:,:,,", "::,100:,:,:,,"}


def check_messages(heard, there, engine):
    """Each is on the key that its publisher's token says, with that publisher's gid."""
    store, counts = listener_store(), Counter()
    of_key = {}
    for token in there:
        part = token.split("/")
        if part[5] == "MP":
            topic = part[9].replace("%", "/").strip("/")
            of_key[f"{DOMAIN}/{topic}/{part[10]}/{part[11]}"] = token
    for sample in heard:
        key = str(sample.key_expr)
        number, stamp_ns, _, gid = ATTACHMENT.unpack(sample.attachment.to_bytes())
        assert gid == gid_of(of_key[key])
        counts[key] += 1
        assert number == counts[key]  # from 1 on, none left out
        kind = key.split("/")[-2].replace("::msg::dds_::", "/msg/").removesuffix("_")
        assert key.split("/")[-1] == store.hash_rihs01(kind)
        message = store.deserialize_cdr(sample.payload.to_bytes(), kind)
        if kind.endswith("ContactArray"):
            assert [each.id for each in message.contacts] == [7, 9]
            assert message.contacts[0].wrench.force.z == -2.0
        if kind.endswith("PointCloud2"):
            assert message.width in (6, 4)
        if kind.endswith("TFMessage"):
            stamp = message.transforms[0].header.stamp
            assert 0 <= stamp_ns - (stamp.sec * 10**9 + stamp.nanosec) < PATIENCE * 1e9


def test_humble_and_a_named_robot(engine, router):
    """No hashes there; topics below the robot's name; what has the rate 0 is not there.

    Between two peers that know the router alone, as rmw_zenoh's nodes do.
    """
    rates = dict.fromkeys(("contacts", "frames", "contact_wrench", "taxels"), 0)
    heard = []
    peer = {"connect": [router], "listen": ["tcp/127.0.0.1:0"]}
    with zenoh.open(config_of("peer", **peer)) as session:
        topics = session.declare_subscriber(f"{DOMAIN}/**", heard.append)
        more = {"robot": "left.arm", "distribution": "humble", "rates": rates, "session": peer}
        with bridge(engine, router, **more):
            until(lambda: len(heard) > 4, lambda: engine.cycle(TOUCH))
            there = settled_tokens(session)
            assert {token.split("/")[7] for token in there} == {"%left_arm"}
        topics.undeclare()
    keys = {str(each.key_expr) for each in heard}
    wrench = "geometry_msgs::msg::dds_::WrenchStamped_/TypeHashNotSupported"
    diagnostics = "diagnostic_msgs::msg::dds_::DiagnosticArray_/TypeHashNotSupported"
    assert f"{DOMAIN}/left_arm/skin/left_palm/wrench/{wrench}" in keys
    assert keys <= {f"{DOMAIN}/diagnostics/{diagnostics}"} | {
        f"{DOMAIN}/left_arm/skin/{patch}/wrench/{wrench}"
        for patch in ("left_palm", "patch_2nd_finger")
    }


@pytest.mark.parametrize(
    ("plain", "why"),
    [
        ({"domain": 999}, "from 0 to 232: the ROS_DOMAIN_ID"),
        ({"rates": {"wrench": -1}}, "messages a second"),
        ({"distribution": "noetic"}, "expected one of humble"),
        ({"topics": 1}, "'topics' is not known, expected one of robot"),
    ],
)
def test_what_is_wrong_is_said(plain, why):
    with pytest.raises(InputError, match=why):
        from_plain(RosSettings, plain)


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
    """The layout as ros2/rmw_zenoh's attachment_helpers.cpp writes it since 0.2.4."""
    gid = bytes.fromhex("00112233445566778899aabbccddeeff")
    wanted = bytes.fromhex("0807060504030201" + "1817161514131211" + "10") + gid
    assert attachment(0x0102030405060708, 0x1112131415161718, gid) == wanted


def test_attachment_is_what_zenoh_serializes():
    ext = pytest.importorskip("zenoh.ext")
    gid = bytes(range(16))
    theirs = ext.z_serialize((ext.Int64(-3), ext.Int64(1_700_000_000_000_000_001), gid))
    assert attachment(-3, 1_700_000_000_000_000_001, gid) == theirs.to_bytes()


HASHES = {  # of the types whose messages are sent
    STRING: STRING_HASH.removeprefix("RIHS01_"),
    # as `ros2 topic info --verbose` printed them elsewhere, of rviz2, amcl and others
    CLOUD: "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5",
    FRAMES: "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    # worked out once by REP 2011 and 2016 from the .msg files
    CONTACT: "3c09f209b0cac41b948bc192f4f14dca241e36d3d57f07a6a7e913c0584a47cb",
    CONTACTS: "f0e8098ba43c0432a2cfedf73d44925ce5dbd914ef0327708ab6dd2fbba3495a",
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
            assert name == name.lower()
            assert "__" not in name
            assert name.replace("_", "a").isalnum()
            assert name[0].isalpha()
            assert name[-1] != "_"
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
