"""How a process joins others over zenoh: addresses, certificates, who may read and write."""

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skinfield.bridges.zenoh.security import Access as Access
from skinfield.bridges.zenoh.security import Tls as Tls
from skinfield.errors import InputError, check_choice, check_type

if TYPE_CHECKING:
    import zenoh

INSTALL = "pip install 'skinfield[zenoh]'"
MODES = ("peer", "client", "router")
MEETING = "tcp/127.0.0.1:7457"  # where processes of one machine meet when no address is given
HERE = "tcp/127.0.0.1:0"
RETRY = {"period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 1.5}
_ENDPOINT = re.compile(r"(?:([a-z0-9-]+)/)?(\S+)")


@dataclass(frozen=True, kw_only=True)
class ZenohSettings:
    """How a process joins others; without an address, those on this machine alone.

    Parameters
    ----------
    mode : str
        "peer", "client" (of a router) or "router" (hands on between those who connect to it).
    listen, connect : tuple of str
        Addresses such as ``tcp/0.0.0.0:7447`` or ``robot:7447``. Without any, processes of this
        machine find each other, and nobody else does.
    config : Path, optional
        A configuration of zenoh (JSON5), which says what is not said here.
    tls : Tls, optional
        Then addresses without a protocol are taken as `tls`.
    access : Access, optional
    scouting : bool
        Whether to find others on the local network by multicast.
    compression : bool
        Whether messages are compressed, to those who do so too: fields are mostly zeros.
    """

    mode: str = "peer"
    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    config: Path | None = None
    tls: Tls | None = None
    access: Access | None = None
    scouting: bool = False
    compression: bool = False

    def __post_init__(self) -> None:
        check_choice("mode", self.mode, MODES, "how the process takes part")
        for name in ("listen", "connect"):
            given = getattr(self, name)
            if isinstance(given, str):
                raise InputError(f"{name} is {given!r}, expected a tuple of addresses")
            usual = "tls" if self.tls is not None else "tcp"
            object.__setattr__(self, name, tuple(_endpoint(name, each, usual) for each in given))
        if self.config is not None and not Path(self.config).is_file():
            raise InputError(f"config is {str(self.config)!r}, expected a file of zenoh's settings")

    @property
    def local(self) -> bool:
        """Whether nothing says where to meet others: on this machine then."""
        return not (self.listen or self.connect or self.config or self.scouting)

    def to_plain(self) -> dict[str, Any]:
        """Values for JSON, of which `from_plain` makes equal settings."""
        plain: dict[str, Any] = json.loads(json.dumps(asdict(self), default=str))
        return plain

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "ZenohSettings":
        """Undo `to_plain`.

        Raises
        ------
        InputError
            For what it never makes.
        """
        values = _known(cls, plain)
        if values.get("tls") is not None:
            made = _known(Tls, values["tls"])
            for name in ("ca", "certificate", "key"):
                made[name] = None if made.get(name) is None else Path(made[name])
            values["tls"] = Tls(**made)
        if values.get("access") is not None:
            values["access"] = Access(**_known(Access, values["access"]))
        if values.get("config") is not None:
            values["config"] = Path(values["config"])
        return cls(**values)


def _known(kind: Any, plain: object) -> dict[str, Any]:
    check_type("settings", plain, dict, f"the fields of {kind.__name__}")
    assert isinstance(plain, dict)
    names = [each.name for each in fields(kind)]
    strange = sorted(set(plain) - set(names))
    if strange:
        raise InputError(f"settings have {strange[0]!r}, expected some of {', '.join(names)}")
    return dict(plain)


def _endpoint(name: str, text: object, usual: str) -> str:
    """An address with its protocol."""
    found = _ENDPOINT.fullmatch(text) if isinstance(text, str) else None
    if not found or (found[1] is None and not re.search(r":\d+$", found[2])):
        raise InputError(
            f"{name} is {text!r}, expected an address such as tcp/192.168.0.7:7447, "
            "tls/robot:7447 or robot:7447"
        )
    return f"{found[1] or usual}/{found[2]}"


def load_zenoh() -> Any:
    """The package, or an error that says how to get it."""
    try:
        import zenoh
    except ImportError as error:
        raise InputError(f"zenoh is not installed, expected it: {INSTALL}") from error
    return zenoh


@contextmanager
def open_session(settings: ZenohSettings) -> "Iterator[zenoh.Session]":
    """A zenoh session as long as the block lasts.

    Raises
    ------
    InputError
        If zenoh is not installed, an address cannot be listened on, or a setting is refused. An
        address to connect to may be absent: it is tried again, once a second.
    """
    session = _opened(settings)
    try:
        yield session
    finally:
        session.close()


def _opened(settings: ZenohSettings) -> Any:
    zenoh = load_zenoh()
    if not settings.local:
        return _open(zenoh, settings, settings.listen, settings.connect)
    try:  # the first one on this machine is where the others meet; when it goes, the next one is
        return _open(zenoh, settings, (MEETING,), ())
    except InputError:
        return _open(zenoh, settings, (HERE,), (MEETING,))


def _open(zenoh: Any, settings: ZenohSettings, listen: Any, connect: Any) -> Any:
    try:
        config = zenoh.Config()
        if settings.config is not None:
            config = zenoh.Config.from_file(str(settings.config))
        for key, value in _values(settings, list(listen), list(connect)).items():
            config.insert_json5(key, json.dumps(value))
        return zenoh.open(config)
    except zenoh.ZError as error:
        what = f"listening on {', '.join(listen)}" if listen else "with these settings"
        raise InputError(f"zenoh cannot start {what}: {_short(error)}") from error


def _values(settings: ZenohSettings, listen: list[str], connect: list[str]) -> dict[str, object]:
    """What goes into zenoh's configuration; a file's own values stay where nothing was given."""
    values: dict[str, object] = {}
    if settings.config is None:
        values = {
            "mode": settings.mode,
            "listen/endpoints": listen,
            "connect/endpoints": connect,
            "scouting/multicast/enabled": settings.scouting,
            "transport/shared_memory/enabled": False,  # leaves files when a process is killed
            "transport/unicast/compression/enabled": settings.compression,
        }
    elif listen or connect:
        values = {"listen/endpoints": listen} if listen else {}
        values |= {"connect/endpoints": connect} if connect else {}
    if listen:
        values["listen/exit_on_failure"] = True
    if connect:
        values["connect/exit_on_failure"] = False
        values["connect/timeout_ms"] = 0
        values["connect/retry"] = RETRY
    if settings.tls is not None:
        values["transport/link/tls"] = settings.tls.values()
    if settings.access is not None:
        values["access_control"] = settings.access.values()
    return values


def _short(error: object) -> str:
    """Without the places in zenoh's own sources."""
    text = re.sub(r" at /\S+", "", " ".join(str(error).split()))
    return text if len(text) < 300 else f"{text[:297]}..."
