"""Where the C header is."""

from pathlib import Path


def include_folder() -> Path:
    """Folder of ``skinfield_ring.h``, for a C compiler's ``-I``."""
    return Path(__file__).parent
