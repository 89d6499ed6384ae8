"""Compiled functions of this folder are kept on disk; those of older sources must not be used."""

from pathlib import Path

FOLDER = Path(__file__).parent


def drop_stale(folder: Path = FOLDER) -> int:
    """Delete what was compiled before the newest source of a folder; returns how many files.

    Numba looks at the file of a function alone, not at those of the functions that it calls: after
    an update of some files of a checkout, it would go on with what they were.
    """
    newest = max((file.stat().st_mtime for file in folder.glob("*.py")), default=0.0)
    dropped = 0
    for file in (folder / "__pycache__").glob("*.nb[ic]"):
        try:
            if file.stat().st_mtime < newest:
                file.unlink()
                dropped += 1
        except OSError:  # another process was faster, or the folder is read-only
            continue
    return dropped
