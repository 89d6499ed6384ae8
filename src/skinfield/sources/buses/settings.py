"""Which bus, and where."""

from dataclasses import dataclass

from skinfield.errors import InputError, check_count, check_type

GROUP = "239.74.163.2"  # python-can's default group of IPv4
PORT = 43113  # python-can's default port
OWN = ("udp_multicast", "udp", "socketcan")  # interfaces that are read without python-can


@dataclass(frozen=True)
class BusSettings:
    """One CAN bus, or what stands for one.

    Parameters
    ----------
    interface : str
        `udp_multicast`: python-can's virtual bus between processes and machines. `udp`: the same
        datagrams to one address; needs no multicast. `socketcan`: Linux's own CAN. Any other name
        is an interface of python-can (`virtual`, `pcan`, `slcan`, `kvaser`, ...).
    channel : str
        Of `udp_multicast`, the group, of IPv4 (default 239.74.163.2) or IPv6. Of `udp`, the own
        address that is bound (default 127.0.0.1). Of `socketcan`, the device (default can0). Of
        python-can, what its interface calls channel.
    port : int
        Of `udp_multicast`, default 43113. Of `udp`, the own port that is bound; 0 takes a free one.
    peer : str
        Of `udp`: `host:port` to send to. Left empty, what is sent goes to whoever sent last.
    local : str
        Of `udp_multicast`: address (IPv6: name) of the own network interface; empty, the system
        chooses, and without any network the loopback. `127.0.0.1` keeps what is sent on this
        machine, where all members hear it.
    bitrate : int, bit/s
        Of adapters that python-can sets up; 0 leaves it as it is. SocketCAN's is set by `ip link`.
    options : tuple of (str, value)
        Further settings for python-can's own interfaces.
    """

    interface: str = "udp_multicast"
    channel: str = ""
    port: int = PORT
    peer: str = ""
    local: str = ""
    bitrate: int = 0
    options: tuple[tuple[str, str | int | float | bool], ...] = ()

    def __post_init__(self) -> None:
        for name in ("interface", "channel", "peer", "local"):
            check_type(name, getattr(self, name), str, "text")
        if not self.interface:
            raise InputError(
                "interface is '', expected udp_multicast, udp, socketcan or one of python-can's"
            )
        check_count("port", self.port, 0, 65535, "of UDP")
        check_count("bitrate", self.bitrate, 0, 20_000_000, "bit/s, 0 to leave it as it is")

    @property
    def label(self) -> str:
        """One word for tables: interface and channel."""
        return f"{self.interface}:{self.channel or self.port}"
