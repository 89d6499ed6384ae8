"""Where the page is served, and to whom."""

import hmac
import ipaddress
import secrets
from contextlib import suppress
from dataclasses import dataclass

from skinfield.errors import InputError, check_count, check_type

PORT = 8700


@dataclass(frozen=True)
class PageSettings:
    """Where the page is served, and to whom.

    Parameters
    ----------
    host : str
        Address of this machine that it listens on; others than the machine's own need a token.
    port : int
        0: any that is free.
    token : str
        That must be in the address of the page, `/?token=...`; empty: none is asked for.
    other_port : bool
        Whether another port will do if this one is taken.

    Raises
    ------
    InputError
        If others could reach it, and there is no token of 8 characters or more.
    """

    host: str = "127.0.0.1"
    port: int = PORT
    token: str = ""
    other_port: bool = False

    def __post_init__(self) -> None:
        check_type("host", self.host, str, "an address of this machine, such as 127.0.0.1")
        if self.host == "localhost":  # else two addresses, with a port of its own each
            object.__setattr__(self, "host", "127.0.0.1")
        check_count("port", self.port, 0, 65535, "of this machine; 0 lets the system choose")
        if not self.is_here and len(self.token) < 8:
            raise InputError(
                f"host is {self.host!r}, which others can reach, and token has "
                f"{len(self.token)} characters, expected 8 or more: whoever opens the page can "
                f"press, tare and record. For example --token {secrets.token_hex(12)}"
            )

    @property
    def is_here(self) -> bool:
        """Whether only this machine can reach it."""
        with suppress(ValueError):
            return ipaddress.ip_address(self.host.strip("[]")).is_loopback
        return self.host == "localhost"

    def allows(self, token: str) -> bool:
        """Whether this is the token, if one is asked for."""
        return not self.token or hmac.compare_digest(token.encode(), self.token.encode())
