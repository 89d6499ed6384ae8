"""The bridge as a process of its own, heard by a plain zenoh subscriber."""

import json
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from live_skins import wait_for
from ros2_ring import TwoPatches, contact
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from skinfield.bridges.launch import Bridge
from skinfield.bridges.ros2.publisher import RosSettings
from skinfield.bridges.ros2.rmw_zenoh import ATTACHMENT, gid_of
from skinfield.errors import InputError
from skinfield.files.ros import interface_package
from skinfield.settings import from_plain

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
