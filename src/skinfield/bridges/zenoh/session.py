"""Zenoh session: keys of a part, addresses, and how it is opened."""

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote, unquote

from skinfield.bridges.settings import ZenohAddresses
from skinfield.errors import InputError

ROOT = "skinfield"
ALL_ALIVE = f"{ROOT}/*/*/alive"


@dataclass(frozen=True)
class Keys:
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
    def of(cls, key: str) -> "Keys":
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


if TYPE_CHECKING:
    import zenoh

INSTALL = "pip install 'skinfield[zenoh]'"
MEETING = "tcp/127.0.0.1:7457"  # where processes of one machine meet when no address is given
HERE = "tcp/127.0.0.1:0"
RETRY = {"period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 1.5}
_ENDPOINT = re.compile(r"(?:([a-z0-9-]+)/)?(\S+)")


@dataclass(frozen=True, kw_only=True)
class ZenohSettings:
    """How a process joins others; without an address, those on this machine alone.

    Parameters
    ----------
    listen, connect : tuple of str
        Addresses such as ``tcp/0.0.0.0:7447`` or ``robot:7447``. Without any, processes of this
        machine find each other, and nobody else does.
    config : Path, optional
        A configuration of zenoh (JSON5), which says what is not said here: certificates, access
        control, routers.
    """

    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    config: Path | None = None

    def __post_init__(self) -> None:
        for name in ("listen", "connect"):
            given = getattr(self, name)
            if isinstance(given, str):
                raise InputError(f"{name} is {given!r}, expected a tuple of addresses")
            object.__setattr__(self, name, tuple(_endpoint(name, each) for each in given))
        if self.config is not None and not Path(self.config).is_file():
            raise InputError(f"config is {str(self.config)!r}, expected a file of zenoh's settings")

    @property
    def local(self) -> bool:
        """Whether nothing says where to meet others: on this machine then."""
        return not (self.listen or self.connect or self.config)


def zenoh_session(given: ZenohAddresses) -> ZenohSettings:
    """How to meet others, of the settings of a command."""
    return ZenohSettings(
        listen=given.zenoh_listen,
        connect=given.zenoh_connect,
        config=None if given.zenoh_config is None else Path(given.zenoh_config),
    )


def _endpoint(name: str, text: object) -> str:
    """An address with its protocol."""
    found = _ENDPOINT.fullmatch(text) if isinstance(text, str) else None
    if not found or (found[1] is None and not re.search(r":\d+$", found[2])):
        raise InputError(
            f"{name} is {text!r}, expected an address such as tcp/192.168.0.7:7447, "
            "tls/robot:7447 or robot:7447"
        )
    return f"{found[1] or 'tcp'}/{found[2]}"


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
    if not settings.local:
        session = _opened(settings)
    else:
        try:  # the first one here is where the others meet; when it goes, the next one is
            session = _opened(replace(settings, listen=(MEETING,)))
        except InputError:
            session = _opened(replace(settings, listen=(HERE,), connect=(MEETING,)))
    try:
        yield session
    finally:
        session.close()


def _opened(settings: ZenohSettings) -> Any:
    zenoh, file, listen = load_zenoh(), settings.config, list(settings.listen)
    try:
        config = zenoh.Config() if file is None else zenoh.Config.from_file(str(file))
        for key, value in _values(listen, list(settings.connect), file is None).items():
            config.insert_json5(key, json.dumps(value))
        return zenoh.open(config)
    except zenoh.ZError as error:
        what = f"listening on {', '.join(listen)}" if listen else "with these settings"
        raise InputError(f"zenoh cannot start {what}: {_short(error)}") from error


def _values(listen: list[str], connect: list[str], alone: bool) -> dict[str, object]:
    """What goes into zenoh's configuration; a file's own values stay where nothing was given."""
    values: dict[str, object] = {}
    if alone:
        values |= {
            "mode": "peer",
            "scouting/multicast/enabled": False,
            "transport/shared_memory/enabled": False,  # leaves files when a process is killed
        }
    if listen or alone:
        values["listen/endpoints"] = listen
    if connect or alone:
        values["connect/endpoints"] = connect
    if listen:
        values["listen/exit_on_failure"] = True
    if connect:
        values["connect/exit_on_failure"] = False
        values["connect/timeout_ms"] = 0
        values["connect/retry"] = RETRY
    return values


def _short(error: object) -> str:
    """Without the places in zenoh's own sources."""
    text = re.sub(r" at /\S+", "", " ".join(str(error).split()))
    return text if len(text) < 300 else f"{text[:297]}..."
