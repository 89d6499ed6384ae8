"""Settings of the page: where it is served, and to whom."""

import hmac
import ipaddress
import secrets
from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated

from skinfield.settings import Range, Section, SettingError

PORT = 8700  # where it is free
SHORTEST_TOKEN = 8  # characters


@dataclass(frozen=True, kw_only=True)
class PageSettings(Section):
    """Where the page is served, and to whom.

    Parameters
    ----------
    host : str
        Address of this machine to serve the page on; 0.0.0.0 lets others open it.
    port : int, optional
        Of the page; 0 lets the system choose. Default 8700, or another that is free.
    token : str
        That the page's address must hold, `/?token=...`: needed with another host.
    browser : bool
        Open the page in a browser.

    Raises
    ------
    InputError
        If others could reach it, and there is no token of 8 characters or more.
    """

    host: str = "127.0.0.1"
    port: Annotated[int | None, Range(0, 65535, "0 lets the system choose")] = None
    token: str = ""
    browser: bool = True

    def check(self) -> None:
        """See `Section`."""
        if self.host == "localhost":  # else two addresses, with a port of its own each
            object.__setattr__(self, "host", "127.0.0.1")
        if not self.is_here and len(self.token) < SHORTEST_TOKEN:
            raise SettingError(
                "host",
                f"is {self.host!r}, which others can reach, and token has {len(self.token)} "
                f"characters, expected {SHORTEST_TOKEN} or more: whoever opens the page can "
                f"press, tare and record. For example --token {secrets.token_hex(12)}",
            )

    @property
    def is_here(self) -> bool:
        """Whether only this machine can reach it."""
        with suppress(ValueError):
            return ipaddress.ip_address(self.host.strip("[]")).is_loopback
        return False

    def allows(self, token: str) -> bool:
        """Whether this is the token, if one is asked for."""
        return not self.token or hmac.compare_digest(token.encode(), self.token.encode())
