"""What is wrong or worth knowing about a layout file."""

from dataclasses import dataclass
from typing import Literal

Severity = Literal["error", "warning", "info"]


@dataclass(frozen=True)
class Finding:
    """One thing found in a layout file.

    Parameters
    ----------
    code : str
        Short name of the kind, such as ``"inward-normals"``.
    severity : "error", "warning" or "info"
        An error states something false, so that the importer had to replace it or the user has to
        decide; a warning is imprecise or suspicious; an info says what was read or left out.
    message : str
        What was found, what it means, and what the importer does about it.
    rows : tuple of int
        Rows of the file's own table of taxels, from 0; empty when it concerns the whole file.
    """

    code: str
    severity: Severity
    message: str
    rows: tuple[int, ...] = ()
