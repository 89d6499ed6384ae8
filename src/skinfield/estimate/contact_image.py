"""Image of a contact: pressure, outline and shape of one body, in the body's own frame."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skinfield.errors import Floats
from skinfield.plot import (
    ORANGE,
    Pictured,
    Place,
    add_colour_bar,
    add_title,
    axes_for,
    number,
    signed_colours,
    style,
)
from skinfield.skin import Patch

LEVEL = 0.5  # of the pressure that is typical within the contact: its outline
TYPICAL = 80.0  # percentile of the pressed cells
PRESSED = 0.05  # of the highest pressure: a cell that has more is pressed
CRUMB = 0.05  # of the largest part: what is smaller is no part of the outline


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ContactImage(Pictured):
    """Pressure of one body on a fine grid that moves along with it.

    Attributes
    ----------
    pressure : (ny, nx) array, Pa
        Under the force of the last reading.
    body_positions : (ny, nx, 2) array, m
        Of the cells in the body's frame.
    pose : (3,) array, m, m, rad
        (x, y, turn) of the body's frame in the patch's plane at the last reading. Of a motion that
        was not given, the frame is where the body was first felt, without turn.
    patch : Patch
    readings : int
        That the image was made of.
    misfit : float
        Mean square of what is left of the last reading, over its noise: near 1; far above it, the
        body has changed, or was lost.
    track_id : int
        The same for one body as long as it touches.
    stamp_ns : int, ns
        Of the last reading.
    deviation : function
        Without arguments: `pressure_std`.
    """

    pressure: Floats
    body_positions: Floats
    pose: Floats
    patch: Patch
    readings: int
    misfit: float
    track_id: int
    stamp_ns: int
    deviation: Callable[[], Floats]

    @property
    def cell(self) -> float:
        """Side of a cell, m."""
        return float(self.body_positions[0, 1, 0] - self.body_positions[0, 0, 0])

    @property
    def force(self) -> float:
        """Into the skin at the last reading, N."""
        return float(self.pressure.sum() * self.cell**2)

    @property
    def positions(self) -> Floats:
        """Of the cells at the last reading, on the skin: (ny, nx, 3) m in the patch's frame."""
        return self._on_skin(self.body_positions)

    @cached_property
    def level(self) -> float:
        """Pressure at the outline, Pa: half of what is typical within it."""
        pressed = self.pressure[self.pressure > PRESSED * self.pressure.max()]
        return float(LEVEL * np.percentile(pressed, TYPICAL)) if len(pressed) else np.inf

    @cached_property
    def body_outline(self) -> list[Floats]:
        """Closed polygons (N, 2) m in the body's frame, anticlockwise; holes run clockwise."""
        from contourpy import contour_generator

        if not np.isfinite(self.level):
            return []
        axis = self.body_positions[0, :, 0], self.body_positions[:, 0, 1]
        x, y = (np.r_[a[0] - self.cell, a, a[-1] + self.cell] for a in axis)
        lines = contour_generator(x, y, np.pad(self.pressure, 1)).lines(self.level)
        found = [np.asarray(line) for line in lines]
        most = max((_area(line) for line in found), default=0.0)
        return [line for line in found if abs(_area(line)) > CRUMB * most]

    @property
    def outline(self) -> list[Floats]:
        """Closed polygons (N, 3) m on the skin at the last reading, in the patch's frame."""
        return [self._on_skin(line) for line in self.body_outline]

    @property
    def area(self) -> float:
        """Within the outline, m²."""
        return float(sum(_area(line) for line in self.body_outline))

    @cached_property
    def _inside(self) -> Floats:
        """Cells (N, 2) m within the outline."""
        return np.asarray(self.body_positions[self.pressure >= self.level])

    @cached_property
    def _ellipse(self) -> tuple[Floats, float]:
        """Semi-axes (2,) m, and the angle of the first in the body's frame, rad."""
        if len(self._inside) < 3:
            return np.zeros(2), 0.0
        values, turn = np.linalg.eigh(np.cov(self._inside.T) + np.eye(2) * self.cell**2 / 12)
        ratio = np.sqrt(np.sqrt(values[1] / values[0]))
        round_ = np.sqrt(self.area / np.pi)
        return np.array([round_ * ratio, round_ / ratio]), float(np.arctan2(*turn[::-1, 1]))

    @property
    def axes(self) -> Floats:
        """Semi-axes (2,) m, the longer first, of the ellipse of equal area and like moments."""
        return self._ellipse[0]

    @property
    def angle(self) -> float:
        """From the plane's x to the longer axis at the last reading, -pi/2 to pi/2 rad."""
        return float((self._ellipse[1] + self.pose[2] + np.pi / 2) % np.pi - np.pi / 2)

    @property
    def convexity(self) -> float:
        """Area over that of the convex hull: 1 of a disc, some 0.6 of an L."""
        from scipy.spatial import ConvexHull

        if not self.body_outline:
            return float("nan")
        return self.area / float(ConvexHull(np.concatenate(self.body_outline)).volume)

    @cached_property
    def pressure_std(self) -> Floats:
        """One standard deviation of the pressure, (ny, nx) Pa, as if it could pull, too.

        By Laplace's method, on demand: it takes some 0.2 s.
        """
        return self.deviation()

    @property
    def confidence(self) -> Floats:
        """Probability, (ny, nx), that a cell is on its side of the outline: 0.5 to 1."""
        from scipy.special import ndtr

        return np.asarray(ndtr(np.abs(self.pressure - self.level) / self.pressure_std))

    def _on_skin(self, places: Floats) -> Floats:
        cos, sin = np.cos(self.pose[2]), np.sin(self.pose[2])
        plane = places.reshape(-1, 2) @ np.array([[cos, sin], [-sin, cos]]) + self.pose[:2]
        found = self.patch.surface.position_from_plane(plane)
        return np.asarray(found.reshape(*places.shape[:-1], 3))

    def __repr__(self) -> str:
        words = f"{number(self.force)} N on {number(self.area * 1e6)} mm²"
        return f"ContactImage({words}, {self.readings} readings, track {self.track_id})"

    def plot(self, ax: Place = None) -> Any:
        """Draw the pressure and its outline in the body's frame; lengths in mm, kPa.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            To draw in. Default those of a new figure.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        InputError
            If `ax` is something else, or Matplotlib is not installed.
        """
        rows, columns = self.pressure.shape
        half = np.array([-self.cell, self.cell]) / 2
        low, high = self.body_positions[0, 0] + half[0], self.body_positions[-1, -1] + half[1]
        with style():
            axes = axes_for(ax, (3.6, 3.6 * rows / columns), (0.75, 0.55, 0.9, 0.6))
            colours, scale = signed_colours(self.pressure * 1e-3)
            picture = axes.imshow(
                self.pressure * 1e-3, origin="lower", cmap=colours, norm=scale,
                extent=np.array([low[0], high[0], low[1], high[1]]) * 1e3,
            )  # fmt: skip
            for line in self.body_outline:
                axes.plot(*line.T * 1e3, color=ORANGE, lw=1.4)
            axes.set(xlabel="x of the body (mm)", ylabel="y of the body (mm)")
            add_colour_bar(axes, picture, "pressure (kPa)")
            words = f"{self.readings} readings" if self.readings > 1 else "one reading"
            add_title(axes, "", words, f"{number(self.force)} N; line: outline")
        return axes

    def _facts(self) -> Mapping[str, str]:
        long, short = (number(each * 1e3) for each in self.axes)
        return {
            "Contact image, force": f"{number(self.force)} N",
            "area": f"{number(self.area * 1e6)} mm²",
            "semi-axes": f"{long} and {short} mm",
            "convexity": number(self.convexity),
            "readings": str(self.readings),
            "misfit": number(self.misfit),
        }


def _area(polygon: Floats) -> float:
    """Signed area of a closed polygon (N, 2): positive anticlockwise."""
    x, y = polygon.T
    return float(0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
