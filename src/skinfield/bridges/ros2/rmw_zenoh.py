"""Names and attachments of rmw_zenoh, ROS 2's middleware over zenoh.

Notes
-----
As in its sources (github.com/ros2/rmw_zenoh), `rmw_zenoh_cpp/src/detail/`: liveliness_utils.cpp,
attachment_helpers.cpp, qos.cpp and rmw_publisher_data.cpp, and docs/design.md. The attachment has
its form since 0.1.2 (Humble), 0.2.4 (Jazzy) and 0.6.0 (Kilted, Rolling); those before had another,
and drop messages or end when they meet this one.
"""

from dataclasses import dataclass
from functools import cached_property
from struct import Struct

TOKENS = "@ros2_lv"  # where liveliness tokens are
NO_HASH = "TypeHashNotSupported"  # Humble's, in place of a type's hash
ATTACHMENT = Struct("<qqB16s")  # number, stamp in ns since the epoch, 16, the publisher's gid
GID = 16  # bytes
DOMAINS = 232  # the last
DEPTH = 42  # rmw_zenoh's own, which is left out


@dataclass(frozen=True)
class Node:
    """A node of ROS 2.

    Parameters
    ----------
    name : str
        One token.
    session : str
        Id of the zenoh session, as zenoh writes it.
    domain : int
        ROS_DOMAIN_ID.
    namespace : str
        "" or such as `/robot`.
    """

    name: str
    session: str
    domain: int = 0
    namespace: str = ""

    @property
    def token(self) -> str:
        """Key of its liveliness token."""
        return self.token_of(0, "NN")

    def token_of(self, number: int, what: str, *more: str) -> str:
        """Key of the token of something of the node; `what`: NN a node, MP a publisher."""
        namespace = mangled(self.namespace or "/")
        parts = (str(self.domain), self.session, "0", str(number), what, "%", namespace, self.name)
        return "/".join((TOKENS, *parts, *more))


@dataclass(frozen=True)
class Publication:
    """What a node publishes on one topic.

    Parameters
    ----------
    node : Node
    number : int
        Of it among all of the node's, above 0.
    topic : str
        Such as `/skin/contacts`.
    kind : str
        Such as `std_msgs/msg/String`.
    hash : str
        Of the kind by REP 2016, or `NO_HASH`.
    depth : int
        Messages that are kept for who is slow; volatile, reliable.
    """

    node: Node
    number: int
    topic: str
    kind: str
    hash: str
    depth: int = 10

    @property
    def key(self) -> str:
        """Where the messages go."""
        topic = self.topic.strip("/")
        return f"{self.node.domain}/{topic}/{type_name(self.kind)}/{self.hash}"

    @cached_property
    def token(self) -> str:
        """Key of the liveliness token."""
        quality = f"::,{'' if self.depth == DEPTH else self.depth}:,:,:,,"
        more = mangled(self.topic), type_name(self.kind), self.hash, quality
        return self.node.token_of(self.number, "MP", *more)

    @cached_property
    def gid(self) -> bytes:
        """The 16 bytes by which others know it."""
        return gid_of(self.token)


def gid_of(token: str) -> bytes:
    """The 16 bytes that stand for an entity of ROS 2: XXH3 of 128 bits of its token."""
    import xxhash

    return xxhash.xxh3_128_intdigest(token.encode()).to_bytes(GID, "little")


def mangled(name: str) -> str:
    """A name as one part of a token's key."""
    return name.replace("/", "%")


def type_name(kind: str) -> str:
    """Name of a message's type as DDS has it: `std_msgs::msg::dds_::String_`."""
    package, _, name = kind.split("/")
    return f"{package}::msg::dds_::{name}_"


def attachment(number: int, stamp_ns: int, gid: bytes) -> bytes:
    """The 33 bytes that come with each message.

    Parameters
    ----------
    number : int
        Of the message among the publisher's, from 1 on.
    stamp_ns : int, ns
        Since the epoch, when it was sent.
    gid : bytes
        Of the publisher.
    """
    return ATTACHMENT.pack(number, stamp_ns, GID, gid)
