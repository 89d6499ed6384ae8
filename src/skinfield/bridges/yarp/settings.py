"""Settings of the YARP bridge: what of a skin is published, and where."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from skinfield.errors import check_range
from skinfield.wire.can.bus import host_and_port
from skinfield.wire.yarp import PORT, NameServer, checked_name

HERE = "127.0.0.1"
NONE = "none"
USUAL = "robot"  # a robot that was not named


@dataclass(frozen=True, kw_only=True)
class YarpSettings:
    """What is published, where and how often.

    Parameters
    ----------
    robot : str
        Its name comes before the ports' of all robots but "robot".
    name_server : str, optional
        ``host:port``, where the ports are registered; default this machine's, port 10000;
        ``none``: nowhere, and then nobody can tell us to connect.
    port : str, optional
        Name of the port for contacts; default ``/skinfield/NAME/skin_events:o`` with the live
        skin's name, or ``/ROBOT/skinfield/NAME/...``. ``/skinManager/skin_events:o`` takes the
        place of skinManager's.
    host : str
        Address to listen at; empty for all of this machine.
    rate : float, 1/s
        Messages at most; the newest reading wins.
    parts : mapping of str to sequence of int
        Body part, link and skin part of patches whose names do not tell them.
    taxels : bool
        Whether what each patch's taxels read is published as well.
    """

    robot: str = USUAL
    name_server: str | None = None
    port: str | None = None
    host: str = ""
    rate: float = 100.0
    parts: Mapping[str, Sequence[int]] = field(default_factory=dict)
    taxels: bool = False

    def __post_init__(self) -> None:
        check_range("rate", self.rate, 0.1, 10_000.0, "messages per second")
        if self.port is not None:
            checked_name(self.port)
        self.server  # noqa: B018 - refuses an address that cannot be read

    @property
    def server(self) -> NameServer | None:
        """The name server; None for none."""
        text = self.name_server or HERE
        return None if text == NONE else NameServer(*host_and_port(text, HERE, PORT))

    def prefix(self, name: str) -> str:
        """Before the names of the ports, of the live skin of that name."""
        return f"/skinfield/{name}" if self.robot == USUAL else f"/{self.robot}/skinfield/{name}"
