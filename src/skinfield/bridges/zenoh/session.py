"""Zenoh session: keys of a part, settings with access and TLS, and how it is opened."""

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote, unquote

from skinfield.errors import InputError, check_choice

ROOT = "skinfield"
ALL_ALIVE = f"{ROOT}/*/*/alive"


@dataclass(frozen=True)
class Part:
    """One engine's place among the keys.

    Parameters
    ----------
    robot : str
    name : str
        Of the engine, as `skinfield run --name` has it.
    """

    robot: str
    name: str

    def __post_init__(self) -> None:
        for what in ("robot", "name"):
            if not getattr(self, what) or not isinstance(getattr(self, what), str):
                raise InputError(f"{what} is {getattr(self, what)!r}, expected a name")

    def __str__(self) -> str:
        return f"{self.robot}/{self.name}"

    def key(self, what: str) -> str:
        """Key of the engine's `estimate`, `contacts`, `status`, ..."""
        return f"{ROOT}/{chunk(self.robot)}/{chunk(self.name)}/{what}"

    def patch_key(self, patch: str, what: str) -> str:
        """Key of a patch's `contacts`, `raw` or `layout`."""
        return self.key(f"patch/{chunk(patch)}/{what}")

    @classmethod
    def of(cls, key: str) -> "Part":
        """Whose key it is.

        Raises
        ------
        InputError
            If it is none of a live skin.
        """
        chunks = key.split("/")
        if len(chunks) < 4 or chunks[0] != ROOT or len(key) > 1000:
            raise InputError(f"key is {key[:80]!r}, expected {ROOT}/ROBOT/PART/...")
        return cls(unquote(chunks[1]), unquote(chunks[2]))


def chunk(name: str) -> str:
    """A name as one chunk of a key: what is no letter, digit, or one of `_.-~` becomes %XX."""
    return quote(name, safe="")


# What one who reads does, and what reaches it; what one who writes does, and what it hears.
_ASKS = ["declare_subscriber", "query", "declare_liveliness_subscriber", "liveliness_query"]
_GIVES = ["put", "delete", "reply", "declare_queryable", "liveliness_token"]


@dataclass(frozen=True, kw_only=True)
class Tls:
    """Certificates, as PEM files.

    Parameters
    ----------
    ca : Path
        Of the authority that signed the certificates of all who take part.
    certificate, key : Path, optional
        Of this process; who listens needs them, and who connects to a `mutual` one.
    mutual : bool
        Whether who connects here must have a certificate of that authority too.
    verify_name : bool
        Whether the certificate of whom is connected to must name the address in use.
    """

    ca: Path
    certificate: Path | None = None
    key: Path | None = None
    mutual: bool = True
    verify_name: bool = True

    def __post_init__(self) -> None:
        for name in ("ca", "certificate", "key"):
            path = getattr(self, name)
            if path is not None and not Path(path).is_file():
                raise InputError(f"{name} is {str(path)!r}, expected a PEM file that exists")
        if (self.certificate is None) != (self.key is None):
            raise InputError("certificate and key belong together, expected both or none")

    def values(self) -> dict[str, object]:
        """Of zenoh's `transport/link/tls`."""
        found: dict[str, object] = {
            "root_ca_certificate": str(self.ca),
            "enable_mtls": self.mutual,
            "verify_name_on_connect": self.verify_name,
        }
        if self.certificate is not None:
            for side in ("listen", "connect"):
                found[f"{side}_certificate"] = str(self.certificate)
                found[f"{side}_private_key"] = str(self.key)
        return found


@dataclass(frozen=True, kw_only=True)
class Access:
    """Who may do what; whatever is not listed is denied. Needs certificates.

    Parameters
    ----------
    read : tuple of str
        Common names of the certificates of those who may read here.
    write : tuple of str
        Of those who may write here: from whom anything is taken.
    keys : tuple of str
        Key expressions; `**` does not match chunks that begin with `@`, so they are listed.
    """

    read: tuple[str, ...] = ()
    write: tuple[str, ...] = ()
    keys: tuple[str, ...] = ("skinfield/**",)

    def __post_init__(self) -> None:
        for name in ("read", "write", "keys"):
            values = tuple(getattr(self, name))
            if not all(isinstance(value, str) and value for value in values):
                raise InputError(f"{name} is {values!r}, expected texts that are not empty")
            object.__setattr__(self, name, values)

    def values(self) -> dict[str, object]:
        """Of zenoh's `access_control`."""
        rules, subjects, policies = [], [], []
        for what, names in (("read", self.read), ("write", self.write)):
            if not names:
                continue
            incoming, outgoing = (_ASKS, _GIVES) if what == "read" else (_GIVES, _ASKS)
            for flow, messages in (("ingress", incoming), ("egress", outgoing)):
                rules.append(
                    {
                        "id": f"{what}-{flow}",
                        "permission": "allow",
                        "flows": [flow],
                        "messages": messages,
                        "key_exprs": list(self.keys),
                    }
                )
            subjects.append({"id": f"may-{what}", "cert_common_names": list(names)})
            policies.append(
                {"rules": [f"{what}-ingress", f"{what}-egress"], "subjects": [f"may-{what}"]}
            )
        return {
            "enabled": True,
            "default_permission": "deny",
            "rules": rules,
            "subjects": subjects,
            "policies": policies,
        }


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
