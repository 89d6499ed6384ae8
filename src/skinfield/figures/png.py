"""A figure as bytes, for pages that hold their pictures."""

from io import BytesIO
from typing import TYPE_CHECKING

from skinfield.figures.save import METADATA

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Figure

DPI = 130.0  # sharp on a tablet, and a page of a few megabytes


def png_of(figure: "Figure") -> bytes:
    """Bytes of a PNG file; the same figure gives the same bytes."""
    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI, metadata=METADATA[".png"])
    return buffer.getvalue()
