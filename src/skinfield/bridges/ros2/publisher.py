"""Publishes a running skin as rmw_zenoh does: ROS 2 hears it, and none is needed here."""

import threading
import time
from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

from skinfield.bridges.child import say_ready
from skinfield.bridges.ros2.messages import Channel, Speaker
from skinfield.bridges.ros2.rmw_zenoh import NO_HASH, Attachment, Node, Publication, Qos
from skinfield.bridges.ros2.settings import RosSettings
from skinfield.bridges.ros2.talker import LOOKS, Talker
from skinfield.bridges.zenoh.session import load_zenoh, open_session
from skinfield.live.client import connect
from skinfield.sinks.ros.kinds import RosbagKinds
from skinfield.sinks.ros.messages import Outgoing
from skinfield.sinks.ros.names import Topics, token_of


class Publisher:
    """Declares a node and all its topics, and sends messages.

    Parameters
    ----------
    session : zenoh.Session
    node : Node
    channels : sequence of Channel
    kinds : RosbagKinds
    hashed : bool
        Whether the types' hashes are in the keys; Humble has none.
    ends : ExitStack
        Where everything is undeclared.
    """

    def __init__(
        self,
        session: Any,
        node: Node,
        channels: list[Channel],
        kinds: RosbagKinds,
        hashed: bool,
        ends: ExitStack,
    ) -> None:
        zenoh = load_zenoh()
        self._kinds = kinds
        self._outlets: dict[str, tuple[Publication, Any]] = {}
        self._sent: dict[str, int] = {}
        self._token(session, node.token, ends)
        for number, channel in enumerate(channels, 1):
            told = kinds.hash_of(channel.kind) if hashed else NO_HASH
            each = Publication(node, number, channel.topic, channel.kind, told, Qos(channel.depth))
            outlet = session.declare_publisher(
                each.key,
                congestion_control=zenoh.CongestionControl.DROP,  # nobody is waited for
                reliability=zenoh.Reliability.RELIABLE,
            )
            ends.callback(outlet.undeclare)
            self._token(session, each.token, ends)
            self._outlets[channel.topic] = each, outlet
            self._sent[channel.topic] = 0

    def _token(self, session: Any, key: str, ends: ExitStack) -> None:
        ends.callback(session.liveliness().declare_token(key).undeclare)

    def send(self, out: Outgoing) -> None:
        """Send a message to whoever listens."""
        publication, outlet = self._outlets[out.topic]
        self._sent[out.topic] += 1
        attachment = Attachment(self._sent[out.topic], time.time_ns(), publication.gid)
        outlet.put(
            self._kinds.bytes_of(out.kind, out.message),
            attachment=attachment.encode(),
        )


def serve(name: str, plain: Mapping[str, Any], stop: threading.Event) -> None:
    """Publish a running skin until told to stop; see `skinfield.bridges.child`."""
    settings = RosSettings.from_plain(plain)
    with ExitStack() as ends:
        live = ends.enter_context(connect(name, timeout=10.0))
        kinds = RosbagKinds()
        speaker = Speaker(live.skin, kinds, Topics.of(live.skin, settings.prefix))
        session = ends.enter_context(open_session(settings.meeting))
        who = token_of(f"skinfield_{name}")
        node = Node(who, str(session.zid()), settings.domain or 0, settings.namespace)
        channels = [each for each in speaker.channels() if settings.rates[each.what] > 0]
        publisher = Publisher(session, node, channels, kinds, settings.hashed, ends)
        say_ready(
            node=node.name,
            domain=node.domain,
            distribution=settings.distribution,
            prefix=settings.prefix,
            topics=len(channels),
            connect=list(settings.meeting.connect),
            listen=list(settings.meeting.listen),
        )
        talker = Talker(live, speaker, settings.rates, publisher.send)
        ends.callback(talker.close)
        while not stop.wait(talker.pace.wait(time.monotonic())):
            talker.step(LOOKS)
