"""Files that lie beside a live skin's ring."""

from pathlib import Path

from skinfield.ring.files import folder_of, path_of


def beside(name: str, what: str) -> Path:
    """Path of a file of the ring `name`; its own name is none that a ring can have.

    Raises
    ------
    InputError
        If no ring can have that name.
    """
    path_of(name, None)
    return folder_of(None) / f"skinfield-{what}.{name}"
