"""All patches of one robot."""

from collections.abc import Iterator
from dataclasses import dataclass

from skinfield.errors import InputError
from skinfield.layout.patch import Patch


@dataclass(frozen=True, eq=False)
class Skin:
    """All patches of one robot; each patch knows its link and its pose there.

    Parameters
    ----------
    patches : sequence of Patch, or one Patch
        At least one, of distinct names.
    name : str
        Of the robot or of the file it came from.
    notes : sequence of str
        What the importer repaired or left out, in sentences.
    """

    patches: tuple[Patch, ...]
    name: str = "skin"
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        patches = (self.patches,) if isinstance(self.patches, Patch) else tuple(self.patches)
        object.__setattr__(self, "patches", patches)
        object.__setattr__(self, "notes", tuple(self.notes))
        names = [patch.name for patch in self.patches]
        if not names or len(set(names)) < len(names):
            raise InputError(f"patches are named {names}, expected one or more, each name once")

    def __iter__(self) -> Iterator[Patch]:
        return iter(self.patches)

    def __len__(self) -> int:
        return len(self.patches)

    def __getitem__(self, key: int | str) -> Patch:
        names = [patch.name for patch in self.patches]
        if isinstance(key, str):
            if key in names:
                return self.patches[names.index(key)]
        elif -len(self) <= key < len(self):
            return self.patches[key]
        raise InputError(
            f"patch {key!r} is not in {self.name!r}, expected one of {', '.join(names)} "
            f"or a number below {len(self)}"
        )
