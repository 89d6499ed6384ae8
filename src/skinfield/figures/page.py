"""Where the four panels of an estimate stand on the page."""

from dataclasses import dataclass

import numpy as np

from skinfield.figures.maps import extent_of
from skinfield.layout import Grid

Box = tuple[float, float, float, float]  # left, bottom, width, height
SLENDER = 1.45  # height over width of a patch whose maps stand side by side
WIDTH, HEAD = 9.6, 0.83  # inches: of the page, and from its top to the upper maps


@dataclass(frozen=True)
class Page:
    """Size in inches, and the boxes of the panels in parts of it."""

    size: tuple[float, float]
    readings: Box
    pressure: Box
    deformation: Box
    contacts: Box
    heading: Box  # over the deformation, whose own box has no fixed edge to stand on


def page_of(grid: Grid) -> Page:
    """Page that suits the shape of what is shown: two rows of two, or the maps side by side."""
    width, height = np.ptp(extent_of(grid, measured=True), axis=0)
    ratio = float(height / width)
    return _side_by_side() if ratio > SLENDER else _two_rows(ratio)


def _two_rows(ratio: float) -> Page:
    high = float(np.clip(3.2 * ratio, 1.05, 2.46))
    size = (WIDTH, 3.1 + high + HEAD)
    return Page(
        size,
        readings=_parts(size, 0.67, 3.1, 3.2, high),
        pressure=_parts(size, 5.47, 3.1, 3.2, high),
        deformation=_parts(size, 0.3, 0.3, 3.8, 1.85),
        contacts=_parts(size, 5.47, 0.0, 4.05, 2.14),
        heading=_parts(size, 0.67, 0.0, 3.4, 2.14),
    )


def _side_by_side() -> Page:
    size = (WIDTH, 6.4)
    return Page(
        size,
        readings=_parts(size, 0.67, 0.61, 1.68, 4.96),
        pressure=_parts(size, 3.5, 0.61, 1.68, 4.96),
        deformation=_parts(size, 5.86, 3.27, 2.9, 2.3),
        contacts=_parts(size, 6.14, 0.0, 3.38, 2.14),
        heading=_parts(size, 6.14, 3.2, 3.38, 2.37),
    )


def _parts(
    size: tuple[float, float], left: float, bottom: float, width: float, height: float
) -> Box:
    return left / size[0], bottom / size[1], width / size[0], height / size[1]
