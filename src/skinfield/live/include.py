"""Where the C header of live skins is."""

from pathlib import Path


def include_folder() -> Path:
    """Folder of ``skinfield_live.h``, for a C compiler's ``-I``; it finds the ring's by itself."""
    return Path(__file__).parent
