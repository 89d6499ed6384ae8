"""Contacts and true presses drawn and named on a map, so that no words overlap."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats
from skinfield.fields import Contact
from skinfield.figures.maps import MM, plane_from_position
from skinfield.figures.presses import Press
from skinfield.figures.style import BLUE, INK, QUIET, number, plus_minus
from skinfield.layout import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.transforms import Bbox

DIRECTIONS = [(0, 1), (0, -1), (1, 0), (-1, 0), (0.7, 0.8), (-0.7, 0.8), (0.7, -0.8), (-0.7, -0.8)]
WORDS = 6  # contacts with force and area on the map; the others have their number


def draw_contacts(axes: "Axes", grid: Grid, contacts: Sequence[Contact]) -> None:
    """Draw outline, ellipse, centre and label of each contact; call once the limits are set."""
    from matplotlib.patches import Ellipse
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.6, foreground="white")]
    for contact in contacts:
        outline = plane_from_position(grid, contact.outline) * MM
        axes.plot(*outline.T, color=INK, lw=1.2, path_effects=halo, zorder=3)
        centre = plane_from_position(grid, contact.position[None])[0] * MM
        width, height = 2 * contact.axes * MM
        turn = np.degrees(contact.angle)
        axes.add_patch(
            Ellipse(centre, width, height, angle=turn, fill=False, ec=QUIET, lw=0.8, zorder=3)
        )
        axes.plot(*centre, "+", color=INK, ms=7, mew=1.3, path_effects=halo, zorder=4)
    _label_contacts(axes, grid, contacts)


def draw_presses(axes: "Axes", grid: Grid, presses: Sequence[Press]) -> None:
    """Draw each true press as a dashed circle of its radius."""
    from matplotlib.patches import Circle

    for press in presses:
        centre = plane_from_position(grid, press.position[None])[0] * MM
        axes.add_patch(
            Circle(centre, press.radius * MM, fill=False, ec=BLUE, lw=1.4, ls=(0, (3, 2)), zorder=5)
        )


def _label_contacts(axes: "Axes", grid: Grid, contacts: Sequence[Contact]) -> None:
    figure: Any = axes.figure
    renderer = figure.canvas.get_renderer()
    axes.apply_aspect()
    inside = axes.get_window_extent(renderer)
    bodies = [_body(axes, grid, contact) for contact in contacts]
    taken = list(bodies)
    for index, (contact, body) in enumerate(zip(contacts, bodies, strict=True)):
        for words, place in _candidates(index, contact, body, inside.width):
            text = axes.text(
                place[0], place[1], words, fontsize=8, ha="center", va="center", zorder=6
            )
            text.set_position(tuple(axes.transData.inverted().transform(place)))
            box = text.get_window_extent(renderer).padded(3.0)
            if _fits(box, inside, taken):
                taken.append(box)
                text.set_bbox({"fc": "white", "ec": "none", "alpha": 0.85, "pad": 1.2})
                break
            text.remove()


def _body(axes: "Axes", grid: Grid, contact: Contact) -> "Bbox":
    from matplotlib.transforms import Bbox

    points = np.vstack([contact.outline, contact.position[None]])
    pixels = axes.transData.transform(plane_from_position(grid, points) * MM)
    return Bbox(np.array([pixels.min(axis=0), pixels.max(axis=0)])).padded(4.0)


def _candidates(
    index: int, contact: Contact, body: "Bbox", room: float
) -> Iterator[tuple[str, Floats]]:
    """Words, the fullest first, and the pixel where their middle may stand, the nearest first."""
    force = plus_minus(contact.normal_force, contact.force_std)
    value, _, spread = force.partition(" ± ")
    area = f"{number(contact.area * 1e6)} mm²"
    name = f"{index + 1}"
    full = f"{name}: {value} N" + (f" ± {spread}" if spread else "")
    wordings = [f"{full}, {area}", f"{full}\n{area}", name] if index < WORDS else [name]
    middle = np.array([(body.x0 + body.x1) / 2, (body.y0 + body.y1) / 2])
    for words in wordings:
        lines = words.split("\n")
        half = np.array([4.9 * max(map(len, lines)), 11.0 * len(lines)])
        reach = np.array([body.width, body.height]) / 2 + half + 4
        for far in (1.0, 1.25, 1.6):
            if 2 * half[0] < room:
                yield from ((words, middle + far * reach * way) for way in np.array(DIRECTIONS))


def _fits(box: "Bbox", inside: "Bbox", taken: "list[Bbox]") -> bool:
    within = box.x0 > inside.x0 and box.x1 < inside.x1 and box.y0 > inside.y0 and box.y1 < inside.y1
    return within and not any(box.overlaps(other) for other in taken)
