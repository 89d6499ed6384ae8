"""Keys of a live skin: `skinfield/ROBOT/PART/WHAT`, and of one of its patches below that."""

from dataclasses import dataclass
from urllib.parse import quote, unquote

from skinfield.errors import InputError

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
