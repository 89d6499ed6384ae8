"""A figure as a file."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from skinfield.errors import FileError, InputError, check_positive

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# What would make two runs differ is left out: dates, versions of the program that wrote it.
METADATA: dict[str, dict[str, Any] | None] = {
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    ".svg": {"Date": None, "Creator": "skinfield"},
    ".jpg": None,
    ".jpeg": None,
}


def check_name(path: str | Path) -> Path:
    """Raise InputError unless a figure can be saved under `path`: its extension, and its folder."""
    path = Path(path)
    if path.suffix.lower() not in METADATA:
        raise InputError(
            f"{str(path)!r} ends in {path.suffix!r}, expected one of {', '.join(METADATA)}: "
            "the extension chooses the format of a figure"
        )
    try:
        there, taken = path.parent.is_dir(), path.is_dir()
    except (OSError, ValueError) as error:  # a name that is too long, a zero byte
        raise FileError(f"{str(path)!r} cannot be written: {error}; expected a path") from error
    if not there:
        raise FileError(
            f"{path} cannot be written: {path.parent} is no folder, expected one that is there"
        )
    if taken:
        raise FileError(f"{path} is a folder, expected the name of a figure")
    return path


def save(figure: "Figure", path: str | Path, *, dpi: float = 160.0) -> Path:
    """Write `figure` to `path` as PNG, PDF, SVG or JPEG, by extension; twice gives equal bytes.

    Parameters
    ----------
    figure : matplotlib Figure
    path : str or Path
        Ends in .png, .pdf, .svg, .jpg or .jpeg.
    dpi : float, 1/inch
        Resolution of PNG and JPEG, and of the pictures inside PDF and SVG.

    Returns
    -------
    Path
        Of the file.

    Raises
    ------
    InputError
        If the extension is another one.
    FileError
        If the file cannot be written.
    """
    import matplotlib

    path = check_name(path)
    check_positive("dpi", dpi, "dots per inch of the picture")
    ending = path.suffix.lower()
    settings: Any = {"svg.hashsalt": "skinfield", "pdf.fonttype": 42}
    try:
        with matplotlib.rc_context(settings):
            figure.savefig(path, dpi=dpi, format=ending[1:], metadata=METADATA[ending])
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror or error}") from error
    return path
