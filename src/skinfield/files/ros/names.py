"""Names that ROS 2 accepts: topics, and frames of links and contacts."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from skinfield.errors import InputError
from skinfield.skin import Patch, Skin

LONGEST_TOPIC = 247  # letters that every middleware of ROS 2 takes (RMW_TOPIC_MAX_NAME_LENGTH)
LONGEST = 80  # of a patch's part of it
TOKEN = re.compile(r"[A-Za-z_][0-9A-Za-z_]*")


def is_topic(name: str) -> bool:
    """Whether a full topic name keeps the rules of ROS 2.

    Notes
    -----
    https://design.ros2.org/articles/topic_and_service_names.html: tokens of letters, digits and
    single underscores that do not begin with a digit, each behind one slash.
    """
    tokens = name.split("/")
    good = tokens[0] == "" and len(tokens) > 1 and all(TOKEN.fullmatch(t) for t in tokens[1:])
    return good and "__" not in name and len(name) <= LONGEST_TOPIC


def check_prefix(prefix: str) -> str:
    """A beginning of topics such as `/skin` or `/robot/skin`.

    Raises
    ------
    InputError
        If it breaks the rules, or leaves no room for the rest.
    """
    if not is_topic(prefix) or len(prefix) > LONGEST:
        raise InputError(
            f"prefix is {prefix!r:.120}, expected a topic of ROS 2 such as /skin or /arm/skin: "
            f"letters, digits and single underscores, at most {LONGEST} letters"
        )
    return prefix


def token_of(name: str, lead: str = "patch") -> str:
    """A name as one token of a topic; what ROS does not allow becomes an underscore.

    `lead` comes before what would begin with a digit, or be nothing.
    """
    plain = re.sub(r"[^0-9A-Za-z]+", "_", name).strip("_")
    if not plain or plain[0].isdigit():
        plain = f"{lead}_{plain}"
    return plain[:LONGEST].rstrip("_")


def tokens_of(names: Iterable[str]) -> tuple[str, ...]:
    """Tokens of several names, all different: of like ones the later get a number."""
    found: list[str] = []
    for name in names:
        first = token = token_of(name)
        number = 1
        while token in found:
            number += 1
            token = f"{first[: LONGEST - 8]}_{number}"
        found.append(token)
    return tuple(found)


def frame_of(patch: Patch) -> str:
    """Frame in which a patch's messages are: its link, as the robot's description names it.

    A frame of ROS 2 does not begin with a slash.
    """
    return (patch.link or patch.name).lstrip("/") or token_of(patch.name)


@dataclass(frozen=True)
class Topics:
    """Names of everything that a skin says.

    Parameters
    ----------
    patches : tuple of str
        One token for each patch, in the skin's order.
    prefix : str
        Before all but `frames`, of the contacts, and `diagnostics`.
    """

    frames: ClassVar[str] = "/tf"
    diagnostics: ClassVar[str] = "/diagnostics"

    patches: tuple[str, ...]
    prefix: str = "/skin"

    def __post_init__(self) -> None:
        check_prefix(self.prefix)

    @classmethod
    def of(cls, skin: Skin, prefix: str = "/skin") -> "Topics":
        """Topics of a skin."""
        return cls(tokens_of(patch.name for patch in skin), prefix)

    def of_patch(self, place: int, what: str) -> str:
        """Topic of a patch: `taxels`, `counts`, `wrench`, `contact_wrench`."""
        return f"{self.prefix}/{self.patches[place]}/{what}"

    @property
    def contacts(self) -> str:
        """Topic of all contacts."""
        return f"{self.prefix}/contacts"

    def contact_frame(self, place: int, track: int) -> str:
        """Frame of a contact of a patch: at its place, z out of the skin.

        What the prefix has before its last part comes first: `/tf` is of all robots.
        """
        whose = self.prefix.split("/")[1:-1]
        return "_".join((*whose, self.patches[place], "contact", str(track)))
