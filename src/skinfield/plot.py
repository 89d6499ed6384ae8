"""Style of figures: paper, type, colours, words for numbers, saving, and pictures of objects."""

import base64
import io
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from html import escape
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import FileError, Floats, InputError, check_positive, needs

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Colormap, Normalize
    from matplotlib.figure import Figure


INK, QUIET, FAINT = "#1b1b1f", "#6b6b75", "#c9c9d1"
BLUE, ORANGE = "#0072b2", "#d55e00"  # Okabe and Ito: told apart by every kind of colour vision
# Both ramps fall in OKLab lightness by equal steps from the same white, so equal differences of
# the value look equal, in grey too; hue alone carries nothing but the sign.
ABOVE = ["#fcfaf6", "#f0d8b7", "#ebb27c", "#e9844c", "#e24d34"]
ABOVE += ["#bd2c4d", "#931157", "#5c185c", "#2c1648"]
BELOW = ["#fcfaf6", "#c9e8ec", "#9dd4df", "#72bed2", "#44a8c8"]
BELOW += ["#0690bb", "#0677a3", "#015e8b", "#014773"]
DPI = 160.0
TITLE: dict[str, Any] = {"fontsize": 12.5, "fontweight": "bold"}

RC: dict[str, Any] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same picture on every machine
    "font.size": 9.0,
    "text.parse_math": False,  # names of patches and files are text, whatever signs they hold
    "axes.edgecolor": QUIET,
    "axes.labelcolor": INK,
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.7,
    "axes.unicode_minus": True,
    "hatch.linewidth": 0.5,
    "image.interpolation": "nearest",
    "lines.linewidth": 1.4,
    "text.color": INK,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
}


def style() -> AbstractContextManager[None]:
    """Context in which a figure is drawn; the settings outside stay the caller's."""
    with _matplotlib():
        import matplotlib

    return matplotlib.rc_context(RC)  # type: ignore[arg-type]


def _matplotlib() -> AbstractContextManager[None]:
    """Context of an import of Matplotlib, which is an extra."""
    return needs("matplotlib", "skinfield[plot]", "figures")


def check_drawable() -> None:
    """Raise InputError where Matplotlib, an extra, is not installed."""
    with _matplotlib():
        if find_spec("matplotlib") is None:
            raise ModuleNotFoundError(name="matplotlib")


def new_figure(width: float = 9.6, height: float = 6.4) -> "Figure":
    """Empty white figure of the given inches at 160 dpi (1536 x 1024), free of any display."""
    with _matplotlib():
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


Place = Any  # Axes, a figure that is empty, or None for a figure of its own
EDGES = (0.75, 0.55, 0.25, 0.6)  # inches left, below, right and above of axes


def axes_for(
    place: Place,
    size: tuple[float, float],
    edges: tuple[float, float, float, float] = EDGES,
    **look: Any,
) -> Any:
    """Axes to draw in: those handed in, else new ones.

    Parameters
    ----------
    place : Axes, Figure or None
        A figure is made as large as the axes need; None makes one with pyplot, for notebooks.
    size : (width, height), inches
        Of new axes, without what stands around them.
    edges : (left, below, right, above), inches
    look
        Of new axes, such as ``projection="3d"``.

    Raises
    ------
    InputError
        For anything else, or if Matplotlib is not installed.
    """
    with _matplotlib():
        from matplotlib.axes import Axes
        from matplotlib.figure import Figure

    if isinstance(place, Axes):
        return place
    if place is None:
        from matplotlib import pyplot

        place = pyplot.figure(facecolor="white")
    if not isinstance(place, Figure):
        raise InputError(f"ax is {place!r:.60}, expected Matplotlib axes, such as plt.gca()")
    left, below, right, above = edges
    width, height = left + size[0] + right, below + size[1] + above
    place.set_size_inches(width, height)
    box = (left / width, below / height, size[0] / width, size[1] / height)
    return place.add_axes(box, **look)


def drawing(name: str) -> Callable[..., Any]:
    """Function that draws, by "module:function".

    Drawings import what they draw. An object's `plot` names its drawing, and so imports nothing.
    """
    module, _, function = name.partition(":")
    return getattr(import_module(module), function)  # type: ignore[no-any-return]


class Pictured:
    """What has a picture: `plot` draws it; notebooks show that, small, beside a table of facts."""

    def plot(self, ax: Place = None) -> Any:
        """Draw it; see the classes."""
        raise NotImplementedError

    def _facts(self) -> Mapping[str, str]:
        """Rows of the table, by their heads, units included."""
        raise NotImplementedError

    def _repr_html_(self) -> str:
        """Picture, where Matplotlib is installed, and table of facts."""
        words = facts_table(self)
        if find_spec("matplotlib") is None:
            return words
        return (
            f'<div style="display:flex;gap:1em;align-items:flex-start">{_inline(self)}{words}</div>'
        )


SHARPNESS = (110.0, 80.0, 60.0)  # dpi of a picture in a notebook, until it is small enough
LARGEST, TONES = 55_000, 160  # bytes of it, and colours
SHOWN = 76.0  # its pixels on a page, per inch
LONG = 300  # characters of a cell


def _inline(thing: Pictured) -> str:
    """Image of what is drawn."""
    from PIL import Image  # comes with Matplotlib

    figure, data = new_figure(), ""
    thing.plot(figure)
    canvas: Any = figure.canvas
    for dpi in SHARPNESS:
        figure.set_dpi(dpi)
        canvas.draw()
        picture = Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3])
        picture.quantize(TONES).save(file := io.BytesIO(), "png", optimize=True)
        data = base64.b64encode(file.getvalue()).decode()
        if len(data) <= LARGEST:
            break
    width = round(figure.get_figwidth() * SHOWN)
    alt = escape(repr(thing), quote=True)
    return f'<img style="flex:none" width="{width}" alt="{alt}" src="data:image/png;base64,{data}">'


def facts_table(thing: Pictured) -> str:
    """Table of what is known of an object, as HTML."""
    facts = {name: " ".join(text.split()) for name, text in thing._facts().items()}
    cut = {name: f"{text[:LONG]} …" for name, text in facts.items() if len(text) > LONG}
    return html_table([[name, text] for name, text in (facts | cut).items()])


def html_table(rows: list[list[str]], head: list[str] | None = None) -> str:
    """Table as HTML, whatever its cells hold; without `head` the first cell of a row is its own."""
    left = ' style="text-align:left"'
    lines = []
    if head is not None:
        cells = "".join(f"<th{left}>{escape(cell)}</th>" for cell in head)
        lines.append(f"<tr>{cells}</tr>")
    for row in rows:
        kinds = ["th" if head is None and not place else "td" for place in range(len(row))]
        pairs = zip(kinds, row, strict=True)
        cells = "".join(f"<{kind}{left}>{escape(cell)}</{kind}>" for kind, cell in pairs)
        lines.append(f"<tr>{cells}</tr>")
    return f"<table>{''.join(lines)}</table>"


def signed_colours(values: Floats) -> tuple["Colormap", "Normalize"]:
    """Colour map and scale for `values`: zero is white, darker is more, blue is below zero.

    One step of colour is the same amount of value on both sides of zero.
    """
    from matplotlib.colors import ListedColormap, Normalize, to_rgb

    finite = values[np.isfinite(values)]
    low, high = min(finite.min(initial=0.0), 0.0), max(finite.max(initial=0.0), 0.0)
    if not high > low:
        high = 1.0
    span = max(high, -low)
    anchors = np.array([to_rgb(colour) for colour in [*BELOW[:0:-1], *ABOVE]])  # -1 to 1
    levels = np.linspace(low, high, 512) / span
    place = np.linspace(-1.0, 1.0, len(anchors))
    rows = np.column_stack([np.interp(levels, place, channel) for channel in anchors.T])
    colours = ListedColormap(rows, "skinfield").with_extremes(bad="#e6e6ea")
    return colours, Normalize(low, high)


def add_title(axes: "Axes", letter: str, title: str, note: str = "") -> None:
    """Head a panel: its letter and title in bold, and under them a quiet line on how to read it."""
    from matplotlib.transforms import ScaledTranslation

    def raised(points: float) -> Any:
        lift = ScaledTranslation(0.0, points / 72.0, axes.figure.dpi_scale_trans)
        return axes.transAxes + lift

    head = f"{letter}   {title}" if letter else title
    axes.text(0, 1, head, transform=raised(18.0), fontsize=10, fontweight="bold", va="bottom")
    axes.text(0, 1, note, transform=raised(6.0), fontsize=7.5, color=QUIET, va="bottom")


def open_axes(axes: "Axes") -> None:
    """Draw a faint grid instead of a frame, for what goes on over time."""
    axes.grid(color=FAINT, lw=0.5, alpha=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(x=0.0)


def add_colour_bar(axes: "Axes", mappable: "ScalarMappable", label: str, **look: Any) -> Any:
    """Put a colour bar beside `axes`, as high as its picture."""
    figure: Any = axes.figure
    bar = figure.colorbar(mappable, cax=axes.inset_axes((1.03, 0.0, 0.035, 1.0)), **look)
    if not look:
        bar.ax.ticklabel_format(scilimits=(-3, 4))
    bar.set_label(label)
    bar.outline.set_linewidth(0.5)
    return bar


def number(value: float, digits: int = 3) -> str:
    """Write `value` with significant digits, a true minus and no exponent; a dash for NaN."""
    if not np.isfinite(value):
        return "–"
    return f"{value:.{_decimals(value, digits)}f}".replace("-", "−")


def duration(seconds: float) -> str:
    """Write a time such as 20.0 µs, 1.50 ms and 2.34 s, with three digits."""
    if seconds <= 0.0:
        return "0 µs"
    size, unit = next(
        (each for each in ((1.0, "s"), (1e-3, "ms")) if seconds >= 0.9995 * each[0]), (1e-6, "µs")
    )
    return f"{number(float(f'{seconds / size:.3g}'))} {unit}"


def plus_minus(value: float, std: float) -> str:
    """Write `value` ± `std` to the first digit of `std` that is not zero, or two of `value`."""
    if not (np.isfinite(std) and np.isfinite(value) and std > 0):
        return number(value)
    decimals = min(max(_decimals(std, 1), _decimals(value, 2)), _decimals(value, 4))
    return f"{value:.{decimals}f} ± {std:.{decimals}f}".replace("-", "−")


def _decimals(value: float, digits: int) -> int:
    size = int(np.floor(np.log10(abs(value)))) if value else digits - 1
    return int(np.clip(digits - 1 - size, 0, 6))


def plural(count: int, noun: str, several: str = "") -> str:
    """Write `1 contact`, `2 contacts`; or what stands for `several`."""
    return f"{count} {noun if count == 1 else several or noun + 's'}"


# What would make two runs differ is left out: dates, versions of the program that wrote it.
METADATA: dict[str, dict[str, Any] | None] = {
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    ".svg": {"Date": None, "Creator": "skinfield"},
    ".jpg": None,
    ".jpeg": None,
}


def check_name(path: str | Path) -> Path:
    """Raise InputError unless a figure can be saved under `path`, by its extension."""
    path = Path(path)
    if path.suffix.lower() not in METADATA:
        raise InputError(
            f"{str(path)!r} ends in {path.suffix!r}, expected one of {', '.join(METADATA)}: "
            "the extension chooses the format of a figure"
        )
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
    with _matplotlib():
        import matplotlib

    path = check_name(path)
    check_positive("dpi", dpi, "dots per inch of the picture")
    ending = path.suffix.lower()
    settings: Any = {"svg.hashsalt": "skinfield", "pdf.fonttype": 42}
    try:
        with matplotlib.rc_context(settings):
            figure.savefig(path, dpi=dpi, format=ending[1:], metadata=METADATA[ending])
    except (OSError, ValueError) as error:  # the latter of a zero byte in the name
        raise FileError(f"{str(path)!r} cannot be written: {error}") from error
    return path
